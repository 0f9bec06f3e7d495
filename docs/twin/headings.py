"""Headings of the tracker's fits to the points of one car, against its label."""

import numpy as np
import numpy.typing as npt

from luxloop.tracker.detection import rectangles, segmentation, selection, tlinkage
from luxloop.tracker.detection.detector import DetectorConfig
from luxloop.tracker.records import METHODS, Candidates, Linkage, Segments

FEWEST_POINTS = 10
"""Cars with fewer points in the cut are left out."""


def fit(points: npt.NDArray[np.floating], scan_line: npt.NDArray[np.integer]) -> tuple[Linkage, Candidates]:
    """Return lines and rectangles of points (N, 3) on scan lines (N,), which are one segment."""
    config = DetectorConfig()
    segments = Segments(label=np.zeros(len(points), np.int64), count=1)
    lines = np.unique(scan_line, return_inverse=True)[1]
    one = segmentation.sort_by_segment(points, segments, scan_line=lines)
    linkage = tlinkage.link(one, config.linkage, config.lidar)
    headings = rectangles.headings(one, linkage, config.rectangles)
    return linkage, selection.select(one, linkage, headings, config.selection, config.lidar.range_std_m)


def heading_errors(
    points: npt.NDArray[np.floating], scan_line: npt.NDArray[np.integer], heading_deg: float
) -> dict[str, float]:
    """Return the error of each method and of `best` modulo 90 degrees, -45 to 45 [deg], of points as for `fit`."""
    _, candidates = fit(points, scan_line)
    found = dict(zip(METHODS, np.rad2deg(candidates.heading[0, : len(METHODS)]), strict=True))
    found["best"] = np.rad2deg(candidates.heading[0, candidates.best[0]])
    return {name: float((value - heading_deg + 45.0) % 90.0 - 45.0) for name, value in found.items()}
