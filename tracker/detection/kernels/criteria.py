"""Kernels of the criteria of rectangle fitting."""

import math

import numpy as np
from numba import njit

from tracker.arrays import Floats, Ints


@njit(cache=True)
def edge_distances(points: Floats, a: float, b: float, out: Floats) -> float:
    """Write the distance of each point to the nearer edge along direction (a, b) to `out`; return the extent along it.

    The nearer edge is chosen once for all points: of the distances to the two edges it is the one of smaller
    norm (Zhang 2017, algorithms 4 and 5), which is the edge closer to the mean.
    """
    low, high, mean = np.inf, -np.inf, 0.0
    for i in range(len(points)):
        out[i] = a * points[i, 0] + b * points[i, 1]
        low, high, mean = min(low, out[i]), max(high, out[i]), mean + out[i] / len(points)
    for i in range(len(points)):
        out[i] = high - out[i] if high - mean <= mean - low else out[i] - low
    return high - low


@njit(cache=True)
def criteria(points: Floats, angle: float, floor: float, d1: Floats, d2: Floats) -> tuple[float, float, float]:
    """Score a heading by area, closeness and variance (Zhang 2017, algorithms 3 to 5); higher is better."""
    cos, sin = math.cos(angle), math.sin(angle)
    area = edge_distances(points, cos, sin, d1) * edge_distances(points, -sin, cos, d2)
    closeness = 0.0
    n1, sum1, square1, n2, sum2, square2 = 0, 0.0, 0.0, 0, 0.0, 0.0
    for i in range(len(points)):
        closeness += 1.0 / max(min(d1[i], d2[i]), floor)
        if d1[i] < d2[i]:
            n1, sum1, square1 = n1 + 1, sum1 + d1[i], square1 + d1[i] ** 2
        elif d2[i] < d1[i]:
            n2, sum2, square2 = n2 + 1, sum2 + d2[i], square2 + d2[i] ** 2
    variance1 = max(0.0, square1 / n1 - (sum1 / n1) ** 2) if n1 else 0.0
    variance2 = max(0.0, square2 / n2 - (sum2 / n2) ** 2) if n2 else 0.0
    return -area, closeness, -variance1 - variance2


@njit(cache=True)
def best_headings(points: Floats, offset: Ints, grid: Floats, floor: float, halvings: int) -> Floats:
    """Headings (S, 3) that maximise each criterion: the best of the grid, then halvings of its step around it."""
    best = np.empty((len(offset) - 1, 3))
    step = grid[1] - grid[0]
    for s in range(len(offset) - 1):
        segment = points[offset[s] : offset[s + 1]]
        d1, d2 = np.empty(len(segment)), np.empty(len(segment))
        score = np.full(3, -np.inf)
        for angle in grid:
            value = criteria(segment, angle, floor, d1, d2)
            for c in range(3):
                if value[c] > score[c]:
                    score[c], best[s, c] = value[c], angle
        for c in range(3):
            width = step
            for _ in range(halvings):
                width /= 2.0
                middle = best[s, c]
                for angle in (middle - width, middle + width):
                    value = criteria(segment, angle, floor, d1, d2)
                    if value[c] > score[c]:
                        score[c], best[s, c] = value[c], angle
    return best
