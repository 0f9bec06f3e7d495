"""Static obstacles as upright faces, one for each side of a polygon."""

import math
from dataclasses import dataclass, replace

import numpy as np

from sensor_model.arrays import Floats, Ints
from sim.world import Obstacles

STRIDE = 20.0
"""[m] The ego goes as far before the walls around it are looked up again: seldom, but with few walls too many."""

_SHORTEST = 1e-6  # [m], a repeated corner
_SLACK = 0.1  # [m], for rounding, and as what a mirror shows starts 1 mm off it


@dataclass(frozen=True, slots=True, eq=False)
class Walls:
    """E upright faces."""

    ends: Floats
    """(E, 4) x, y of one end and x, y of the other [m]."""
    z: Floats
    """(E, 2) of the lower and of the upper edge above the ground [m]."""
    reflectivity: Floats
    """(E,) diffuse, 0 to 1."""

    def __len__(self) -> int:
        return len(self.ends)

    def __getitem__(self, rows: Ints) -> "Walls":
        return Walls(self.ends[rows], self.z[rows], self.reflectivity[rows])

    def seen_from(self, pose_world: Floats) -> "Walls":
        """Express walls of the world frame in the frame of a pose (3,) x, y [m], yaw [rad]."""
        x, y = (self.ends.reshape(-1, 2) - pose_world[:2]).T
        cos, sin = np.cos(pose_world[2]), np.sin(pose_world[2])
        ends = np.stack([cos * x + sin * y, cos * y - sin * x], axis=1)
        return replace(self, ends=ends.reshape(-1, 4))


class Vicinity:
    """The walls around the ego: in a city, only few of all.

    They are those near a place where the ego was a while ago, within a radius that is larger than asked for.

    Parameters
    ----------
    walls_world
        All walls of the run, in the world frame.
    """

    def __init__(self, walls_world: Walls) -> None:
        self._all = walls_world
        one, other = walls_world.ends[:, :2], walls_world.ends[:, 2:]
        self._middle, self._half_length = 0.5 * (one + other), 0.5 * np.hypot(*(other - one).T)
        self._place, self._radius, self._near = np.zeros(2), -math.inf, walls_world

    def seen_from(self, pose_world: Floats, reach: float) -> Walls:
        """Express walls in the frame of a pose (3,) x, y [m], yaw [rad]: all within a reach [m], and some others.

        Their order is that of all walls, which decides what a beam meets where walls coincide.
        """
        if math.dist(pose_world[:2], self._place) + reach > self._radius:
            self._place, self._radius = pose_world[:2].copy(), reach + STRIDE
            to_middle = np.hypot(*(self._middle - self._place).T)
            self._near = self._all[np.flatnonzero(to_middle - self._half_length <= self._radius + _SLACK)]
        return self._near.seen_from(pose_world)


def walls_of(obstacles: Obstacles) -> Walls:
    """Turn polygons into walls in the world frame; a polygon of two points is one wall, a side of no length none."""
    ends, polygon = [np.empty((0, 4))], []
    for index, (first, last) in enumerate(zip(obstacles.offset[:-1], obstacles.offset[1:], strict=True)):
        corners = obstacles.vertices_world[first:last]
        sides = np.hstack([corners, np.roll(corners, -1, axis=0)])[: None if len(corners) > 2 else 1]
        sides = sides[np.hypot(*(sides[:, 2:] - sides[:, :2]).T) > _SHORTEST]
        ends.append(sides)
        polygon += [index] * len(sides)
    z = np.column_stack([obstacles.base, obstacles.height])
    return Walls(np.concatenate(ends), z[polygon], obstacles.reflectivity[polygon])
