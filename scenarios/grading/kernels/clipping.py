"""Kernel of the overlap of boxes: the corners of one are clipped at the sides of the other.

A box is (x, y, yaw, length, width) about its centre [m, rad].
"""

import numpy as np

from luxloop import elementary
from luxloop.arrays import Floats
from luxloop.compiled import kernel

SIGNS = ((1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0), (1.0, -1.0))
"""Corners counter-clockwise: front left, rear left, rear right, front right."""
VERTICES_MAX = 20
"""Space for vertices: an intersection has 8; rounding on collinear sides adds at most half at each of four clips."""


@kernel()
def clip(polygon: Floats, count: int, axis: int, sign: float, limit: float, clipped: Floats) -> int:
    """Clip the first `count` vertices of a convex polygon at sign * place <= limit along an axis; return the new count.

    Sutherland and Hodgman 1974; writes to `clipped` (`VERTICES_MAX`, 2).
    """
    kept = 0
    for i in range(count):
        j = (i + 1) % count
        here, there = limit - sign * polygon[i, axis], limit - sign * polygon[j, axis]
        if here >= 0.0:
            clipped[kept, 0], clipped[kept, 1] = polygon[i, 0], polygon[i, 1]
            kept += 1
        if here * there < 0.0:
            share = here / (here - there)
            for k in range(2):
                clipped[kept, k] = polygon[i, k] + share * (polygon[j, k] - polygon[i, k])
            kept += 1
    return kept


@kernel()
def shared_areas(a: Floats, b: Floats) -> Floats:
    """(N,) areas of the intersections of boxes `a` (N, 5) and `b` (N, 5), row by row [m^2]."""
    area, polygon, clipped = np.zeros(len(a)), np.empty((VERTICES_MAX, 2)), np.empty((VERTICES_MAX, 2))
    for n in range(len(a)):
        cos, sin = elementary.cos(a[n, 2]), elementary.sin(a[n, 2])
        dx, dy = b[n, 0] - a[n, 0], b[n, 1] - a[n, 1]
        x, y = cos * dx + sin * dy, cos * dy - sin * dx
        cos, sin = elementary.cos(b[n, 2] - a[n, 2]), elementary.sin(b[n, 2] - a[n, 2])
        for i in range(4):
            u, v = 0.5 * SIGNS[i][0] * b[n, 3], 0.5 * SIGNS[i][1] * b[n, 4]
            polygon[i, 0], polygon[i, 1] = x + cos * u - sin * v, y + sin * u + cos * v
        count = 4
        for axis in range(2):
            limit = 0.5 * a[n, 3 + axis]
            count = clip(polygon, count, axis, 1.0, limit, clipped)
            count = clip(clipped, count, axis, -1.0, limit, polygon)
        for i in range(count):
            j = (i + 1) % count
            area[n] += 0.5 * (polygon[i, 0] * polygon[j, 1] - polygon[j, 0] * polygon[i, 1])
    return area
