"""Boxes: selected rectangles of vehicle size, with their nearest corner and its covariance.

Boxes behind a visible face are suppressed: windows above a hood or a deck are parts of the nearer vehicle. Segments of
the size of a person or a bicycle, also those below the size of a vehicle, are small boxes.
"""

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from luxloop import elementary, elementwise
from luxloop.arrays import Bools, Floats, Floats32, Ints
from luxloop.compiled import kernel
from luxloop.tracker.free_space import UNIT_OFFSET_M
from luxloop.tracker.geometry import QUARTER, rotate
from luxloop.tracker.kernels import inside, placed
from luxloop.tracker.records import Boxes, Candidates, Detection, Linkage, SegmentedPoints, Segments, SmallBoxes
from luxloop.tracker.scan import Scan

NOISE_STD_M = 0.03
"""Standard deviation of points about a side [m]: lines of scans on real cars scatter by 2.0 cm on flanks and 3.2 cm on
fronts and rears (medians of 55 vehicles)."""
DEPTH_STD_M = 0.05
"""Standard deviation of the depth of a side as a whole [m]: four layers meet it at depths that vary by 0.1."""
END_STD_M = 0.3
"""Standard deviation of the end of a side without points on the adjacent side [m]: rounded corner, beam spacing."""
DEPTH_MIN_M = 0.6
"""Minimum visible extent of a side [m]: rounded corners take 0.25 to 0.4."""
END_VIEW_MIN_RAD = math.radians(20.0)
"""Minimum view angle of an end, from the line along it: the front of a car then spans at least 0.6 m."""
STRAY_M = 0.5
"""Maximum protrusion of mirrors, both sides together [m]: each protrudes by 0.2."""
CUT_MARGIN_M = 0.3
"""An end is truncated if a truncated point is this near to it [m]: corners are rounded by 0.25 to 0.4."""
PART_DEPTH_M = 2.5
"""Depth behind a face within which a box is a part of it [m]: a hood is 1 to 1.5 m long, a windscreen as deep."""
SINGLE_FACE_MAX_M = 1.5
"""A box less deep than this shows a single face, and its true depth is unknown [m]."""
PART_MARGIN_M = 0.2
"""Margin around the nearer box for the centre of a part [m]."""
HEADING_PRIOR_STD = QUARTER / math.sqrt(12.0)
"""Standard deviation of a heading with a uniform distribution over a quarter turn, the prior without points [rad]."""
MARGIN_M = 0.3
"""Extents of a segment exceed those of its object by range noise and by swinging legs [m]."""


@dataclass(frozen=True, slots=True)
class BoxConfig:
    """Size limits of vehicles."""

    longer_max_m: float = 20.0
    """Maximum length of a vehicle [m]: a trailer truck measures 16.5, an articulated bus 17.9. Raise it, with
    `background.length_min_m`, to track trams."""
    shorter_max_m: float = 2.8
    """Maximum of the shorter side [m]: a truck measures 2.55; mirrors protrude from its lines and do not count. Raise
    it for wide loads."""
    longer_min_m: float = 0.5
    """Minimum of the longer side [m]: a motorcycle is 0.7 wide, and a single side may be all that is visible. Raise it
    where poles and people are mistaken for vehicles."""


class BoxPoints(NamedTuple):
    """Summary of the points of B boxes."""

    support: Ints
    """(B,) points on the fitted lines."""
    time: Floats
    """(B,) mean time of these [s]; 0 without any."""
    cut: Bools
    """(B, 2, 2) mask of ends, low and high, along and across heading, with a truncated one of these points."""
    viewpoint: Floats
    """(B, 2) mean position of the units of all points [m]."""
    extent: Floats
    """(B, 2) extent of all points along and across heading [m]."""


def build(points: SegmentedPoints, linkage: Linkage, candidates: Candidates, config: BoxConfig) -> Boxes:
    """Return the boxes of segments whose best rectangle has the size of a vehicle.

    A view of a single side gives a box with one tiny side.
    """
    kept = vehicle_sized(candidates, config)
    best = kept, candidates.best[kept]
    center, heading, size = candidates.center_ego[best], candidates.heading[best], candidates.size[best]
    on_line = linkage.line.take(points.source) >= 0
    span = np.stack([points.offset[kept], points.offset[kept + 1]], axis=1)
    seen = box_points(points.xy, on_line, points.truncated, points.time_offset, points.viewpoint_ego, span,
                      (center, heading, size), CUT_MARGIN_M)  # fmt: skip
    corner, sign = nearest_corner(center, heading, size, seen.viewpoint)
    covariance = sides_covariance(points, on_line, kept, corner, heading)
    return Boxes(
        segment=kept,
        center_ego=center,
        heading=heading,
        size=size,
        corner_ego=corner,
        corner_sign=sign,
        covariance=(
            covariance
            if candidates.heading_variance is None
            else with_heading_variance(covariance, candidates.heading_variance[kept])
        ),
        support=seen.support,
        time_offset=seen.time,
        cut=seen.cut,
        flat=flat(corner - seen.viewpoint, sign, heading, size, seen.cut)
        | strays(seen.extent, size, config.shorter_max_m),
        viewpoint_ego=seen.viewpoint,
    )


def vehicle_sized(candidates: Candidates, config: BoxConfig) -> Ints:
    """(B,) segments whose best rectangle has the size of a vehicle."""
    size = candidates.size[np.arange(len(candidates.best)), candidates.best]
    shorter, longer = size.min(axis=1), size.max(axis=1)
    fits = (longer <= config.longer_max_m) & (longer >= config.longer_min_m) & (shorter <= config.shorter_max_m)
    return np.flatnonzero(fits)


def sides_covariance(points: SegmentedPoints, on_line: Bools, kept: Ints, corner: Floats, heading: Floats) -> Floats:
    """(B, 3, 3) `side_covariance` of boxes of the segments `kept` (B,), by their points `on_line` (P,)."""
    box_of = np.full(points.segments.count, -1)
    box_of[kept] = np.arange(len(kept))
    box = box_of[points.label]
    used = on_line & (box >= 0)
    from_corner = points.xy[used] - corner[box[used]]
    return side_covariance(from_corner, box[used], heading, NOISE_STD_M, END_STD_M)


def strays(extent: Floats, size: Floats, width_max_m: float) -> Bools:
    """(B,) mask of boxes whose segment, with `extent` (B, 2) along and across heading [m], is larger than a vehicle.

    Windows lie behind a side by up to the width of the vehicle, and mirrors protrude; the wall beside the corner of a
    house continues for metres.
    """
    return np.asarray(np.any(extent > np.maximum(size + STRAY_M, width_max_m), axis=1))


def flat(from_view: Floats, sign: Ints, heading: Floats, size: Floats, cut: Bools) -> Bools:
    """(B,) mask of boxes with a single side and an end that is not truncated, where the ego would see a second side.

    `from_view` (B, 2) is the nearest corner relative to the viewpoint [m].
    """
    to_ego = rotate(-from_view, -heading)
    beyond = elementwise.hypot(*from_view.T)[:, None] * elementary.sin(END_VIEW_MIN_RAD)
    faces_ego = sign * to_ego > np.maximum(beyond, UNIT_OFFSET_M)
    each = np.arange(len(size))[:, None]
    open_end = ~cut[each, np.arange(2), (sign > 0).astype(np.int64)]
    beside = size[:, ::-1] < DEPTH_MIN_M
    return np.asarray(np.any(faces_ego & open_end & beside & (size > DEPTH_MIN_M), axis=1))


def nearest_corner(
    center: Floats, heading: Floats, size: Floats, viewpoint: Floats | float = 0.0
) -> tuple[Floats, Ints]:
    """Return the corner (B, 2) nearest to the viewpoint (B, 2) [m], and its signs (B, 2) in the box's frame.

    A side without depth has two corners at one place; the box extends away from the viewpoint. The units of a rig are
    around the ego, so the rear of a vehicle beside it may be visible although its front is nearer to the ego's centre.
    """
    sign = np.where(rotate(center - viewpoint, -heading) > 0.0, -1, 1)
    return center + rotate(0.5 * sign * size, heading), sign


def side_covariance(from_corner: Floats, box: Ints, heading: Floats, noise_std_m: float, end_std_m: float) -> Floats:
    """(B, 3, 3) covariance of corner x, y [m] and heading [rad], ego frame, by least squares on both sides.

    In the box's frame, with its origin at the corner: when the box moves by (dx, dy) and turns about the corner, the
    residual of a point at (u, 0) on one side changes by dy + u * dheading, that of a point at (0, v) on the other side
    by dx - v * dheading. The sum of the outer products of these rows over the noise, plus the prior, is the information
    matrix. Points scatter about a side by `noise_std_m`; an end without points has `end_std_m`.
    """
    u, v = rotate(from_corner, -heading[box]).T
    lies_along, one, none = np.abs(v) <= np.abs(u), np.ones_like(u), np.zeros_like(u)
    row = np.where(lies_along, [none, one, u], [one, none, -v]).T / noise_std_m
    products = (row[:, :, None] * row[:, None, :]).reshape(-1, 9)
    sums = np.stack([np.bincount(box, product, len(heading)) for product in products.T], axis=1)
    prior = np.diag([end_std_m**-2, end_std_m**-2, HEADING_PRIOR_STD**-2])
    information = prior + sums.reshape(-1, 3, 3)
    turn = np.zeros_like(information)
    turn[:, 0, 0] = turn[:, 1, 1] = elementwise.cos(heading)
    turn[:, 1, 0], turn[:, 0, 1], turn[:, 2, 2] = elementwise.sin(heading), -elementwise.sin(heading), 1.0
    return elementwise.product(elementwise.product(turn, elementwise.inverse(information)), turn.transpose(0, 2, 1))


def with_heading_variance(covariance: Floats, variance: Floats) -> Floats:
    """Return covariances (B, 3, 3) with another variance (B,) of the heading, and the corner as it depends on it.

    The depth of the sides has an error in common for all points, which more points do not reduce.
    """
    slope = covariance[:, :, 2] / covariance[:, 2, 2, None]
    added = variance - covariance[:, 2, 2]
    common = np.diag([DEPTH_STD_M**2, DEPTH_STD_M**2, 0.0])
    return np.asarray(covariance + common + added[:, None, None] * slope[:, :, None] * slope[:, None, :])


@kernel(error_model="numpy")
def box_points(
    points: Floats,
    on_line: Bools,
    truncated: Bools,
    time: Floats,
    viewpoint: Floats,
    span: Ints,
    box: tuple[Floats, Floats, Floats],
    cut_margin: float,
) -> BoxPoints:
    """Summarise the points of B boxes.

    Parameters
    ----------
    points, viewpoint
        (N, 2) and (N, 2), ego frame [m].
    on_line, truncated
        (N,) masks of points on fitted lines, and at truncated ends.
    time
        (N,) [s].
    span
        Box b has the points span[b, 0] to span[b, 1], at least one.
    box
        Centres (B, 2) [m], headings (B,) [rad] and sizes (B, 2) [m].
    cut_margin
        Maximum distance of a truncated point from its end [m].
    """
    (center, heading, size), boxes = box, len(span)
    support, mean_time, cut = np.zeros(boxes, np.int64), np.zeros(boxes), np.zeros((boxes, 2, 2), np.bool_)
    view, extent = np.zeros((boxes, 2)), np.zeros((boxes, 2))
    low, high = np.empty(2), np.empty(2)
    for b in range(boxes):
        cos, sin = elementary.cos(heading[b]), elementary.sin(heading[b])
        low[:], high[:] = np.inf, -np.inf
        for i in range(span[b, 0], span[b, 1]):
            x, y = points[i, 0] - center[b, 0], points[i, 1] - center[b, 1]
            place = cos * x + sin * y, cos * y - sin * x
            if on_line[i]:
                support[b] += 1
                mean_time[b] += time[i]
            for axis in range(2):
                low[axis], high[axis] = min(low[axis], place[axis]), max(high[axis], place[axis])
                view[b, axis] += viewpoint[i, axis]
                end = 0.5 * size[b, axis] - cut_margin
                if on_line[i] and truncated[i]:
                    cut[b, axis, 0] = cut[b, axis, 0] or -place[axis] >= end
                    cut[b, axis, 1] = cut[b, axis, 1] or place[axis] >= end
        count = span[b, 1] - span[b, 0]
        for axis in range(2):  # a loop: expressions of arrays take seconds to compile
            view[b, axis] /= count
            extent[b, axis] = high[axis] - low[axis]
        mean_time[b] /= max(support[b], 1)
    return BoxPoints(support, mean_time, cut, view, extent)


def in_shadow(boxes: Boxes) -> Bools:
    """(B,) mask of boxes inside another box that is nearer to the ego, or right behind its only visible face.

    The nearer vehicle occupies that area.
    """
    depth = np.where(boxes.size < SINGLE_FACE_MAX_M, PART_DEPTH_M, 0.0)
    away = rotate(-0.5 * boxes.corner_sign * depth, boxes.heading)
    covered = inside(boxes.center_ego, boxes.center_ego + away, boxes.heading, boxes.size + depth + 2 * PART_MARGIN_M)
    range_m = elementwise.hypot(*boxes.corner_ego.T)
    return np.asarray(np.any(covered & (range_m[:, None] > range_m), axis=1))


def small_boxes(found: Detection, scan: Scan, longer_max_m: float, wider_max_m: float) -> SmallBoxes:
    """Return the best rectangles of the segments that may be a person or a bicycle, odometry frame.

    Parameters
    ----------
    found
        Results of detection.
    scan
        The scan they come from.
    longer_max_m, wider_max_m
        Maximum length and width of a small road user [m].
    """
    candidates, segments = found.candidates, found.segments
    length, width = candidates.size[np.arange(segments.count), candidates.best].T
    longer, shorter = np.maximum(length, width), np.minimum(length, width)
    kept = np.flatnonzero((longer <= longer_max_m + MARGIN_M) & (shorter <= wider_max_m + MARGIN_M))
    best = kept, candidates.best[kept]
    return SmallBoxes(
        segment=kept,
        center=placed(candidates.center_ego[best], scan.ego_pose_odom),
        heading=candidates.heading[best] + scan.ego_pose_odom[2],
        size=candidates.size[best],
        time_offset=mean_times(segments, scan.time_offset)[kept] if len(kept) else np.zeros(0),
    )


def mean_times(segments: Segments, time_offset: Floats32) -> Floats:
    """(S,) mean time of the points of each segment, relative to that of the scan [s]; 0 for an empty one."""
    bins = segments.label + 1  # the first one is that of points in no segment
    total, points = np.bincount(bins, time_offset, segments.count + 1), np.bincount(bins, None, segments.count + 1)
    return np.asarray(total[1:] / np.maximum(points[1:], 1))
