"""Points inside boxes."""

import math

import numpy as np
from numba import njit

from tracker.arrays import Bools, Floats


@njit(cache=True)
def inside(points: Floats, center: Floats, heading: Floats, size: Floats) -> Bools:
    """(P, B) mask of points (P, 2) inside boxes with centre (B, 2), heading (B,) and size (B, 2)."""
    within = np.empty((len(points), len(heading)), np.bool_)
    for b in range(len(heading)):
        cos, sin = math.cos(heading[b]), math.sin(heading[b])
        for p in range(len(points)):
            x, y = points[p, 0] - center[b, 0], points[p, 1] - center[b, 1]
            along, across = cos * x + sin * y, cos * y - sin * x
            within[p, b] = abs(along) <= 0.5 * size[b, 0] and abs(across) <= 0.5 * size[b, 1]
    return within
