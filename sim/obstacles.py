"""Roadside obstacles made of upright prisms: buildings, walls, barriers, guard rails, poles.

The guard rail is the Midwest Guardrail System: the top of its W-beam is 787 mm above the ground, with a post W152x12.6
every 1905 mm (Wiebelhaus et al., "Development and Evaluation of the Midwest Guardrail System Placed Adjacent to a 2:1
Fill Slope", Midwest Roadside Safety Facility, 2010). The beam is 312 mm high (AASHTO M 180). The barrier is 32 inches
high, as a Jersey barrier. All other sizes and all reflectivities at 905 nm are estimates.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Literal

import numpy as np

from luxloop import elementwise
from luxloop.arrays import Floats
from luxloop.sim.world import Obstacles

StreetKind = Literal["building", "wall", "barrier", "fence", "guard-rail", "pole", "tree", "traffic-sign", "bollard"]


@dataclass(frozen=True, slots=True)
class ObstacleDefaults:
    """Default shape and size of one kind of obstacle."""

    form: Literal["outline", "line", "places"]
    """Meaning of the points: corners of the outline, course of a thin wall, or positions of single obstacles."""
    height: float
    """Upper edge above the ground [m]."""
    reflectivity: float
    """Diffuse reflectivity, 0 to 1."""
    diameter: float = 0.0
    """Diameter of each obstacle where points are positions [m]."""

    @property
    def points_min(self) -> int:
        """Minimum number of points."""
        return 1 if self.form == "places" else 2


DEFAULTS: dict[StreetKind, ObstacleDefaults] = {
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
"""A tree is its trunk and a sign its post: crowns and plates are above all beams within 50 m. A fence is solid
boards."""

W_BEAM_HEIGHT = 0.312
"""[m] Height of a guard rail's beam, from its lower to its upper edge."""
POST_SPACING = 1.905
"""[m] Distance between posts along a guard rail."""
POST_SIZE = (0.102, 0.152)
"""[m] Size of a guard rail's post W152x12.6, along and across the rail. The post ends at the lower edge of the beam."""

POLE_CORNERS = 8
_POLE_RADIUS = math.pi / (2 * POLE_CORNERS * math.sin(math.pi / POLE_CORNERS))
"""Circumradius over diameter: the polygon has the circle's circumference, hence its mean width over all directions."""


@dataclass(frozen=True, slots=True, eq=False)
class Prism:
    """Upright faces over the sides of a polygon."""

    corners: Floats
    """(K, 2) x, y in the world frame [m], closed implicitly; two corners make one face."""
    base: float
    """Height of the lower edge above the ground [m]."""
    height: float
    """Height of the upper edge above the ground [m]."""
    reflectivity: float
    """Diffuse reflectivity, 0 to 1."""


def build(
    kind: StreetKind,
    points: Floats,
    height: float | None = None,
    base: float = 0.0,
    diameter: float | None = None,
    reflectivity: float | None = None,
) -> list[Prism]:
    """Return the prisms of an obstacle, or of a row of obstacles.

    Parameters
    ----------
    kind
        Kind of obstacle.
    points
        (K, 2) in the world frame [m], see `ObstacleDefaults.form`. Consecutive duplicates count once.
    height, base
        Upper and lower edge above the ground [m]. A guard rail's base follows from its height.
    diameter
        Diameter of each pole [m].
    reflectivity
        Diffuse reflectivity, 0 to 1. None takes the default of the kind, as for the sizes.

    Raises
    ------
    ValueError
        There are too few points, or the sizes are invalid.
    """
    defaults = DEFAULTS[kind]
    points = points[np.append(True, np.any(np.diff(points, axis=0) != 0.0, axis=1))[: len(points)]]
    height = defaults.height if height is None else height
    base = max(height - W_BEAM_HEIGHT, 0.0) if kind == "guard-rail" else base
    diameter = defaults.diameter if diameter is None else diameter
    reflectivity = defaults.reflectivity if reflectivity is None else reflectivity
    _validate(kind, points, height, base, diameter, reflectivity)
    if defaults.form == "outline":
        outlines = [points]
    elif defaults.form == "line":
        outlines = [np.array(ends) for ends in pairwise(points)]
    else:
        outlines = [_octagon(place, diameter) for place in points]
    prisms = [Prism(corners, base, height, reflectivity) for corners in outlines]
    if kind == "guard-rail" and base > 0:
        prisms += [Prism(post, 0.0, base, reflectivity) for post in _posts(points)]
    return prisms


def obstacles(prisms: Sequence[Prism]) -> Obstacles:
    """Convert prisms to the world record."""
    return Obstacles.from_polygons(
        [prism.corners for prism in prisms],
        [prism.height for prism in prisms],
        [prism.reflectivity for prism in prisms],
        [prism.base for prism in prisms],
    )


def _validate(
    kind: StreetKind, points: Floats, height: float, base: float, diameter: float, reflectivity: float
) -> None:
    defaults = DEFAULTS[kind]
    if len(points) < defaults.points_min:
        raise ValueError(f"a {kind} needs at least {defaults.points_min} point{'s' * (defaults.points_min > 1)}")
    if not 0 <= base < height < math.inf:
        raise ValueError("its height must be positive and above its base, which must not be negative")
    if defaults.form == "places" and not 0 < diameter < math.inf:
        raise ValueError("its diameter must be positive")
    if not 0 <= reflectivity <= 1:
        raise ValueError("reflectivity must be between 0 and 1")


def _octagon(place: Floats, diameter: float) -> Floats:
    angle = (np.arange(POLE_CORNERS) + 0.5) * (2 * math.pi / POLE_CORNERS)
    return np.asarray(
        place + _POLE_RADIUS * diameter * np.column_stack([elementwise.cos(angle), elementwise.sin(angle)])
    )


def _posts(line: Floats) -> list[Floats]:
    """Return the outlines (4, 2) [m] of the posts of a guard rail, evenly spaced from its first end."""
    step = np.diff(line, axis=0)
    length = elementwise.hypot(*step.T)
    end = np.cumsum(length)
    along = np.arange(0.0, end[-1], POST_SPACING)
    piece = np.searchsorted(end, along, side="right")
    direction = (step / length[:, None])[piece]
    foot = line[piece] + direction * (along - end[piece] + length[piece])[:, None]
    across = np.column_stack([-direction[:, 1], direction[:, 0]])
    half_along, half_across = POST_SIZE[0] / 2 * direction, POST_SIZE[1] / 2 * across
    signs = ((1, 1), (-1, 1), (-1, -1), (1, -1))
    return list(np.stack([foot + i * half_along + j * half_across for i, j in signs], axis=1))
