"""Headings of the tracker's fits to the points of one car, against its label."""

import numpy as np
import numpy.typing as npt

from tracker.detection import rectangles, selection, tlinkage
from tracker.detection.detector import DetectorConfig
from tracker.records import METHODS, Candidates, Linkage, Segments

FEWEST_POINTS = 10
"""Cars with fewer points in the cut are left out."""


def fit(points: npt.NDArray[np.floating]) -> tuple[Linkage, Candidates]:
    """Return lines and rectangles of points (N, 3), which are one segment, in the order in which they fired."""
    config = DetectorConfig()
    segments = Segments(label=np.zeros(len(points), np.int64), count=1)
    linkage = tlinkage.link(points, segments, config.linkage)
    rectangle = rectangles.fit(points, segments, linkage, config.rectangles)
    return linkage, selection.select(points, segments, linkage, rectangle, config.selection)


def heading_errors(points: npt.NDArray[np.floating], heading_deg: float) -> dict[str, float]:
    """Return the error of each method and of `best` modulo 90 degrees, -45 to 45 [deg], of points as for `fit`."""
    _, candidates = fit(points)
    found = dict(zip(METHODS, np.rad2deg(candidates.heading[0, : len(METHODS)]), strict=True))
    found["best"] = np.rad2deg(candidates.heading[0, candidates.best[0]])
    return {name: float((value - heading_deg + 45.0) % 90.0 - 45.0) for name, value in found.items()}
