"""Boxes: selected rectangles of vehicle size, with their nearest corner and its covariance."""

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from tracker.arrays import Bools, Floats, Ints
from tracker.detection.box_covariance import corner_covariance, side_covariance
from tracker.geometry import rotate
from tracker.records import Boxes, Candidates, Linkage, Segments


@dataclass(frozen=True, slots=True)
class BoxConfig:
    """Size limits of vehicles, and accuracy of their points."""

    longer_max_m: float = 20.0
    """Maximum length of a vehicle [m]: a trailer truck measures 16.5, an articulated bus 17.9."""
    shorter_max_m: float = 2.8
    """Maximum of the shorter side [m]: a truck measures 2.55; mirrors protrude from its lines and do not count."""
    longer_min_m: float = 0.5
    """Minimum of the longer side [m]: a motorcycle is 0.7 wide, and a single side may be all that is visible."""
    noise_std_m: float = 0.03
    """Standard deviation of points about a side [m]: lines of scans on real cars scatter by 2.0 cm on flanks and 3.2 cm
    on fronts and rears (medians of 55 vehicles)."""
    end_std_m: float = 0.3
    """Standard deviation of the end of a side without points on the adjacent side [m]: rounded corner, beam spacing."""
    depth_min_m: float = 0.6
    """Minimum visible extent of a side [m]: rounded corners take 0.25 to 0.4."""
    end_view_min_rad: float = math.radians(20.0)
    """Minimum view angle of an end, from the line along it: the front of a car then spans at least 0.6 m."""
    unit_offset_m: float = 2.5
    """Maximum distance of a unit from the ego's centre [m], the margin for statements on the view of all units."""
    stray_m: float = 0.5
    """Maximum protrusion of mirrors, both sides together [m]: each protrudes by 0.2."""
    cut_margin_m: float = 0.3
    """An end is truncated if a truncated point is this near to it [m]: corners are rounded by 0.25 to 0.4."""

    def __post_init__(self) -> None:
        if min(self.noise_std_m, self.end_std_m) <= 0.0:
            raise ValueError("noise_std_m and end_std_m must be above 0")


class Selected(NamedTuple):
    """Best rectangles of B segments."""

    segment: Ints
    """(B,) segment of each."""
    center: Floats
    """(B, 2) ego frame [m]."""
    heading: Floats
    """(B,) ego frame [rad]."""
    size: Floats
    """(B, 2) along and across heading [m]."""

    def into_frame(self, points: Floats, box: Ints) -> Floats:
        """(P, 2) points in the frames of their boxes (P,) [m]."""
        return rotate(points - self.center[box], -self.heading[box])


def vehicle_sized(candidates: Candidates, config: BoxConfig) -> Selected:
    """Return the best rectangle of each segment, without those that are not of vehicle size."""
    each = np.arange(len(candidates.best))
    center, heading, size = (
        field[each, candidates.best] for field in (candidates.center_ego, candidates.heading, candidates.size)
    )
    shorter, longer = size.min(axis=1), size.max(axis=1)
    fits = (longer <= config.longer_max_m) & (longer >= config.longer_min_m) & (shorter <= config.shorter_max_m)
    kept = np.flatnonzero(fits)
    return Selected(kept, center[kept], heading[kept], size[kept])


def build(
    points_ego: npt.NDArray[np.floating],
    time_offset: npt.NDArray[np.floating],
    segments: Segments,
    linkage: Linkage,
    candidates: Candidates,
    cut_off: Bools,
    config: BoxConfig,
    viewpoints: Floats | None = None,
) -> Boxes:
    """Return the boxes of segments whose best rectangle has the size of a vehicle.

    A view of a single side gives a box with one tiny side.

    Parameters
    ----------
    points_ego
        (N, 2 or more columns) [m].
    time_offset
        (N,) time of each point minus time of the scan [s].
    cut_off
        (N,) mask of points at truncated ends.
    viewpoints
        (N, 2) position of the unit of each point [m]; the ego's centre if None.
    """
    rectangles = vehicle_sized(candidates, config)
    kept, center, heading, size = rectangles.segment, rectangles.center, rectangles.heading, rectangles.size
    of_box = np.append(np.isin(np.arange(segments.count), kept), False)[segments.label]  # unused points have label -1
    used = np.flatnonzero((linkage.line >= 0) & of_box)
    used = used[np.argsort(segments.label[used], kind="stable")]
    box = np.searchsorted(kept, segments.label[used])
    support = np.bincount(box, minlength=len(kept))
    points = np.asarray(points_ego[used, :2], dtype=np.float64)
    cut = cut_ends(rectangles.into_frame(points, box)[cut_off[used]], box[cut_off[used]], size, config)
    members = np.flatnonzero(of_box)  # with outliers
    owner = np.searchsorted(kept, segments.label[members])
    member_points = np.asarray(points_ego[members, :2], dtype=np.float64)
    viewpoint = np.zeros_like(center) if viewpoints is None else _means(viewpoints[members], owner)
    corner, sign = nearest_corner(center, heading, size, viewpoint)
    larger = strays(rectangles.into_frame(member_points, owner), owner, size, config)
    return Boxes(
        segment=kept,
        center_ego=center,
        heading=heading,
        size=size,
        corner_ego=corner,
        corner_sign=sign,
        covariance=(
            side_covariance(points - corner[box], box, heading, config.noise_std_m, config.end_std_m)
            if candidates.covariance is None
            else corner_covariance(candidates.covariance[kept], corner - _means(member_points, owner), config.end_std_m)
        ),
        support=support,
        time_offset=np.bincount(box, weights=time_offset[used], minlength=len(kept)) / np.maximum(support, 1),
        cut=cut,
        flat=flat(corner - viewpoint, sign, heading, size, cut, config) | larger,
        viewpoint_ego=viewpoint,
    )


def cut_ends(from_center: Floats, box: Ints, size: Floats, config: BoxConfig) -> Bools:
    """(B, 2, 2) mask of ends, low and high, with a truncated point; points (P, 2) are in the frames of their boxes."""
    cut = np.zeros((len(size), 2, 2), dtype=np.bool_)
    for end, sign in enumerate((-1, 1)):
        point, axis = np.nonzero(sign * from_center >= 0.5 * size[box] - config.cut_margin_m)
        cut[box[point], axis, end] = True
    return cut


def strays(from_center: Floats, box: Ints, size: Floats, config: BoxConfig) -> Bools:
    """(B,) mask of boxes whose segment is larger than a vehicle; points (P, 2) are in the frames of their boxes.

    Windows lie behind a side by up to the width of the vehicle, and mirrors protrude; the wall beside the corner of a
    house continues for metres.
    """
    low, high = np.full_like(size, np.inf), np.full_like(size, -np.inf)
    np.minimum.at(low, box, from_center)
    np.maximum.at(high, box, from_center)
    return np.asarray(np.any(high - low > np.maximum(size + config.stray_m, config.shorter_max_m), axis=1))


def flat(from_view: Floats, sign: Ints, heading: Floats, size: Floats, cut: Bools, config: BoxConfig) -> Bools:
    """(B,) mask of boxes with a single side and an end that is not truncated, where the ego would see a second side.

    `from_view` (B, 2) is the nearest corner relative to the viewpoint [m].
    """
    to_ego = rotate(-from_view, -heading)
    beyond = np.hypot(*from_view.T)[:, None] * math.sin(config.end_view_min_rad)
    faces_ego = sign * to_ego > np.maximum(beyond, config.unit_offset_m)
    each = np.arange(len(size))[:, None]
    open_end = ~cut[each, np.arange(2), (sign > 0).astype(np.int64)]
    beside = size[:, ::-1] < config.depth_min_m
    return np.asarray(np.any(faces_ego & open_end & beside & (size > config.depth_min_m), axis=1))


def nearest_corner(
    center: Floats, heading: Floats, size: Floats, viewpoint: Floats | float = 0.0
) -> tuple[Floats, Ints]:
    """Return the corner (B, 2) nearest to the viewpoint (B, 2) [m], and its signs (B, 2) in the box's frame.

    A side without depth has two corners at one place; the box extends away from the viewpoint. The units of a rig are
    around the ego, so the rear of a vehicle beside it may be visible although its front is nearer to the ego's centre.
    """
    sign = np.where(rotate(center - viewpoint, -heading) > 0.0, -1, 1)
    return center + rotate(0.5 * sign * size, heading), sign


def _means(points: Floats, box: Ints) -> Floats:
    """(B, 2) mean of the points (P, 2) of each box (P,), all with points."""
    count = np.bincount(box)
    return np.column_stack([np.bincount(box, weights=axis) / count for axis in points.T])
