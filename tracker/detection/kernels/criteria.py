"""Kernels of the criteria of rectangle fitting.

Eight headings are scored together: the innermost loop runs over them, so that the compiler vectorises it without a
change of the order of any sum.
"""

import math

import numpy as np

from tracker.arrays import Floats, Ints
from tracker.compiled import kernel
from tracker.detection.kernels.hull import convex_hull
from tracker.detection.kernels.ordering import by_key

LANES = 8
"""Headings that are scored together."""
COS, SIN, EDGE_1, INWARD_1, EDGE_2, INWARD_2, CLOSENESS, COUNT_1, SUM_1, SQUARE_1, COUNT_2, SUM_2, SQUARE_2 = range(13)
"""Rows of the work array: direction; edge and its inward direction (1 or -1) along and across it; sums of points."""


@kernel()
def nearer_edge(outline: Floats, x: float, y: float, a: float, b: float) -> tuple[float, float, float]:
    """Return the edge along direction (a, b) that is nearer to the mean (x, y), 1 or -1 for inward, and the extent.

    The nearer edge is chosen once for all points: of the distances to the two edges it is the one of smaller
    norm (Zhang 2017, algorithms 4 and 5), which is the edge closer to the mean.
    """
    low, high, middle = np.inf, -np.inf, a * x + b * y
    for i in range(len(outline)):
        place = a * outline[i, 0] + b * outline[i, 1]
        low, high = min(low, place), max(high, place)
    return (high, -1.0, high - low) if high - middle <= middle - low else (low, 1.0, high - low)


@kernel(inline="always")
def add_distances(points: Floats, floor: float, work: Floats) -> None:
    """Add closeness, and the number, sum and sum of squares of distances to the nearer side, for each heading."""
    for i in range(len(points)):
        x, y = points[i, 0], points[i, 1]
        for k in range(LANES):
            d1 = work[INWARD_1, k] * (work[COS, k] * x + work[SIN, k] * y - work[EDGE_1, k])
            d2 = work[INWARD_2, k] * (work[COS, k] * y - work[SIN, k] * x - work[EDGE_2, k])
            first, second = 1.0 if d1 < d2 else 0.0, 1.0 if d2 < d1 else 0.0
            work[CLOSENESS, k] += 1.0 / max(min(d1, d2), floor)
            work[COUNT_1, k] += first
            work[SUM_1, k] += first * d1
            work[SQUARE_1, k] += first * d1 * d1
            work[COUNT_2, k] += second
            work[SUM_2, k] += second * d2
            work[SQUARE_2, k] += second * d2 * d2


@kernel(error_model="numpy")
def variance(count: float, total: float, square: float) -> float:
    """Variance of `count` numbers with this sum and this sum of squares; 0 without numbers."""
    return max(0.0, square / count - (total / count) ** 2) if count > 0.0 else 0.0


@kernel(error_model="numpy")
def criteria(points: Floats, outline: Floats, angle: Floats, floor: float, score: Floats) -> None:
    """Write area, closeness and variance (Zhang 2017, algorithms 3 to 5) of headings (LANES,) to (3, LANES).

    Higher is better. `outline` (H, 2) is the convex hull of the points (N, 2).
    """
    work, x, y = np.zeros((13, LANES)), 0.0, 0.0
    for i in range(len(points)):
        x, y = x + points[i, 0], y + points[i, 1]
    x, y = x / len(points), y / len(points)
    for k in range(LANES):
        cos, sin = math.cos(angle[k]), math.sin(angle[k])
        work[COS, k], work[SIN, k] = cos, sin
        work[EDGE_1, k], work[INWARD_1, k], length = nearer_edge(outline, x, y, cos, sin)
        work[EDGE_2, k], work[INWARD_2, k], width = nearer_edge(outline, x, y, -sin, cos)
        score[0, k] = -length * width
    add_distances(points, floor, work)
    for k in range(LANES):
        score[1, k] = work[CLOSENESS, k]
        score[2, k] = -variance(work[COUNT_1, k], work[SUM_1, k], work[SQUARE_1, k])
        score[2, k] -= variance(work[COUNT_2, k], work[SUM_2, k], work[SQUARE_2, k])


@kernel()
def keep_better(score: Floats, angle: Floats, first: int, last: int, highest: Floats, best: Floats, c: int) -> None:
    """Replace the best heading by criterion c, and its score, by those of a better one of lanes `first` to `last`."""
    for k in range(first, last):
        if score[c, k] > highest[c]:
            highest[c], best[c] = score[c, k], angle[k]


@kernel()
def best_headings(points: Floats, offset: Ints, grid: Floats, floor: float, halvings: int) -> Floats:
    """Headings (S, 3) that maximise each criterion: the best of the grid, then halvings of its step around it.

    Segment s has points offset[s] to offset[s + 1].
    """
    best, angle, score = np.empty((len(offset) - 1, 3)), np.empty(LANES), np.empty((3, LANES))
    order = by_key(points[:, 0].copy(), offset)
    for s in range(len(offset) - 1):
        segment, highest, width = points[offset[s] : offset[s + 1]], np.full(3, -np.inf), grid[1] - grid[0]
        outline = convex_hull(points, order[offset[s] : offset[s + 1]])
        for start in range(0, len(grid), LANES):
            for k in range(LANES):
                angle[k] = grid[min(start + k, len(grid) - 1)]
            criteria(segment, outline, angle, floor, score)
            for c in range(3):
                keep_better(score, angle, 0, LANES, highest, best[s], c)
        for _ in range(halvings):
            width /= 2.0
            for c in range(3):
                angle[2 * c], angle[2 * c + 1] = best[s, c] - width, best[s, c] + width
            criteria(segment, outline, angle, floor, score)
            for c in range(3):
                keep_better(score, angle, 2 * c, 2 * c + 2, highest, best[s], c)
    return best
