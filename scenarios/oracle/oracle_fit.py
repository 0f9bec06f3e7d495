"""Oracle for fitting: the segment of a vehicle gets the true rectangle of the visible part of the vehicle.

The rectangle has the true heading, and the true ends where clean points reach them. Where an occluder truncates the
vehicle, or a single side is visible, the rectangle ends at the points, like that of the real stage: the length of a
vehicle that shows its rear is estimated by the track. The real stage decides if the rectangle becomes a box.

Segments without an owner, of pedestrians and cyclists, and of articulated trucks in a bend keep the real fit.
"""

import math
from dataclasses import dataclass, replace

import numpy as np

from luxloop.scenarios.arrays import Bools, Floats, Ints
from luxloop.scenarios.grading.plane_geometry import QUARTER, turned
from luxloop.scenarios.oracle.oracle_truth import Truth
from luxloop.tracker.geometry import fold
from luxloop.tracker.records import METHODS, Boxes, Candidates, SegmentedPoints

BEST = METHODS.index("refined")
"""Column of `METHODS` that the true rectangle replaces; other columns are unchanged, to be graded."""
END_MARGIN_M = 0.5
"""Points this near to an end show that end [m]: corners are rounded by 0.25 to 0.4, beams at 40 m are 0.17 apart."""
CORNER_STD_M, HEADING_STD_RAD = 0.01, math.radians(0.1)
"""Standard deviations of exact boxes: the smallest that keep the filters stable."""


@dataclass(frozen=True, slots=True, eq=False)
class TrueRectangles:
    """Visible rectangles of K segments."""

    segment: Ints
    """(K,) segment of each rectangle."""
    heading: Floats
    """(K,) ego frame, in [0, pi/2)."""
    center_ego: Floats
    """(K, 2) [m]."""
    size: Floats
    """(K, 2) along and across that heading [m]."""


def rectangles(points: SegmentedPoints, truth: Truth) -> TrueRectangles:
    """Return the visible rectangle of every segment that a vehicle owns.

    `points` are deskewed; the true velocity compensates for the remaining time offsets. The rectangle of a vehicle
    without a clean point is that of its noise.
    """
    segments, label, actor = points.segments, points.label, truth.point_row[points.source]
    segment = np.flatnonzero(truth.boxed_owner(segments))
    boxes = truth.boxes_ego[truth.owner_row(segments)[segment]]
    own = np.flatnonzero(truth.on_owner(segments)[points.source] & truth.boxed[actor])
    clean = own[~truth.noise[points.source[own]]]
    only_noise = np.bincount(label[clean], minlength=segments.count) == 0
    used = np.append(clean, own[only_noise[label[own]]])
    row = np.searchsorted(segment, label[used])
    way = truth.velocity_ego[actor[used]] * points.time_offset[used, None]
    low, high = visible(turned(points.xy[used] - way - boxes[row, :2], -boxes[row, 2]), row, boxes[:, 3:])
    heading = fold(boxes[:, 2])
    quarters = np.rint((boxes[:, 2] - heading) / QUARTER).astype(np.int64)
    size = np.where((quarters % 2 == 1)[:, None], (high - low)[:, ::-1], high - low)
    return TrueRectangles(segment, heading, boxes[:, :2] + turned(0.5 * (low + high), boxes[:, 2]), size)


def visible(points: Floats, row: Ints, size: Floats) -> tuple[Floats, Floats]:
    """Return the low and high corner (K, 2) of the part of boxes (K, 2) that points (P, 2) show, box frames [m].

    `row` (P,) is the box of each point; each box has at least one.
    """
    low, high = np.full_like(size, np.inf), np.full_like(size, -np.inf)
    np.minimum.at(low, row, points)
    np.maximum.at(high, row, points)
    end = 0.5 * size
    low = np.where(low < -end + END_MARGIN_M, -end, np.minimum(low, end))
    high = np.where(high > end - END_MARGIN_M, end, np.maximum(high, -end))
    return low, high


def select(candidates: Candidates, true: TrueRectangles) -> Candidates:
    """Replace the candidates of column `BEST` by the true rectangles and select them."""

    def with_truth(column: Floats, values: Floats | float) -> Floats:
        changed = column.copy()
        changed[true.segment, BEST] = values
        return changed

    best = candidates.best.copy()
    best[true.segment] = BEST
    return Candidates(
        heading=with_truth(candidates.heading, true.heading),
        center_ego=with_truth(candidates.center_ego, true.center_ego),
        size=with_truth(candidates.size, true.size),
        cost=with_truth(candidates.cost, np.nanmin(candidates.cost[true.segment], axis=1)),
        best=best,
    )


def with_exact(boxes: Boxes, exact: Bools) -> Boxes:
    """Return the boxes with a small covariance and the time of the scan for segments that are `exact` (S,)."""
    is_exact = exact[boxes.segment]
    covariance = np.diag([CORNER_STD_M**2, CORNER_STD_M**2, HEADING_STD_RAD**2])
    return replace(
        boxes,
        covariance=np.where(is_exact[:, None, None], covariance, boxes.covariance),
        time_offset=np.where(is_exact, 0.0, boxes.time_offset),
    )
