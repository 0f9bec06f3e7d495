"""Pairs of pieces that together have the shape of one vehicle."""

import math

import numpy as np

from luxloop.tracker.arrays import Floats, Ints
from luxloop.tracker.compiled import kernel


@kernel()
def hull(center: Floats, heading: Floats, size: Floats, a: int, b: int) -> tuple[float, float, float, float]:
    """Return low x, low y, high x and high y of the box around two pieces, from and along the first one [m]."""
    cos, sin = math.cos(heading[a]), math.sin(heading[a])
    x, y = center[b, 0] - center[a, 0], center[b, 1] - center[a, 1]
    along, across = cos * x + sin * y, cos * y - sin * x
    cos, sin = abs(math.cos(heading[b] - heading[a])), abs(math.sin(heading[b] - heading[a]))
    length, width = 0.5 * (cos * size[b, 0] + sin * size[b, 1]), 0.5 * (sin * size[b, 0] + cos * size[b, 1])
    own_length, own_width = 0.5 * size[a, 0], 0.5 * size[a, 1]
    low = min(-own_length, along - length), min(-own_width, across - width)
    high = max(own_length, along + length), max(own_width, across + width)
    return low[0], low[1], high[0], high[1]


@kernel()
def fits(
    center: Floats, heading: Floats, size: Floats, a: int, b: int, length_max_m: float, width_max_m: float
) -> bool:
    """Return True if the box around two pieces has the size of a vehicle."""
    low_x, low_y, high_x, high_y = hull(center, heading, size, a, b)
    return high_x - low_x <= length_max_m and high_y - low_y <= width_max_m


@kernel()
def fitting_pairs(
    center: Floats, heading: Floats, size: Floats, length_max_m: float, width_max_m: float, turn_max_rad: float
) -> Ints:
    """(K, 2) pairs of T pieces, parallel or at right angles, that fit into one vehicle, in ascending order.

    Pieces have centres (T, 2) [m], headings (T,) and sizes (T, 2) [m].
    """
    pairs = []
    for a in range(len(heading)):
        for b in range(a + 1, len(heading)):
            near = math.hypot(center[b, 0] - center[a, 0], center[b, 1] - center[a, 1]) < length_max_m
            parallel = abs(math.sin(2.0 * (heading[b] - heading[a]))) <= 2.0 * turn_max_rad
            if near and parallel and fits(center, heading, size, a, b, length_max_m, width_max_m):
                pairs.append((a, b))
    found = np.empty((len(pairs), 2), np.int64)
    for k, pair in enumerate(pairs):
        found[k, 0], found[k, 1] = pair
    return found
