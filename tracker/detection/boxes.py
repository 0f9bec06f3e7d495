"""Boxes: selected rectangles of vehicle size, with their nearest corner and its covariance."""

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from luxloop.tracker.arrays import Bools, Floats, Ints
from luxloop.tracker.detection.box_covariance import corner_covariance, side_covariance
from luxloop.tracker.detection.kernels.box_points import box_points
from luxloop.tracker.detection.segmentation import by_segment, positions
from luxloop.tracker.geometry import rotate
from luxloop.tracker.records import Boxes, Candidates, Linkage, Segments


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
    kept, center, heading, size = vehicle_sized(candidates, config)
    order, start = by_segment(segments)
    units = np.zeros((len(points_ego), 2)) if viewpoints is None else viewpoints
    seen = box_points(
        np.asarray(points_ego[:, :2], dtype=np.float64, order="C"),
        linkage.line >= 0,
        cut_off,
        np.asarray(time_offset, dtype=np.float64),
        units,
        order,
        np.stack([start[kept], start[kept + 1]], axis=1),
        center,
        heading,
        size,
        config.cut_margin_m,
    )
    corner, sign = nearest_corner(center, heading, size, seen.viewpoint)
    return Boxes(
        segment=kept,
        center_ego=center,
        heading=heading,
        size=size,
        corner_ego=corner,
        corner_sign=sign,
        covariance=(
            sides_covariance(points_ego, segments, linkage, kept, corner, heading, config)
            if candidates.covariance is None
            else corner_covariance(candidates.covariance[kept], corner - seen.mean, config.end_std_m)
        ),
        support=seen.support,
        time_offset=seen.time,
        cut=seen.cut,
        flat=flat(corner - seen.viewpoint, sign, heading, size, seen.cut, config) | strays(seen.extent, size, config),
        viewpoint_ego=seen.viewpoint,
    )


def sides_covariance(
    points_ego: npt.NDArray[np.floating],
    segments: Segments,
    linkage: Linkage,
    kept: Ints,
    corner: Floats,
    heading: Floats,
    config: BoxConfig,
) -> Floats:
    """(B, 3, 3) `side_covariance` of boxes of the segments `kept` (B,), by their points on lines."""
    box_of = np.full(segments.count + 1, -1)
    box_of[kept] = np.arange(len(kept))
    used = np.flatnonzero((linkage.line >= 0) & (box_of[segments.label] >= 0))  # unused points have label -1
    box = box_of[segments.label[used]]
    from_corner = positions(points_ego, used) - corner[box]
    return side_covariance(from_corner, box, heading, config.noise_std_m, config.end_std_m)


def strays(extent: Floats, size: Floats, config: BoxConfig) -> Bools:
    """(B,) mask of boxes whose segment, with `extent` (B, 2) along and across heading [m], is larger than a vehicle.

    Windows lie behind a side by up to the width of the vehicle, and mirrors protrude; the wall beside the corner of a
    house continues for metres.
    """
    return np.asarray(np.any(extent > np.maximum(size + config.stray_m, config.shorter_max_m), axis=1))


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
