"""Centres of boxes, and points inside them."""

import math

import numpy as np

from luxloop.tracker.arrays import Bools, Floats, Ints
from luxloop.tracker.compiled import kernel


@kernel()
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


@kernel()
def centers(corner: Floats, sign: Ints, heading: Floats, size: Floats) -> Floats:
    """(B, 2) centres of boxes with corners (B, 2) of these signs (B, 2), headings (B,) and sizes (B, 2)."""
    center = np.empty((len(heading), 2))
    for b in range(len(heading)):
        cos, sin = math.cos(heading[b]), math.sin(heading[b])
        along, across = 0.5 * sign[b, 0] * size[b, 0], 0.5 * sign[b, 1] * size[b, 1]
        center[b, 0] = corner[b, 0] - (cos * along - sin * across)
        center[b, 1] = corner[b, 1] - (sin * along + cos * across)
    return center
