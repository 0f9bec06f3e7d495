"""Selected rectangles of vehicle size, with the corner nearest to the ego and how well the points fix it."""

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from tracker.arrays import Bools, Floats, Ints
from tracker.geometry import QUARTER, rotate
from tracker.records import Boxes, Candidates, Linkage, Segments

CORNERS = np.array([[1, 1], [1, -1], [-1, -1], [-1, 1]])
"""Signs of a rectangle's corners in its own frame."""
HEADING_PRIOR_STD = QUARTER / math.sqrt(12.0)
"""Of a heading spread evenly over a quarter turn: what is known of it without points."""


@dataclass(frozen=True, slots=True)
class BoxConfig:
    """What a vehicle may measure, and how exact its points are."""

    longer_max_m: float = 20.0
    """Longest rectangle taken for a vehicle [m]: a trailer truck measures 16.5, a bendy bus 17.9."""
    shorter_max_m: float = 2.8
    """The same for its shorter side [m]: a truck measures 2.55; mirrors stick out of its lines and do not count."""
    longer_min_m: float = 0.5
    """Smaller things are no vehicles [m]: a motorcycle is 0.7 wide. One side alone may be all that is seen."""
    noise_std_m: float = 0.03
    """Spread of points about a side [m]: range noise and the layers' different biases."""
    end_std_m: float = 0.3
    """Where a side ends, when no points lie on the side next to it [m]: its rounded corner, the beams' spacing."""
    depth_min_m: float = 0.6
    """A side of which less is seen is not seen [m]: rounded corners take 0.25 to 0.4."""
    end_view_min_rad: float = math.radians(20.0)
    """An end is in plain view from this far beyond the line along it: a car's front then spans 0.6 m or more."""
    unit_offset_m: float = 2.5
    """No unit is farther from the ego's centre [m]: what this centre sees from farther beyond, all units do."""
    stray_m: float = 0.5
    """Points beyond a side by more are no mirrors: those stick out by 0.2 m, at either end [m]."""
    cut_margin_m: float = 0.3
    """A box is cut off at an end when it is at a point this near to it [m]: corners are rounded by 0.25 to 0.4."""

    def __post_init__(self) -> None:
        if min(self.noise_std_m, self.end_std_m) <= 0.0:
            raise ValueError("noise_std_m and end_std_m must be above 0")


def build(
    points_ego: npt.NDArray[np.floating],
    time_offset: npt.NDArray[np.floating],
    segments: Segments,
    linkage: Linkage,
    candidates: Candidates,
    cut_off: Bools,
    config: BoxConfig,
) -> Boxes:
    """Boxes of the segments of points (N, 2 or more columns), seen at (N,), whose best rectangle is a vehicle's.

    A view of one side alone gives a box with one tiny side, left so.
    """
    each = np.arange(segments.count)
    center, heading, size = (
        field[each, candidates.best] for field in (candidates.center_ego, candidates.heading, candidates.size)
    )
    shorter, longer = size.min(axis=1), size.max(axis=1)
    fits = (longer <= config.longer_max_m) & (longer >= config.longer_min_m) & (shorter <= config.shorter_max_m)
    kept = np.flatnonzero(fits)
    center, heading, size = center[kept], heading[kept], size[kept]
    corner, sign = nearest_corner(center, heading, size)

    used = np.flatnonzero(linkage.line >= 0)  # of the segments that are kept
    used = used[fits[segments.label[used]]]
    used = used[np.argsort(segments.label[used], kind="stable")]
    box = np.searchsorted(kept, segments.label[used])
    support = np.bincount(box, minlength=len(kept))
    points = np.asarray(points_ego[used, :2], dtype=np.float64)
    from_center = rotate(points - center[box], -heading[box])
    cut = cut_ends(from_center[cut_off[used]], box[cut_off[used]], size, config)
    held = np.flatnonzero(np.append(fits, False)[segments.label])  # outliers, too; the label of unused points is -1
    owner = np.searchsorted(kept, segments.label[held])
    away = np.asarray(points_ego[held, :2], dtype=np.float64) - center[owner]
    larger = strays(rotate(away, -heading[owner]), owner, size, config)
    return Boxes(
        segment=kept,
        center_ego=center,
        heading=heading,
        size=size,
        corner_ego=corner,
        corner_sign=sign,
        covariance=covariance(points - corner[box], box, heading, config),
        support=support,
        time_offset=np.bincount(box, weights=time_offset[used], minlength=len(kept)) / np.maximum(support, 1),
        cut=cut,
        flat=flat(corner, sign, heading, size, cut, config) | larger,
    )


def cut_ends(from_center: Floats, box: Ints, size: Floats, config: BoxConfig) -> Bools:
    """(B, 2, 2) whether a point (P, 2) where the box was cut off, in the box's frame, is at its low or high end."""
    cut = np.zeros((len(size), 2, 2), dtype=np.bool_)
    for end, sign in enumerate((-1, 1)):
        point, axis = np.nonzero(sign * from_center >= 0.5 * size[box] - config.cut_margin_m)
        cut[box[point], axis, end] = True
    return cut


def strays(from_center: Floats, box: Ints, size: Floats, config: BoxConfig) -> Bools:
    """(B,) whether points (P, 2) of a segment, in its box's frame, lie farther about than those of its vehicle do.

    Windows are seen behind a side as deep as the vehicle is wide, and mirrors stick out; the wall beside the corner
    of a house goes on for metres.
    """
    low, high = np.full_like(size, np.inf), np.full_like(size, -np.inf)
    np.minimum.at(low, box, from_center)
    np.maximum.at(high, box, from_center)
    return np.asarray(np.any(high - low > np.maximum(size + config.stray_m, config.shorter_max_m), axis=1))


def flat(corner: Floats, sign: Ints, heading: Floats, size: Floats, cut: Bools, config: BoxConfig) -> Bools:
    """(B,) whether there is but one side, where it ends in plain view, and the ego looks at that end from beyond it."""
    to_ego = rotate(-corner, -heading)
    beyond = np.hypot(*corner.T)[:, None] * math.sin(config.end_view_min_rad)
    faces_ego = sign * to_ego > np.maximum(beyond, config.unit_offset_m)
    each = np.arange(len(size))[:, None]
    open_end = ~cut[each, np.arange(2), (sign > 0).astype(np.int64)]
    beside = size[:, ::-1] < config.depth_min_m
    return np.asarray(np.any(faces_ego & open_end & beside & (size > config.depth_min_m), axis=1))


def nearest_corner(center: Floats, heading: Floats, size: Floats) -> tuple[Floats, Ints]:
    """(B, 2) corner nearest to the ego [m], and (B, 2) its signs in the box's frame."""
    corners = center[:, None] + rotate(0.5 * CORNERS * size[:, None], heading[:, None])
    nearest = np.argmin(np.hypot(corners[..., 0], corners[..., 1]), axis=1)
    return corners[np.arange(len(center)), nearest], CORNERS[nearest]


def covariance(from_corner: Floats, box: Ints, heading: Floats, config: BoxConfig) -> Floats:
    """(B, 3, 3) covariance of corner x, y [m] and heading [rad], ego frame, by least squares on both sides.

    In the box's frame, from its corner, a point at (u, 0) on one side moves off it by dy + u * dheading when the box
    moves by (dx, dy) and turns about the corner, a point at (0, v) on the other by dx - v * dheading. These
    rows, over the noise, sum up to the information matrix, on top of what is known without points.
    """
    u, v = rotate(from_corner, -heading[box]).T
    lies_along, one, none = np.abs(v) <= np.abs(u), np.ones_like(u), np.zeros_like(u)
    row = np.where(lies_along, [none, one, u], [one, none, -v]).T / config.noise_std_m
    products = (row[:, :, None] * row[:, None, :]).reshape(-1, 9)
    sums = np.stack([np.bincount(box, product, len(heading)) for product in products.T], axis=1)
    prior = np.diag([config.end_std_m**-2, config.end_std_m**-2, HEADING_PRIOR_STD**-2])
    information = prior + sums.reshape(-1, 3, 3)
    turn = np.zeros_like(information)
    turn[:, 0, 0] = turn[:, 1, 1] = np.cos(heading)
    turn[:, 1, 0], turn[:, 0, 1], turn[:, 2, 2] = np.sin(heading), -np.sin(heading), 1.0
    return np.asarray(turn @ np.linalg.inv(information) @ turn.transpose(0, 2, 1))
