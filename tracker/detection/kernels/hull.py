"""Kernel of the convex hull of points."""

import numpy as np

from luxloop.tracker.arrays import Floats, Ints
from luxloop.tracker.compiled import kernel

SLACK_M2 = 1e-9
"""Area of the triangle with its neighbours, twice, within which a point is kept: rounding then drops no vertex."""


@kernel()
def convex_hull(points: Floats, order: Ints) -> Floats:
    """Vertices (H, 2) of the convex hull of some of the points (N, 2), by the monotone chain of Andrew (1979).

    `order` (K,) are the indices of these points by their x.
    """
    chain, count = np.empty((2 * len(order), 2)), 0
    for side in (1.0, -1.0):
        first = count
        for i in order:
            while count > first + 1:
                x, y = chain[count - 2, 0], chain[count - 2, 1]
                left = (chain[count - 1, 0] - x) * (points[i, 1] - y) - (chain[count - 1, 1] - y) * (points[i, 0] - x)
                if side * left > -SLACK_M2:
                    break
                count -= 1
            chain[count, 0], chain[count, 1] = points[i, 0], points[i, 1]
            count += 1
    return chain[:count]
