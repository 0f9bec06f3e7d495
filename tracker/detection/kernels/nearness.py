"""Nearness of points to a set of points."""

import numpy as np

from tracker.arrays import Bools, Floats
from tracker.compiled import kernel


@kernel()
def any_within(points: Floats, others: Floats, radius: Floats) -> Bools:
    """(P,) mask of points (P, 2) with one of the others (Q, 2) within their radius (P,)."""
    found = np.zeros(len(points), np.bool_)
    for i in range(len(points)):
        x, y, limit = points[i, 0], points[i, 1], radius[i] ** 2
        for j in range(len(others)):
            if (others[j, 0] - x) ** 2 + (others[j, 1] - y) ** 2 <= limit:
                found[i] = True
                break
    return found
