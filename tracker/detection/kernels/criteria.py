"""Kernels of the criteria of rectangle fitting.

Eight headings are scored together: the innermost loop runs over them, so that the compiler vectorises it without a
change of the order of any sum.
"""

import math

import numpy as np

from luxloop.tracker.arrays import Floats, Ints
from luxloop.tracker.compiled import kernel
from luxloop.tracker.detection.kernels.hull import convex_hull
from luxloop.tracker.detection.kernels.ordering import by_key

LANES = 8
"""Headings that are scored together."""
COS, SIN, EDGE_1, INWARD_1, EDGE_2, INWARD_2, CLOSENESS, COUNT_1, SUM_1, SQUARE_1, COUNT_2, SUM_2, SQUARE_2 = range(13)
"""Rows of the work array: direction; edge and its inward direction (1 or -1) along and across it; sums of points."""


@kernel(inline="always")
def nearer_edges(outline: Floats, mean: tuple[float, float], work: Floats, score: Floats) -> None:
    """Write the edges nearer to the mean along and across each direction, 1 or -1 for inward, and minus the area.

    The nearer edge is chosen once for all points: of the distances to the two edges it is the one of smaller
    norm (Zhang 2017, algorithms 4 and 5), which is the edge closer to the mean.
    """
    x, y = mean
    low, high = np.empty((2, LANES)), np.empty((2, LANES))
    low[:], high[:] = np.inf, -np.inf
    for i in range(len(outline)):
        for k in range(LANES):
            along = work[COS, k] * outline[i, 0] + work[SIN, k] * outline[i, 1]
            across = work[COS, k] * outline[i, 1] - work[SIN, k] * outline[i, 0]
            low[0, k], high[0, k] = min(low[0, k], along), max(high[0, k], along)
            low[1, k], high[1, k] = min(low[1, k], across), max(high[1, k], across)
    for k in range(LANES):
        along, across = work[COS, k] * x + work[SIN, k] * y, work[COS, k] * y - work[SIN, k] * x
        beyond_1, beyond_2 = high[0, k] - along <= along - low[0, k], high[1, k] - across <= across - low[1, k]
        work[EDGE_1, k], work[INWARD_1, k] = high[0, k] if beyond_1 else low[0, k], -1.0 if beyond_1 else 1.0
        work[EDGE_2, k], work[INWARD_2, k] = high[1, k] if beyond_2 else low[1, k], -1.0 if beyond_2 else 1.0
        score[0, k] = -(high[0, k] - low[0, k]) * (high[1, k] - low[1, k])


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


@kernel()
def write_directions(angle: Floats, direction: Floats) -> None:
    """Write cosine and sine of headings (LANES,) to (2, LANES)."""
    for k in range(LANES):
        direction[0, k], direction[1, k] = math.cos(angle[k]), math.sin(angle[k])


@kernel(error_model="numpy")
def mean_of(points: Floats) -> tuple[float, float]:
    """Mean of points (N, 2)."""
    x, y = 0.0, 0.0
    for i in range(len(points)):
        x, y = x + points[i, 0], y + points[i, 1]
    return x / len(points), y / len(points)


@kernel(error_model="numpy")
def criteria(
    points: Floats, mean: tuple[float, float], outline: Floats, direction: Floats, floor: float, score: Floats
) -> None:
    """Write area, closeness and variance (Zhang 2017, algorithms 3 to 5) of headings to (3, LANES); higher is better.

    Headings are given by cosine and sine (2, LANES). `outline` (H, 2) is the convex hull of the points (N, 2).
    """
    work = np.zeros((13, LANES))
    for k in range(LANES):
        work[COS, k], work[SIN, k] = direction[0, k], direction[1, k]
    nearer_edges(outline, mean, work, score)
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
    best, score, batches = np.empty((len(offset) - 1, 3)), np.empty((3, LANES)), (len(grid) + LANES - 1) // LANES
    angle, direction = np.zeros((batches + 1, LANES)), np.empty((batches + 1, 2, LANES))  # the last ones for halvings
    for b in range(batches):
        for k in range(LANES):
            angle[b, k] = grid[min(b * LANES + k, len(grid) - 1)]
        write_directions(angle[b], direction[b])
    order = by_key(points[:, 0].copy(), offset)
    for s in range(len(offset) - 1):
        segment, highest, width = points[offset[s] : offset[s + 1]], np.full(3, -np.inf), grid[1] - grid[0]
        outline, mean = convex_hull(points, order[offset[s] : offset[s + 1]]), mean_of(segment)
        for b in range(batches):
            criteria(segment, mean, outline, direction[b], floor, score)
            for c in range(3):
                keep_better(score, angle[b], 0, LANES, highest, best[s], c)
        for _ in range(halvings):
            width /= 2.0
            for c in range(3):
                angle[batches, 2 * c], angle[batches, 2 * c + 1] = best[s, c] - width, best[s, c] + width
            write_directions(angle[batches], direction[batches])
            criteria(segment, mean, outline, direction[batches], floor, score)
            for c in range(3):
                keep_better(score, angle[batches], 2 * c, 2 * c + 2, highest, best[s], c)
    return best
