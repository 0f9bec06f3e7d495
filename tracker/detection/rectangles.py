"""Candidate rectangles of segments: a heading by each method, and the extents of its lines."""

from dataclasses import dataclass
from typing import Literal

import numpy as np
import numpy.typing as npt

from luxloop.tracker.arrays import Bools, Floats, Ints
from luxloop.tracker.detection.kernels.criteria import best_headings
from luxloop.tracker.detection.kernels.groups import by_group
from luxloop.tracker.detection.kernels.sides import extents
from luxloop.tracker.detection.segmentation import positions
from luxloop.tracker.geometry import fold, rotate
from luxloop.tracker.records import NOT_USED, Linkage, Segments

RANGE_STD = 0.027
"""Standard deviation of a range, along the beam [m], as `LinkageConfig.range_std_m`."""
FLATNESS_STD = 0.01
"""Standard deviation of points across a side for all other reasons [m], see `SelectionConfig.flatness_m`."""
SIDE_SIGMA = 2.4
"""Half-width of a side in standard deviations: of 20 to 100 points the outermost is 2 to 2.6 off."""


@dataclass(frozen=True, slots=True)
class RectangleConfig:
    """Heading search by the three criteria of Zhang 2017."""

    step_deg: float = 1.0
    """Step of the heading grid [deg]."""
    halvings: int = 5
    """Halvings of that step around the best heading: five give 1/32. 0 for the grid only, as published."""
    closeness_floor_m: float = 0.01
    """Lower limit d0 of a distance in the closeness criterion [m]."""
    points: Literal["all", "lines"] = "all"
    """Points of the criteria: `all` of the segment, as published, or those on its `lines`."""

    def __post_init__(self) -> None:
        if not 0.01 <= self.step_deg <= 45.0:
            raise ValueError(f"step_deg is {self.step_deg}; give a step of 0.01 to 45 degrees")
        if not 0 <= self.halvings <= 30:
            raise ValueError(f"halvings is {self.halvings}; give 0 for the grid only, or up to 30")
        if self.closeness_floor_m <= 0.0:
            raise ValueError(f"closeness_floor_m is {self.closeness_floor_m}; give a positive distance in metres")


@dataclass(frozen=True, slots=True, eq=False)
class Rectangles:
    """Rectangles of S segments by M methods: `METHODS` without `refined`, which selection adds with the costs."""

    heading: Floats
    """(S, M) in [0, pi/2), ego frame."""
    center_ego: Floats
    """(S, M, 2) [m]."""
    size: Floats
    """(S, M, 2) along and across heading [m]."""


def fit(
    points_ego: npt.NDArray[np.floating], segments: Segments, linkage: Linkage, config: RectangleConfig
) -> Rectangles:
    """Fit a rectangle per method to every segment of points (N, 2 or more columns).

    The criteria use all points by default, which makes them sensitive to mirrors, as published. The sides are always
    measured on the points on lines, so that a mirror or a window does not enlarge the rectangle.
    """
    selected = linkage.line >= 0 if config.points == "lines" else np.ones(len(points_ego), bool)
    points, offset = _by_segment(points_ego, segments, selected)
    grid = np.deg2rad(np.arange(0.0, 90.0, config.step_deg))
    by_criteria = best_headings(points, offset, grid, config.closeness_floor_m, config.halvings)
    heading = fold(np.column_stack([by_criteria, linkage.heading]))
    center, size = measure(points_ego, segments, linkage, heading)
    return Rectangles(heading=heading, center_ego=center, size=size)


def measure(
    points_ego: npt.NDArray[np.floating], segments: Segments, linkage: Linkage, heading: Floats
) -> tuple[Floats, Floats]:
    """Return centre and size (S, M, 2) [m] of rectangles at headings (S, M) around the points on lines, at least one.

    A side is at the mean of the outermost points, because noise puts the outermost one outside the body. Range noise is
    along the beam: across a side, it is scaled by the cosine of the angle between beam and normal.
    """
    points, offset = _by_segment(points_ego, segments, linkage.line >= 0)
    low, high = extents(points, offset, heading, RANGE_STD, FLATNESS_STD, SIDE_SIGMA)
    return rotate(0.5 * (low + high), heading), high - low


def _by_segment(points_ego: npt.NDArray[np.floating], segments: Segments, used: Bools) -> tuple[Floats, Ints]:
    """Return the `used` (N,) points (K, 2) sorted by segment, and the start (S + 1,) of each segment."""
    order, offset = by_group(np.where(used, segments.label, NOT_USED), segments.count)
    return positions(points_ego, order), offset
