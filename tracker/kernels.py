"""Points in boxes, and from the ego frame to the odometry frame: what detection and tracking share."""

import numpy as np

from luxloop import elementary
from luxloop.arrays import Bools, Floats
from luxloop.compiled import kernel


def inside(points: Floats, center: Floats, heading: Floats, size: Floats) -> Bools:
    """(P, B) mask of points (P, 2) inside boxes with centre (B, 2), heading (B,) and size (B, 2)."""
    return np.asarray(points_inside(np.ascontiguousarray(points, np.float64), center, heading, size))


@kernel()
def points_inside(points: Floats, center: Floats, heading: Floats, size: Floats) -> Bools:
    """(P, B) mask of points (P, 2) inside boxes with centre (B, 2), heading (B,) and size (B, 2)."""
    within = np.empty((len(points), len(heading)), np.bool_)
    for b in range(len(heading)):
        cos, sin = elementary.cos(heading[b]), elementary.sin(heading[b])
        for p in range(len(points)):
            x, y = points[p, 0] - center[b, 0], points[p, 1] - center[b, 1]
            along, across = cos * x + sin * y, cos * y - sin * x
            within[p, b] = abs(along) <= 0.5 * size[b, 0] and abs(across) <= 0.5 * size[b, 1]
    return within


@kernel()
def placed(points: Floats, pose: Floats) -> Floats:
    """(N, 2) points (N, 2 or more) of the ego frame in the odometry frame, in which the ego has a pose (3,)."""
    cos, sin = elementary.cos(pose[2]), elementary.sin(pose[2])
    found = np.empty((len(points), 2))
    for i in range(len(points)):
        found[i, 0] = cos * points[i, 0] - sin * points[i, 1] + pose[0]
        found[i, 1] = sin * points[i, 0] + cos * points[i, 1] + pose[1]
    return found
