"""Nearness of points to a set of points."""

import numpy as np

from luxloop.tracker.arrays import Bools, Floats
from luxloop.tracker.compiled import kernel

BLOCK = 64
"""Points that are compared at once, without branches: the compiler vectorises this."""


@kernel()
def any_within(points: Floats, others: Floats, radius: Floats) -> Bools:
    """(P,) mask of points (P, 2) with one of the others (Q, 2) within their radius (P,).

    The search begins in the block that the last one ended in: successive points are near each other, and so are others.
    """
    found, x, y = np.zeros(len(points), np.bool_), others[:, 0].copy(), others[:, 1].copy()
    blocks, block = (len(others) + BLOCK - 1) // BLOCK, 0
    for i in range(len(points)):
        at_x, at_y, limit = points[i, 0], points[i, 1], radius[i] ** 2
        for _ in range(blocks):
            own_x, own_y = x[BLOCK * block : BLOCK * (block + 1)], y[BLOCK * block : BLOCK * (block + 1)]
            near = 0
            for j in range(len(own_x)):
                near += (own_x[j] - at_x) ** 2 + (own_y[j] - at_y) ** 2 <= limit
            if near > 0:
                found[i] = True
                break
            block = (block + 1) % blocks
    return found
