"""What stands along a road: buildings, walls, barriers, guard rails, poles. All of it is made of upright prisms.

The guard rail is the Midwest Guardrail System: the top of its W-beam 787 mm above the ground, a post W152x12.6 every
1905 mm (Wiebelhaus et al., "Development and Evaluation of the Midwest Guardrail System Placed Adjacent to a 2:1 Fill
Slope", Midwest Roadside Safety Facility, 2010); the beam is 312 mm high (AASHTO M 180). The barrier has the 32 inches
of a Jersey barrier. All other sizes are estimates, and so are all reflectivities at 905 nm.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Literal

import numpy as np

from sim.arrays import Floats
from sim.world import Obstacles

StreetKind = Literal["building", "wall", "barrier", "fence", "guard-rail", "pole", "tree", "traffic-sign", "bollard"]


@dataclass(frozen=True, slots=True)
class ObstacleDefaults:
    """What a kind of thing is like, unless told otherwise."""

    form: Literal["outline", "line", "places"]
    """What its points are: corners of its outline, the course of a thin wall, or where single ones of it stand."""
    height: float
    """Of the upper edge above the ground [m]."""
    reflectivity: float
    """Diffuse, 0 to 1."""
    diameter: float = 0.0
    """Of each where points are places [m]."""

    @property
    def points_min(self) -> int:
        """How many points it takes at least."""
        return 1 if self.form == "places" else 2


USUAL: dict[StreetKind, ObstacleDefaults] = {
    "building": ObstacleDefaults("outline", height=10.0, reflectivity=0.3),
    "wall": ObstacleDefaults("line", height=2.0, reflectivity=0.3),
    "barrier": ObstacleDefaults("line", height=0.81, reflectivity=0.3),
    "fence": ObstacleDefaults("line", height=1.8, reflectivity=0.3),
    "guard-rail": ObstacleDefaults("line", height=0.787, reflectivity=0.4),
    "pole": ObstacleDefaults("places", height=8.0, reflectivity=0.3, diameter=0.2),
    "tree": ObstacleDefaults("places", height=4.0, reflectivity=0.3, diameter=0.35),
    "traffic-sign": ObstacleDefaults("places", height=2.5, reflectivity=0.4, diameter=0.076),
    "bollard": ObstacleDefaults("places", height=1.0, reflectivity=0.4, diameter=0.12),
}
"""A tree is its trunk and a sign its post: crowns and plates are above all beams within 50 m. A fence is of boards."""

W_BEAM_HEIGHT = 0.312
"""[m] From the lower to the upper edge of a guard rail's beam."""
POST_SPACING = 1.905
"""[m] Along a guard rail."""
POST_SIZE = (0.102, 0.152)
"""[m] Of a guard rail's post W152x12.6, along the rail and across it. It ends where the beam begins."""

POLE_CORNERS = 8
_POLE_RADIUS = math.pi / (2 * POLE_CORNERS * math.sin(math.pi / POLE_CORNERS))
"""Of the corners, by diameter: the polygon has the circle's circumference, hence from all sides its mean width."""


@dataclass(frozen=True, slots=True, eq=False)
class Prism:
    """An upright face over each side of a polygon."""

    corners: Floats
    """(K, 2) x, y in the world frame [m], closed implicitly; two make one face."""
    base: float
    """Height of the lower edge above the ground [m]."""
    height: float
    """Height of the upper edge above the ground [m]."""
    reflectivity: float
    """Diffuse, 0 to 1."""


def build(
    kind: StreetKind,
    points: Floats,
    height: float | None = None,
    base: float = 0.0,
    diameter: float | None = None,
    reflectivity: float | None = None,
) -> list[Prism]:
    """Return what one thing, or a row of them, is made of.

    Parameters
    ----------
    kind
        What it is.
    points
        (K, 2) in the world frame [m], see `Usual.form`; one that is told twice in a row counts once.
    height, base
        Of its upper and lower edge above the ground [m]. A guard rail's base follows from its height.
    diameter
        Of each pole [m].
    reflectivity
        Diffuse, 0 to 1. Like the other sizes, the usual one if None.

    Raises
    ------
    ValueError
        Too few points, or the sizes make no body.
    """
    usual = USUAL[kind]
    points = points[np.append(True, np.any(np.diff(points, axis=0) != 0.0, axis=1))[: len(points)]]
    height = usual.height if height is None else height
    base = max(height - W_BEAM_HEIGHT, 0.0) if kind == "guard-rail" else base
    diameter = usual.diameter if diameter is None else diameter
    reflectivity = usual.reflectivity if reflectivity is None else reflectivity
    _require(kind, points, height, base, diameter, reflectivity)
    if usual.form == "outline":
        outlines = [points]
    elif usual.form == "line":
        outlines = [np.array(ends) for ends in pairwise(points)]
    else:
        outlines = [_octagon(place, diameter) for place in points]
    prisms = [Prism(corners, base, height, reflectivity) for corners in outlines]
    if kind == "guard-rail" and base > 0:
        prisms += [Prism(post, 0.0, base, reflectivity) for post in _posts(points)]
    return prisms


def obstacles(prisms: Sequence[Prism]) -> Obstacles:
    """Gather prisms into the world record."""
    return Obstacles.from_polygons(
        [prism.corners for prism in prisms],
        [prism.height for prism in prisms],
        [prism.reflectivity for prism in prisms],
        [prism.base for prism in prisms],
    )


def _require(
    kind: StreetKind, points: Floats, height: float, base: float, diameter: float, reflectivity: float
) -> None:
    usual = USUAL[kind]
    if len(points) < usual.points_min:
        raise ValueError(f"a {kind} takes at least {usual.points_min} point{'s' * (usual.points_min > 1)}")
    if not 0 <= base < height < math.inf:
        raise ValueError("its height must be positive and above its base, which must not be negative")
    if usual.form == "places" and not 0 < diameter < math.inf:
        raise ValueError("its diameter must be positive")
    if not 0 <= reflectivity <= 1:
        raise ValueError("reflectivity lies between 0 and 1")


def _octagon(place: Floats, diameter: float) -> Floats:
    angle = (np.arange(POLE_CORNERS) + 0.5) * (2 * math.pi / POLE_CORNERS)
    return np.asarray(place + _POLE_RADIUS * diameter * np.column_stack([np.cos(angle), np.sin(angle)]))


def _posts(line: Floats) -> list[Floats]:
    """Return the outlines (4, 2) [m] of the posts of a guard rail, evenly spaced from its one end on."""
    step = np.diff(line, axis=0)
    length = np.hypot(*step.T)
    end = np.cumsum(length)
    along = np.arange(0.0, end[-1], POST_SPACING)
    piece = np.searchsorted(end, along, side="right")
    direction = (step / length[:, None])[piece]
    foot = line[piece] + direction * (along - end[piece] + length[piece])[:, None]
    across = np.column_stack([-direction[:, 1], direction[:, 0]])
    half_along, half_across = POST_SIZE[0] / 2 * direction, POST_SIZE[1] / 2 * across
    signs = ((1, 1), (-1, 1), (-1, -1), (1, -1))
    return list(np.stack([foot + i * half_along + j * half_across for i, j in signs], axis=1))
