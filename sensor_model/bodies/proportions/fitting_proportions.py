"""What the bodies of many kinds have: windows and side mirrors."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class MirrorBox:
    """A side mirror [m]."""

    length: float
    protrusion: float
    """Beyond the width of the vehicle."""
    height: float
    z: float
    """Of its middle."""
    x: float
    """Of its middle, as a share of the vehicle's length in front of the box centre."""


@dataclass(frozen=True, slots=True)
class Glazing:
    """The part above the beltline."""

    windscreen_deg: float
    """From the horizontal."""
    backlight_deg: float
    """From the horizontal."""
    tumblehome_deg: float
    """Lean of the side windows, from the vertical."""
    shoulder: float
    """How far the foot of the side windows stands inside the vehicle's side [m]."""
    front_pillar: float
    """Width of the pillars beside the windscreen [m]."""
    rear_pillar: float
    """Width of the pillars beside the rear window [m]."""
    frame: float
    """Width of sheet metal around the roof: headers and rails [m]."""
