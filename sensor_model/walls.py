"""Static obstacles as upright faces, one for each side of a polygon."""

from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from sim.world import Obstacles

Floats = npt.NDArray[np.float64]

_SHORTEST = 1e-6  # [m], a repeated corner


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

    def seen_from(self, pose_world: Floats) -> "Walls":
        """Express walls of the world frame in the frame of a pose (3,) x, y [m], yaw [rad]."""
        x, y = (self.ends.reshape(-1, 2) - pose_world[:2]).T
        cos, sin = np.cos(pose_world[2]), np.sin(pose_world[2])
        ends = np.stack([cos * x + sin * y, cos * y - sin * x], axis=1)
        return replace(self, ends=ends.reshape(-1, 4))


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
