"""Candidate rectangles of a segment: a heading by each method, and the sides of its lines along it."""

from dataclasses import dataclass
from typing import Literal

import numpy as np
import numpy.typing as npt

from tracker.arrays import Bools, Floats, Ints
from tracker.detection.kernels.criteria import best_headings
from tracker.detection.kernels.sides import extents
from tracker.detection.segmentation import by_segment
from tracker.geometry import fold, rotate
from tracker.records import Linkage, Segments

RANGE_STD = 0.025
"""[m] Of a LUX's range, along the beam."""
FLATNESS_STD = 0.01
"""[m] Of a side's points across it for all other reasons, see `SelectionConfig.flatness_m`."""
SIDE_SIGMA = 2.4
"""Of 20 to 100 points the outermost is 2 to 2.6 standard deviations off the side, and another as far inside."""


@dataclass(frozen=True, slots=True)
class RectangleConfig:
    """How the three criteria of Zhang 2017 search a heading."""

    step_deg: float = 1.0
    """Spacing of the headings tried first [deg]."""
    halvings: int = 5
    """Halvings of that step around the best heading: five make it 1/32. 0 for the bare grid, as published."""
    closeness_floor_m: float = 0.01
    """d0: nearer points count no more for closeness [m]."""
    points: Literal["all", "lines"] = "all"
    """Which points the criteria judge: all of the segment, as published, or those on its lines."""

    def __post_init__(self) -> None:
        if not 0.01 <= self.step_deg <= 45.0:
            raise ValueError(f"step_deg is {self.step_deg}; give a step of 0.01 to 45 degrees")
        if not 0 <= self.halvings <= 30:
            raise ValueError(f"halvings is {self.halvings}; give 0 for the bare grid, or up to 30")
        if self.closeness_floor_m <= 0.0:
            raise ValueError(f"closeness_floor_m is {self.closeness_floor_m}; give a positive distance in metres")


@dataclass(frozen=True, slots=True, eq=False)
class Rectangles:
    """S segments times M methods: all of `METHODS` but the refined one, which selection adds with the costs."""

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

    Headings are judged by all points, which makes the criteria sensitive to a mirror, as published. The sides
    are always measured on the points on lines, so that a mirror or a window does not blow a rectangle up.
    """
    judged = linkage.line >= 0 if config.points == "lines" else np.ones(len(points_ego), bool)
    points, offset = _by_segment(points_ego, segments, judged)
    grid = np.deg2rad(np.arange(0.0, 90.0, config.step_deg))
    by_criteria = best_headings(points, offset, grid, config.closeness_floor_m, config.halvings)
    heading = fold(np.column_stack([by_criteria, linkage.heading]))
    center, size = measure(points_ego, segments, linkage, heading)
    return Rectangles(heading=heading, center_ego=center, size=size)


def measure(
    points_ego: npt.NDArray[np.floating], segments: Segments, linkage: Linkage, heading: Floats
) -> tuple[Floats, Floats]:
    """Centre and size (S, M, 2) of the rectangles at headings (S, M) around the points on lines, one at least.

    A side is where the outermost points are on average: noise puts the very last one outside of the body. Range noise
    lies along the beam, so that it is spread across a side that is met at an angle by the cosine of this angle only.
    """
    points, offset = _by_segment(points_ego, segments, linkage.line >= 0)
    low, high = extents(points, offset, heading, RANGE_STD, FLATNESS_STD, SIDE_SIGMA)
    return rotate(0.5 * (low + high), heading), high - low


def _by_segment(points_ego: npt.NDArray[np.floating], segments: Segments, used: Bools) -> tuple[Floats, Ints]:
    """The `used` (N,) points (K, 2) segment by segment, and (S + 1,) where each segment starts."""
    order, offset = by_segment(segments)
    kept = used[order]
    points = np.asarray(points_ego[order[kept], :2], dtype=np.float64, order="C")
    return points, np.concatenate([[0], np.cumsum(kept)])[offset]
