"""Candidate rectangles of segments: a heading by each method, and the extents of its lines."""

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np

from luxloop import elementary
from luxloop.arrays import Floats, Ints
from luxloop.compiled import kernel
from luxloop.tracker.detection.faces import FLATNESS_M
from luxloop.tracker.detection.point_groups import by_key, columns
from luxloop.tracker.geometry import fold, rotate
from luxloop.tracker.records import Linkage, SegmentedPoints

STEP_DEG = 1.0
"""Step of the heading grid [deg]."""
SIDE_SIGMA = 2.4
"""Half-width of a side in standard deviations: of 20 to 100 points the outermost is 2 to 2.6 off."""
LANES = 8
"""Headings that are scored together."""
COS, SIN, EDGE_1, INWARD_1, EDGE_2, INWARD_2, CLOSENESS, COUNT_1, SUM_1, SQUARE_1, COUNT_2, SUM_2, SQUARE_2 = range(13)
"""Rows of the work array: direction; edge and its inward direction (1 or -1) along and across it; sums of points."""
SLACK_M2 = 1e-9
"""Area of the triangle with its neighbours, twice, within which a point is kept: rounding then drops no vertex."""


@dataclass(frozen=True, slots=True)
class RectangleConfig:
    """Heading search by the three criteria of Zhang 2017."""

    halvings: int = 5
    """Halvings of the grid's step around the best heading: five give 1/32. Set 0 for the grid only, as published."""
    closeness_floor_m: float = 0.01
    """Lower limit d0 of a distance in the closeness criterion [m]. Raise it to the noise of the unit."""
    points: Literal["all", "lines"] = "all"
    """Points of the criteria: `all` of the segment, as published, or those on its `lines`.
    Change it to see what outliers cost the criteria."""

    def __post_init__(self) -> None:
        if not 0 <= self.halvings <= 30:
            raise ValueError(f"halvings is {self.halvings}; give 0 for the grid only, or up to 30")
        if self.closeness_floor_m <= 0.0:
            raise ValueError(f"closeness_floor_m is {self.closeness_floor_m}; give a positive distance in metres")


def headings(points: SegmentedPoints, linkage: Linkage, config: RectangleConfig) -> Floats:
    """(S, 4) heading of each segment by area, closeness, variance and T-linkage, in [0, pi/2).

    The criteria use all points by default, which makes them sensitive to mirrors, as published.
    """
    line = linkage.line.take(points.source)
    xy, offset = points.chosen(line >= 0) if config.points == "lines" else (points.xy, points.offset)
    grid = np.deg2rad(np.arange(0.0, 90.0, STEP_DEG))
    by_criteria = best_headings(xy, offset, grid, config.closeness_floor_m, config.halvings)
    return fold(np.column_stack([by_criteria, linkage.heading]))


def measure(points: SegmentedPoints, linkage: Linkage, heading: Floats, range_std_m: float) -> tuple[Floats, Floats]:
    """Return centre and size (S, M, 2) [m] of rectangles at headings (S, M) around the points on lines, at least one.

    Sides are measured on the points on lines only, so that a mirror or a window does not enlarge the rectangle. A side
    is at the mean of the outermost points, because noise puts the outermost one outside the body. Range noise
    `range_std_m` [m] is along the beam: across a side, it is scaled by the cosine of the angle between beam and normal.
    """
    xy, offset = points.chosen(linkage.line.take(points.source) >= 0)
    low, high = extents(xy, offset, heading, range_std_m, FLATNESS_M, SIDE_SIGMA)
    return rotate(0.5 * (low + high), heading), high - low


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
        direction[0, k], direction[1, k] = elementary.cos(angle[k]), elementary.sin(angle[k])


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
                cos, sin = (
                    elementary.cos(heading[s, m] + axis * math.pi / 2),
                    elementary.sin(heading[s, m] + axis * math.pi / 2),
                )
                for i in range(len(x)):
                    place[i] = cos * x[i] + sin * y[i]
                    reach[i] = sigma * math.sqrt((place[i] * spread[i]) ** 2 + flatness**2)
                low[s, m, axis], high[s, m, axis] = outermost(place, reach)
    return low, high
