"""Detection with oracles in place of stages.

Segmentation: all points of an actor after preprocessing are one segment.

Background removal and the merging of pieces, parts of the real stage, do not apply to actors. The real stage groups the
points on no actor: later stages decide if a wall or a cloud of spray is a vehicle, as without the oracle. Segments with
too few points are dropped.

Outlier removal: in the segment of a vehicle exactly the noise is removed.

The real stage assigns the remaining points to lines, without the noise. Points of the vehicle that it would remove get
a separate line, which has no effect on the heading but counts for the sides. Points of other objects in the segment, a
neighbour or a wall, are errors of segmentation: the real stage decides on them.

A segment that contains only noise gets no rectangle and no box.

Fitting: the segment of a vehicle gets the true rectangle of the visible part of the vehicle.

The rectangle has the true heading, and the true ends where clean points reach them. Where an occluder truncates the
vehicle, or a single side is visible, the rectangle ends at the points, like that of the real stage: the length of a
vehicle that shows its rear is estimated by the track. The real stage decides if the rectangle becomes a box.

The tracker adds to every whole side the part that rounded corners hide from real fits. The box of a whole side lacks
this part at its far end, as a real one does, so that the tracker's box has the true ends.

Segments without an owner, of pedestrians and cyclists, and of articulated trucks in a bend keep the real fit.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from luxloop.arrays import Bools, Floats, Ints
from luxloop.scenarios.grading.frame_truth import NO_ACTOR_ROW
from luxloop.scenarios.grading.plane_geometry import QUARTER, turned
from luxloop.scenarios.oracle.oracle_truth import OracleContext, Truth, oracle_over
from luxloop.scenarios.oracle.stage import Stage
from luxloop.tracker.detection.detector import Detector
from luxloop.tracker.detection.segmentation import keep_only, regrouped
from luxloop.tracker.geometry import fold
from luxloop.tracker.records import (
    METHODS,
    NOT_USED,
    Boxes,
    Candidates,
    Detection,
    Linkage,
    OrientedBoxes,
    SegmentedPoints,
    Segments,
)
from luxloop.tracker.scan import Scan
from luxloop.tracker.tracking.vehicle_size import HIDDEN_M

REMOVED = -1


def link(real: Callable[[SegmentedPoints], Linkage], points: SegmentedPoints, noise: Bools, on_owner: Bools) -> Linkage:
    """Remove the noise, and link the remaining points by the real stage.

    Parameters
    ----------
    real
        The real stage.
    noise
        (N,) mask of noise.
    on_owner
        (N,) mask of points on the owner of their segment.
    """
    segments = points.segments
    clean = Segments(np.where(noise, NOT_USED, segments.label), segments.count)
    remaining = has_points(clean.label != NOT_USED, segments)
    linkage = real(regrouped(points, keep_only(clean, remaining)))
    heading = np.zeros(segments.count)
    heading[remaining] = linkage.heading
    wrongly_removed = on_owner & ~noise & (linkage.line == REMOVED)
    own_line = linkage.line.max(initial=0) + 1
    return Linkage(np.where(wrongly_removed, own_line, linkage.line), heading)


def has_points(points: Bools, segments: Segments) -> Bools:
    """(S,) mask of segments that contain at least one point of the mask `points` (N,)."""
    return np.bincount(segments.label[points], minlength=segments.count) > 0


def with_placeholder_lines(linkage: Linkage, segments: Segments, gone: Bools) -> Linkage:
    """Put the points of segments that are `gone` (S,) on a line, because the fit needs one."""
    of_gone = np.append(gone, False)[segments.label]
    return replace(linkage, line=np.where(of_gone, 0, linkage.line))


def without_rectangles(candidates: Candidates, gone: Bools) -> Candidates:
    """Set the rectangles of segments that are `gone` (S,) to NaN, so that they get no box."""
    return replace(
        candidates,
        heading=np.where(gone[:, None], np.nan, candidates.heading),
        center_ego=np.where(gone[:, None, None], np.nan, candidates.center_ego),
        size=np.where(gone[:, None, None], np.nan, candidates.size),
    )


def actors_first(point_row: Ints, keep: Bools, rest: Segments, points_min: int) -> Segments:
    """Make a segment of each actor, of the points to `keep` (N,), and append the segments of the `rest`.

    Parameters
    ----------
    point_row
        (N,) row of the actor each point lies on, -1 for none.
    rest
        Segments of the points on no actor.
    points_min
        Segments of actors with fewer points are dropped.
    """
    own = keep & (point_row != NO_ACTOR_ROW)
    count = int(point_row.max(initial=NO_ACTOR_ROW)) + 1
    actors = Segments(np.where(own, point_row, NOT_USED), count)
    actors = keep_only(actors, np.bincount(point_row[own], minlength=count) >= points_min)
    after = np.where(rest.label == NOT_USED, NOT_USED, rest.label + actors.count)
    return Segments(np.where(own, actors.label, after), actors.count + rest.count)


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
    hidden: Floats
    """(K, 2) part of a whole side that rounded corners would hide from a real fit [m]; 0 for a truncated side."""


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
    sideways = (quarters % 2 == 1)[:, None]
    size = np.where(sideways, (high - low)[:, ::-1], high - low)
    hidden = np.where(high - low >= boxes[:, 3:], HIDDEN_M, 0.0)
    hidden = np.where(sideways, hidden[:, ::-1], hidden)
    return TrueRectangles(segment, heading, boxes[:, :2] + turned(0.5 * (low + high), boxes[:, 2]), size, hidden)


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
        cost=with_truth(candidates.cost, np.fmin.reduce(candidates.cost[true.segment], axis=1)),
        best=best,
    )


def without_hidden(boxes: Boxes, true: TrueRectangles) -> Boxes:
    """Return the boxes without the part of whole sides that the tracker adds, at their far ends."""
    hidden = np.zeros_like(boxes.size)
    row = np.searchsorted(true.segment, boxes.segment)
    exact = np.isin(boxes.segment, true.segment)
    hidden[exact] = true.hidden[row[exact]]
    center = boxes.center_ego + turned(0.5 * boxes.corner_sign * hidden, boxes.heading)
    return replace(boxes, center_ego=center, size=boxes.size - hidden)


def with_exact(boxes: Boxes, true: TrueRectangles) -> Boxes:
    """Return the boxes of true rectangles with a small covariance and the time of the scan."""
    boxes, is_exact = without_hidden(boxes, true), np.isin(boxes.segment, true.segment)
    covariance = np.diag([CORNER_STD_M**2, CORNER_STD_M**2, HEADING_STD_RAD**2])
    return replace(
        boxes,
        covariance=np.where(is_exact[:, None, None], covariance, boxes.covariance),
        time_offset=np.where(is_exact, 0.0, boxes.time_offset),
    )


class OracleDetector(Detector):
    """A detector that knows the ground truth of each scan. Stages without an oracle are those of `Detector`."""

    _stages: frozenset[Stage]
    _context: OracleContext

    @classmethod
    def over(cls, real: Detector, stages: frozenset[Stage], context: OracleContext) -> "OracleDetector":
        """Return a detector with oracles for some stages; the other stages are those of a real one."""
        return oracle_over(cls, Detector, real, _stages=stages, _context=context)

    @property
    def truth(self) -> Truth:
        """Ground truth of the current scan."""
        return self._context.truth

    def step(self, scan: Scan, movers: OrientedBoxes | None = None, long: OrientedBoxes | None = None) -> Detection:
        """Detect the vehicles in a scan and record the owners of their boxes."""
        found = super().step(scan, movers, long)
        self._context.add_detection(scan.ego_pose_odom, found)
        return found

    def segment(self, scan: Scan, keep: Bools, long: OrientedBoxes | None) -> Segments:
        """Group points, those on actors by the ground truth."""
        if Stage.SEGMENTATION not in self._stages:
            return super().segment(scan, keep, long)
        row = self.truth.point_row
        rest = super().segment(scan, keep & (row == NO_ACTOR_ROW), long)
        return actors_first(row, keep, rest, self.config.segmentation.points_min)

    def link(self, points: SegmentedPoints) -> Linkage:
        """Separate lines from outliers, the outliers by the ground truth."""
        if Stage.OUTLIERS not in self._stages:
            return super().link(points)
        real, truth = super().link, self.truth
        return link(real, points, truth.noise, truth.on_owner(points.segments))

    def fit(self, points: SegmentedPoints, linkage: Linkage) -> Candidates:
        """Fit rectangles and add the true ones."""
        segments = points.segments
        gone = ~has_points((linkage.line != REMOVED) & (segments.label >= 0), segments)
        candidates = super().fit(points, with_placeholder_lines(linkage, segments, gone))
        candidates = without_rectangles(candidates, gone)
        if Stage.FIT not in self._stages:
            return candidates
        return select(candidates, rectangles(points, self.truth))

    def box(self, points: SegmentedPoints, linkage: Linkage, candidates: Candidates) -> Boxes:
        """Make boxes of rectangles; true rectangles get a small covariance."""
        boxes = super().box(points, linkage, candidates)
        return with_exact(boxes, rectangles(points, self.truth)) if Stage.FIT in self._stages else boxes
