"""Kernels of the extents of rectangles."""

import math

import numpy as np

from tracker.arrays import Floats, Ints
from tracker.compiled import kernel


@kernel(error_model="numpy")
def outermost(place: Floats, reach: Floats, sign: float) -> float:
    """Mean of the places (N,) on the outermost side in the direction of `sign`.

    Points of the side are within `reach` (N,) of its mean. The first iteration takes the points within `reach` of the
    outermost point, the outer half of the side; the second takes those within `reach` of their mean.
    """
    side = -np.inf
    for i in range(len(place)):
        side = max(side, sign * place[i])
    for _ in range(2):
        total, count = 0.0, 0
        for i in range(len(place)):
            if sign * place[i] >= side - reach[i]:
                total, count = total + sign * place[i], count + 1
        side = total / count
    return sign * side


@kernel(error_model="numpy")
def extents(
    points: Floats, offset: Ints, heading: Floats, range_std: float, flatness: float, sigma: float
) -> tuple[Floats, Floats]:
    """Lowest and highest places (S, M, 2) of segments' sides along and across headings (S, M)."""
    low, high = np.empty((*heading.shape, 2)), np.empty((*heading.shape, 2))
    for s in range(len(heading)):
        own = points[offset[s] : offset[s + 1]]
        place, reach, spread = np.empty(len(own)), np.empty(len(own)), np.empty(len(own))
        for i in range(len(own)):
            spread[i] = range_std / max(math.sqrt(own[i, 0] * own[i, 0] + own[i, 1] * own[i, 1]), flatness)
        for m in range(heading.shape[1]):
            for axis in range(2):
                cos, sin = math.cos(heading[s, m] + axis * math.pi / 2), math.sin(heading[s, m] + axis * math.pi / 2)
                for i in range(len(own)):
                    place[i] = cos * own[i, 0] + sin * own[i, 1]
                    reach[i] = sigma * math.sqrt((place[i] * spread[i]) ** 2 + flatness**2)
                low[s, m, axis] = outermost(place, reach, -1.0)
                high[s, m, axis] = outermost(place, reach, 1.0)
    return low, high
