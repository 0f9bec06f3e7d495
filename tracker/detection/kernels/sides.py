"""Kernels of the extents of rectangles."""

import math

import numpy as np

from luxloop.tracker.arrays import Floats, Ints
from luxloop.tracker.compiled import kernel
from luxloop.tracker.detection.kernels.groups import columns


@kernel(error_model="numpy")
def outermost(place: Floats, reach: Floats) -> tuple[float, float]:
    """Mean of the places (N,) on the lowest side, and on the highest one.

    Points of a side are within `reach` (N,) of its mean. The first iteration takes the points within `reach` of the
    outermost point, the outer half of the side; the second takes those within `reach` of their mean.
    """
    low, high = np.inf, -np.inf
    for i in range(len(place)):
        low, high = min(low, place[i]), max(high, place[i])
    for _ in range(2):
        low_sum, low_count, high_sum, high_count = 0.0, 0, 0.0, 0
        for i in range(len(place)):  # no branch: which points are on a side is hard to predict
            on_low, on_high = place[i] <= low + reach[i], place[i] >= high - reach[i]
            low_sum, low_count = low_sum + (place[i] if on_low else 0.0), low_count + on_low
            high_sum, high_count = high_sum + (place[i] if on_high else 0.0), high_count + on_high
        low, high = low_sum / low_count, high_sum / high_count
    return low, high


@kernel(error_model="numpy")
def extents(
    points: Floats, offset: Ints, heading: Floats, range_std: float, flatness: float, sigma: float
) -> tuple[Floats, Floats]:
    """Lowest and highest places (S, M, 2) of segments' sides along and across headings (S, M)."""
    low, high, (all_x, all_y) = np.empty((*heading.shape, 2)), np.empty((*heading.shape, 2)), columns(points)
    for s in range(len(heading)):
        x, y = all_x[offset[s] : offset[s + 1]], all_y[offset[s] : offset[s + 1]]
        place, reach, spread = np.empty(len(x)), np.empty(len(x)), np.empty(len(x))
        for i in range(len(x)):
            spread[i] = range_std / max(math.sqrt(x[i] * x[i] + y[i] * y[i]), flatness)
        for m in range(heading.shape[1]):
            for axis in range(2):
                cos, sin = math.cos(heading[s, m] + axis * math.pi / 2), math.sin(heading[s, m] + axis * math.pi / 2)
                for i in range(len(x)):
                    place[i] = cos * x[i] + sin * y[i]
                    reach[i] = sigma * math.sqrt((place[i] * spread[i]) ** 2 + flatness**2)
                low[s, m, axis], high[s, m, axis] = outermost(place, reach)
    return low, high
