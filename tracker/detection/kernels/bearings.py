"""Kernels of the order of points along an outline, and of even subsets of them."""

import math

import numpy as np

from luxloop.tracker.arrays import Floats, Ints
from luxloop.tracker.compiled import kernel
from luxloop.tracker.detection.kernels.ordering import by_key

SAME_BEARING = 1e-9
"""Weight of the range in the order of points, far below the angle between beams [rad/m]."""


@kernel(error_model="numpy")
def bearing_keys(points: Floats, offset: Ints) -> Floats:
    """(N,) keys that sort the points (N, 2 or more) of a segment by bearing from their mean, those of one by range.

    Segment s has points offset[s] to offset[s + 1].
    """
    key = np.empty(len(points))
    for s in range(len(offset) - 1):
        x, y, count = 0.0, 0.0, offset[s + 1] - offset[s]
        for i in range(offset[s], offset[s + 1]):
            x, y = x + points[i, 0], y + points[i, 1]
        x, y = x / count, y / count
        for i in range(offset[s], offset[s + 1]):
            across, ahead = x * points[i, 1] - y * points[i, 0], x * points[i, 0] + y * points[i, 1]
            key[i] = math.atan2(across, ahead) + SAME_BEARING * math.hypot(points[i, 0], points[i, 1])
    return key


@kernel()
def even_subset(points: Floats, offset: Ints, count: int) -> tuple[Ints, Ints]:
    """Return up to `count` points of each segment, evenly spaced along the outline that the ego sees.

    The order of the points of a segment has no effect: they are sorted by bearing from their mean.

    Parameters
    ----------
    points, offset
        (N, 2 or more) grouped by segment [m]; (S + 1,) first point of each segment, and N.

    Returns
    -------
    tuple
        Indices of the chosen points (K,), grouped by segment, and the first one of each segment (S + 1,), and K.
    """
    by_bearing, first = by_key(bearing_keys(points, offset), offset), np.zeros(len(offset), np.int64)
    chosen = np.empty(len(points), np.int64)
    for s in range(len(offset) - 1):
        size = offset[s + 1] - offset[s]
        kept = min(size, count)
        for rank in range(kept):
            chosen[first[s] + rank] = by_bearing[offset[s] + rank * size // kept]
        first[s + 1] = first[s] + kept
    return chosen[: first[-1]], first
