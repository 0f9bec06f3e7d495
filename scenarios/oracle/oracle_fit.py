"""The truth for fitting: a vehicle's segment gets the true rectangle, as far as the vehicle is in view.

Its heading is the true one, and so is every end that the clean points reach. Where what hides the vehicle cuts it off,
or all is on one side, the rectangle ends where they do, as the real stage's does: how long a vehicle is that shows its
rear is for the track to say. What kind of box that makes, and whether it is one, is left to the real stage.

A segment of nobody, of a pedestrian or cyclist, or of a truck that is bent keeps the real fit.
"""

import math
from dataclasses import dataclass, replace

import numpy as np

from scenarios.arrays import Bools, Floats, Ints
from scenarios.grading.plane_geometry import QUARTER, turned
from scenarios.oracle.oracle_truth import Truth
from tracker.geometry import fold
from tracker.records import METHODS, Boxes, Candidates, Segments
from tracker.scan import Scan

BEST = METHODS.index("refined")
"""The method whose column the truth takes; the others stay as they are, to be graded."""
END_MARGIN_M = 0.5
"""Points this near to an end show it [m]: corners are rounded by 0.25 to 0.4, beams at 40 m are 0.17 apart."""
CORNER_STD_M, HEADING_STD_RAD = 0.01, math.radians(0.1)
"""Of boxes that are exact: as near to nothing as filters can do with."""


@dataclass(frozen=True, slots=True, eq=False)
class TrueRectangles:
    """The visible rectangles of K segments."""

    segment: Ints
    """(K,)."""
    heading: Floats
    """(K,) ego frame, in [0, pi/2), as rectangles have it."""
    center_ego: Floats
    """(K, 2) [m]."""
    size: Floats
    """(K, 2) along and across that heading [m]."""


def rectangles(scan: Scan, segments: Segments, truth: Truth) -> TrueRectangles:
    """Find the visible rectangle of every segment that a vehicle owns.

    `scan` holds the points where the tracker has put them for the scan's time; what time offset is left, the true
    velocity makes up for. A vehicle without a clean point is where its noise is.
    """
    owner = truth.owner_row(segments)
    segment = np.flatnonzero(truth.boxed_owner(segments))
    boxes = truth.boxes_ego[owner[segment]]
    own = np.flatnonzero(truth.on_owner(segments) & truth.boxed[truth.point_row])
    clean = own[~truth.noise[own]]
    lone = np.bincount(segments.label[clean], minlength=segments.count) == 0
    used = np.append(clean, own[lone[segments.label[own]]])
    row = np.searchsorted(segment, segments.label[used])
    way = truth.velocity_ego[truth.point_row[used]] * scan.time_offset[used, None]
    low, high = visible(turned(scan.points_ego[used, :2] - way - boxes[row, :2], -boxes[row, 2]), row, boxes[:, 3:])
    heading = fold(boxes[:, 2])
    quarters = np.rint((boxes[:, 2] - heading) / QUARTER).astype(np.int64)
    size = np.where((quarters % 2 == 1)[:, None], (high - low)[:, ::-1], high - low)
    return TrueRectangles(segment, heading, boxes[:, :2] + turned(0.5 * (low + high), boxes[:, 2]), size)


def visible(points: Floats, row: Ints, size: Floats) -> tuple[Floats, Floats]:
    """Low and high corner (K, 2) of what points (P, 2) show of boxes (K, 2), in the boxes' own frames [m].

    `row` (P,) says which box a point is of; each has one at least.
    """
    low, high = np.full_like(size, np.inf), np.full_like(size, -np.inf)
    np.minimum.at(low, row, points)
    np.maximum.at(high, row, points)
    end = 0.5 * size
    low = np.where(low < -end + END_MARGIN_M, -end, np.minimum(low, end))
    high = np.where(high > end - END_MARGIN_M, end, np.maximum(high, -end))
    return low, high


def select(candidates: Candidates, true: TrueRectangles) -> Candidates:
    """Put the true rectangles among the candidates, and select them."""

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


def made_sure(boxes: Boxes, exact: Bools) -> Boxes:
    """Give boxes of segments that are `exact` (S,) the covariance of such, and the scan's own time."""
    sure = exact[boxes.segment]
    covariance = np.diag([CORNER_STD_M**2, CORNER_STD_M**2, HEADING_STD_RAD**2])
    return replace(
        boxes,
        covariance=np.where(sure[:, None, None], covariance, boxes.covariance),
        time_offset=np.where(sure, 0.0, boxes.time_offset),
    )
