"""Static obstacles as vertical faces, one per side of a polygon."""

import math
from dataclasses import dataclass, replace

import numpy as np

from luxloop import elementary, elementwise
from luxloop.arrays import Floats, Ints
from luxloop.sim.world import Obstacles, Terrain

STRIDE = 20.0
"""[m] Distance the ego moves between two look-ups of nearby walls: long enough to be rare, short enough to stay few."""

LONGEST_M = 5.0
"""[m] Longest part of a wall that stands on uneven ground at one height: a step of 0.3 m at 6 %."""

_SHORTEST = 1e-6  # [m] shorter sides are repeated corners
_SLACK = 0.1  # [m] for rounding, and because mirrored rays start 1 mm off the mirror


@dataclass(frozen=True, slots=True, eq=False)
class Walls:
    """E vertical faces."""

    ends: Floats
    """(E, 4) x, y of both ends [m]."""
    z: Floats
    """(E, 2) heights of the lower and the upper edge [m]."""
    reflectivity: Floats
    """(E,) diffuse, 0 to 1."""

    def __len__(self) -> int:
        return len(self.ends)

    def __getitem__(self, rows: Ints) -> "Walls":
        return Walls(self.ends[rows], self.z[rows], self.reflectivity[rows])

    def seen_from(self, pose_world: Floats, ground_z: float = 0.0) -> "Walls":
        """Transform walls from the world frame to the frame of a pose (3,) x, y [m], yaw [rad] at a height [m]."""
        x, y = (self.ends.reshape(-1, 2) - pose_world[:2]).T
        cos, sin = elementary.cos(pose_world[2]), elementary.sin(pose_world[2])
        ends = np.stack([cos * x + sin * y, cos * y - sin * x], axis=1)
        return replace(self, ends=ends.reshape(-1, 4), z=self.z - ground_z if ground_z else self.z)


class NearbyWalls:
    """Cache of the walls near the ego, few of all walls in a city.

    It holds the walls around an earlier position of the ego, within a radius that exceeds the requested one.

    Parameters
    ----------
    walls_world
        All walls of the run, in the world frame.
    """

    def __init__(self, walls_world: Walls) -> None:
        self._all = walls_world
        one, other = walls_world.ends[:, :2], walls_world.ends[:, 2:]
        self._middle, self._half_length = 0.5 * (one + other), 0.5 * elementwise.hypot(*(other - one).T)
        self._place, self._radius, self._near = np.zeros(2), -math.inf, walls_world

    def seen_from(self, pose_world: Floats, reach: float, ground_z: float = 0.0) -> Walls:
        """Return walls in the frame of a pose (3,) x, y [m], yaw [rad]: all within a reach [m], and some others.

        The frame is at a height `ground_z` [m] of the world frame.

        The walls keep their order, which decides the wall a beam hits where walls coincide.
        """
        if math.dist(pose_world[:2], self._place) + reach > self._radius:
            self._place, self._radius = pose_world[:2].copy(), reach + STRIDE
            to_middle = elementwise.hypot(*(self._middle - self._place).T)
            self._near = self._all[np.flatnonzero(to_middle - self._half_length <= self._radius + _SLACK)]
        return self._near.seen_from(pose_world, ground_z)


def walls_of(obstacles: Obstacles) -> Walls:
    """Convert polygons to walls in the world frame; two points make one wall, sides of zero length are dropped.

    On uneven ground long sides are divided, and each part stands on the lower of its ends.
    """
    ends, polygon = [np.empty((0, 4))], []
    for index, (first, last) in enumerate(zip(obstacles.offset[:-1], obstacles.offset[1:], strict=True)):
        corners = obstacles.vertices_world[first:last]
        sides = np.hstack([corners, np.roll(corners, -1, axis=0)])[: None if len(corners) > 2 else 1]
        sides = sides[elementwise.hypot(*(sides[:, 2:] - sides[:, :2]).T) > _SHORTEST]
        ends.append(sides)
        polygon += [index] * len(sides)
    z = np.column_stack([obstacles.base, obstacles.height])
    walls = Walls(np.concatenate(ends), z[polygon], obstacles.reflectivity[polygon])
    return walls if obstacles.terrain is None else _raised(walls, obstacles.terrain)


def _raised(walls: Walls, terrain: Terrain) -> Walls:
    """Divide walls into parts of at most `LONGEST_M`, and raise each by the ground under it.

    The lower edge is above the lower end, so that no gap opens, and the upper edge above the middle.
    """
    one, other = walls.ends[:, :2], walls.ends[:, 2:]
    parts = np.ceil(elementwise.hypot(*(other - one).T) / LONGEST_M).astype(np.int64)
    row = np.repeat(np.arange(len(walls)), parts)
    number = np.arange(len(row)) - np.repeat(np.cumsum(parts) - parts, parts)
    begin, end = (one[row] + ((number + step) / parts[row])[:, None] * (other - one)[row] for step in (0, 1))
    low = np.minimum(terrain.height_at(begin), terrain.height_at(end))
    z = walls.z[row] + np.column_stack([low, terrain.height_at(0.5 * (begin + end))])
    return Walls(np.hstack([begin, end]), z, walls.reflectivity[row])
