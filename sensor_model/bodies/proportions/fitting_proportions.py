"""Proportions shared by many kinds of vehicles: windows and side mirrors."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class MirrorBox:
    """A side mirror [m]."""

    length: float
    protrusion: float
    """Beyond the width of the vehicle."""
    height: float
    z: float
    """Height of its centre."""
    x: float
    """Position of its centre in front of the box centre, as a share of the vehicle's length."""


@dataclass(frozen=True, slots=True)
class Glazing:
    """The part above the beltline."""

    windscreen_deg: float
    """From the horizontal."""
    backlight_deg: float
    """From the horizontal."""
    tumblehome_deg: float
    """Inward lean of the side windows from the vertical."""
    shoulder: float
    """Inset of the foot of the side windows from the vehicle's side [m]."""
    front_pillar: float
    """Width of the pillars beside the windscreen [m]."""
    rear_pillar: float
    """Width of the pillars beside the rear window [m]."""
    frame: float
    """Width of sheet metal around the roof: headers and rails [m]."""


@dataclass(frozen=True, slots=True)
class Bow:
    """Curvature of an end in plan: sagittae of horizontal sections over 0.75 m to either side of the middle [m]."""

    lower: float
    """Below the bumper."""
    bumper: float
    upper: float
    """Between the bumper and the glass: grille and hood, or boot lid."""
    glass: float


SPAN_END, SPAN_SIDE = 0.75, 1.6
"""[m] Half lengths over which bows of ends and of sides are given, as in measurements on real cars."""
