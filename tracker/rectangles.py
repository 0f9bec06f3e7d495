"""Candidate rectangles of a segment: a heading by each method, and the extent of its lines along it."""

from dataclasses import dataclass
from typing import Literal

import numpy as np
import numpy.typing as npt

from tracker.geometry import fold, rotate
from tracker.kernels.criteria import best_headings
from tracker.records import Floats, Ints, Linkage, Segments
from tracker.segmentation import by_segment


@dataclass(frozen=True, slots=True)
class RectangleConfig:
    """How the three criteria of Zhang 2017 search a heading."""

    step_deg: float = 1.0
    """Spacing of the headings tried first [deg]; the best is refined to 1/32 of it."""
    closeness_floor_m: float = 0.01
    """d0: nearer points count no more for closeness [m]."""
    points: Literal["all", "lines"] = "all"
    """Which points the criteria judge: all of the segment, as published, or those on its lines."""

    def __post_init__(self) -> None:
        if not 0.0 < self.step_deg <= 45.0:
            raise ValueError(f"step_deg is {self.step_deg}; give a step above 0 and at most 45 degrees")
        if self.closeness_floor_m <= 0.0:
            raise ValueError(f"closeness_floor_m is {self.closeness_floor_m}; give a positive distance in metres")


@dataclass(frozen=True, slots=True, eq=False)
class Rectangles:
    """S segments times M methods, in the order of `METHODS`; selection adds their cost."""

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
    order, offset = by_segment(segments)
    points = np.asarray(points_ego[order, :2], dtype=np.float64, order="C")
    on_line = linkage.line[order] >= 0
    line_points, line_offset = points[on_line], np.concatenate([[0], np.cumsum(on_line)])[offset]
    if config.points == "lines":
        points, offset = line_points, line_offset
    grid = np.deg2rad(np.arange(0.0, 90.0, config.step_deg))
    by_criteria = best_headings(points, offset, grid, config.closeness_floor_m)
    heading = fold(np.column_stack([by_criteria, linkage.heading]))
    center, size = measure(line_points, line_offset, heading)
    return Rectangles(heading=heading, center_ego=center, size=size)


def measure(points: Floats, offset: Ints, heading: Floats) -> tuple[Floats, Floats]:
    """Centre and size (S, M, 2) of the tightest rectangles at headings (S, M); no segment is empty."""
    each_heading = np.repeat(heading, np.diff(offset), axis=0)
    local = rotate(points[:, None], -each_heading)
    low, high = np.minimum.reduceat(local, offset[:-1]), np.maximum.reduceat(local, offset[:-1])
    return rotate(0.5 * (low + high), heading), high - low
