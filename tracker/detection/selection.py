"""Best selection: choose among the candidate headings and refine the best."""

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np
import numpy.typing as npt

from luxloop.tracker.arrays import Floats, Ints
from luxloop.tracker.compiled import kernel
from luxloop.tracker.detection import body_fit
from luxloop.tracker.detection.alignment import align
from luxloop.tracker.detection.body_fit import BodyFitConfig
from luxloop.tracker.detection.rectangles import Rectangles, measure
from luxloop.tracker.detection.segmentation import by_segment, positions
from luxloop.tracker.geometry import fold
from luxloop.tracker.records import Candidates, Linkage, Segments


@dataclass(frozen=True, slots=True)
class SelectionConfig:
    """Cost of the selection."""

    variant: Literal["body", "alignment", "paper"] = "body"
    """`paper`: equation (3), the variance of the absolute residuals on the dominant line, among the four candidates.
    T-linkage's heading is that line's least-squares direction, so other candidates rarely win. `alignment`: alignment
    of all points of the segment along and across the heading; the best candidate is refined to the minimum. `body`: a
    body with bowed faces is fitted from the best aligned candidates, see `[tracker.body]`."""
    reach_m: float = 0.08
    """Spread of points across a perpendicular side [m], as `linkage.tau_m`: two steps of the LUX's resolution.
    Range noise is along the beam: across an oblique side there is less of it."""
    flatness_m: float = 0.03
    """Spread across a side at grazing incidence [m], without range noise. A LUX beam is 2.8 cm wide at 20 m, a standard
    deviation of 0.8 cm, and panels are flat to the same amount."""

    def __post_init__(self) -> None:
        if self.variant not in ("body", "alignment", "paper"):
            raise ValueError(f'variant is "{self.variant}"; give "body", "alignment" or "paper"')
        if min(self.reach_m, self.flatness_m) <= 0.0:
            raise ValueError("reach_m and flatness_m must be positive distances in metres")


def select(
    points_ego: npt.NDArray[np.floating],
    segments: Segments,
    linkage: Linkage,
    rectangles: Rectangles,
    config: SelectionConfig,
    body: BodyFitConfig | None = None,
    scan_line: Ints | None = None,
) -> Candidates:
    """Return the cost of every rectangle for points (N, 2 or more columns), and the best per segment.

    The last method, `refined`, is the best of the others; `alignment` refines its heading, `body` fits it, `paper` does
    not. `body` always selects it.

    Parameters
    ----------
    body
        Settings of the variant `body`.
    scan_line
        (N,) scan line of each point, 0 and up, for `body`; None if unknown.
    """
    covariance = None
    if config.variant == "paper":
        heading, cost = rectangles.heading, residual_variance(points_ego, segments, linkage, rectangles.heading)
        cheapest = np.argmin(cost, axis=1)[:, None]
        heading, cost = (np.hstack([of, np.take_along_axis(of, cheapest, axis=1)]) for of in (heading, cost))
    elif config.variant == "alignment":
        order, offset = by_segment(segments)
        points = positions(points_ego, order)
        heading, cost = align(points, offset, rectangles.heading, config.reach_m, config.flatness_m)
    else:
        lines = np.zeros(len(points_ego), dtype=np.int64) if scan_line is None else scan_line
        found = body_fit.fit(
            points_ego, lines, segments, rectangles.heading, config.reach_m, config.flatness_m, body or BodyFitConfig()
        )
        covariance = found.covariance
        heading = np.concatenate([rectangles.heading, found.heading[:, None]], axis=1)
        cost = np.full(heading.shape, np.nan)
        cost[:, -1] = found.cost
    fitted = covariance is not None or not len(cost)
    best = np.full(len(cost), cost.shape[1] - 1) if fitted else np.nanargmin(cost, axis=1)
    refined = fold(heading[:, -1:])
    center, size = measure(points_ego, segments, linkage, refined)
    return Candidates(
        heading=np.concatenate([rectangles.heading, refined], axis=1),
        center_ego=np.concatenate([rectangles.center_ego, center], axis=1),
        size=np.concatenate([rectangles.size, size], axis=1),
        cost=cost,
        best=best,
        covariance=covariance,
    )


def residual_variance(
    points_ego: npt.NDArray[np.floating], segments: Segments, linkage: Linkage, heading: Floats
) -> Floats:
    """Equation (3) for headings (S, M): variance of the absolute residuals on the dominant line [m^2].

    A residual is the distance of a point to the side of the rectangle along the line, moved to the median of the line.
    (3) does not define the offset c of H; at the edge of a tight rectangle all residuals have the same sign, the
    absolute value has no effect, and least squares always wins.
    """
    dominant = np.flatnonzero(linkage.line == 0)
    dominant = dominant[np.argsort(segments.label[dominant], kind="stable")]
    offset = np.searchsorted(segments.label[dominant], np.arange(segments.count + 1))
    points = np.asarray(points_ego[dominant, :2], dtype=np.float64, order="C")
    distance = side_distances(points, offset, heading)
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
            cos, sin = math.cos(heading[g, m]), math.sin(heading[g, m])
            along, across = cos * x + sin * y, cos * y - sin * x
            place = across if across.std() <= along.std() else along
            distance[offset[g] : offset[g + 1], m] = np.abs(place - np.median(place))
    return distance
