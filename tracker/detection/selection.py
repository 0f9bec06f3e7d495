"""Best selection: the heading of each segment, from its points or among the candidates."""

from dataclasses import dataclass
from typing import Literal

import numpy as np

from luxloop import elementary
from luxloop.arrays import Floats, Ints
from luxloop.compiled import kernel
from luxloop.tracker.detection import heading_posterior
from luxloop.tracker.detection.alignment import FLATNESS_M, REACH_M, align
from luxloop.tracker.detection.rectangles import measure
from luxloop.tracker.geometry import fold
from luxloop.tracker.records import Candidates, Linkage, SegmentedPoints


@dataclass(frozen=True, slots=True)
class SelectionConfig:
    """Cost of the selection."""

    variant: Literal["posterior", "alignment", "paper"] = "posterior"
    """`paper`: equation (3), the variance of the absolute residuals on the dominant line, among the four candidates.
    T-linkage's heading is that line's least-squares direction, so other candidates rarely win. `alignment`: alignment
    of all points of the segment along and across the heading; the best candidate is refined to the minimum.
    `posterior`: the mean of all headings, weighted by their likelihood. Change it to compare with the paper."""

    def __post_init__(self) -> None:
        if self.variant not in ("posterior", "alignment", "paper"):
            raise ValueError(f'variant is "{self.variant}"; give "posterior", "alignment" or "paper"')


def select(
    points: SegmentedPoints,
    linkage: Linkage,
    heading: Floats,
    config: SelectionConfig,
    range_std_m: float,
) -> Candidates:
    """Return the rectangles of headings (S, 4), of a refined one, their costs, and the best per segment.

    The last method, `refined`, is the best of the others with `paper`, the same turned to the highest alignment with
    `alignment`, and the mean of all headings with `posterior`, which always selects it and states its variance.
    `range_std_m` is the range noise [m].
    """
    variance = None
    if config.variant == "paper":
        cost = residual_variance(points, linkage, heading)
        cheapest = np.argmin(cost, axis=1)[:, None]
        refined, least = (np.take_along_axis(of, cheapest, axis=1) for of in (heading, cost))
        cost = np.hstack([cost, least])
    elif config.variant == "alignment":
        turned, cost = align(points.xy, points.offset, heading, REACH_M, FLATNESS_M)
        refined = turned[:, -1:]
    else:
        mean, variance = heading_posterior.average(points)
        refined, cost = mean[:, None], np.full((len(heading), heading.shape[1] + 1), np.nan)
    averaged = variance is not None or not len(cost)
    best = np.full(len(cost), cost.shape[1] - 1) if averaged else np.nanargmin(cost, axis=1)
    heading = np.concatenate([heading, fold(refined)], axis=1)
    center, size = measure(points, linkage, heading, range_std_m)
    return Candidates(heading=heading, center_ego=center, size=size, cost=cost, best=best, heading_variance=variance)


def residual_variance(points: SegmentedPoints, linkage: Linkage, heading: Floats) -> Floats:
    """Equation (3) for headings (S, M): variance of the absolute residuals on the dominant line [m^2].

    A residual is the distance of a point to the side of the rectangle along the line, moved to the median of the line.
    (3) does not define the offset c of H; at the edge of a tight rectangle all residuals have the same sign, the
    absolute value has no effect, and least squares always wins.
    """
    dominant, offset = points.chosen(linkage.line.take(points.source) == 0)
    distance = side_distances(dominant, offset, heading)
    count = np.diff(offset)[:, None]
    mean, square = (np.add.reduceat(power, offset[:-1]) / count for power in (distance, distance**2))
    return np.asarray(square - mean**2)


@kernel(error_model="numpy")
def side_distances(points: Floats, offset: Ints, heading: Floats) -> Floats:
    """(N, M) distance of points to the side of a rectangle along their line, moved to the median of the line.

    Line g has points offset[g] to offset[g + 1] and candidate headings (G, M). The side has the direction of the
    rectangle across which the points spread less.
    """
    distance = np.empty((len(points), heading.shape[1]))
    for g in range(len(offset) - 1):
        x, y = points[offset[g] : offset[g + 1], 0], points[offset[g] : offset[g + 1], 1]
        for m in range(heading.shape[1]):
            cos, sin = elementary.cos(heading[g, m]), elementary.sin(heading[g, m])
            along, across = cos * x + sin * y, cos * y - sin * x
            place = across if across.std() <= along.std() else along
            distance[offset[g] : offset[g + 1], m] = np.abs(place - np.median(place))
    return distance
