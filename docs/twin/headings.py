"""Headings of the tracker's fits to the points of one car, against its label."""

import numpy as np
import numpy.typing as npt

from tracker.detection import rectangles, selection, tlinkage
from tracker.detection.detector import DetectorConfig
from tracker.records import METHODS, Segments

FEWEST_POINTS = 10
"""Cars with fewer points in the cut are left out."""


def heading_errors(points: npt.NDArray[np.floating], heading_deg: float) -> dict[str, float]:
    """Return the error of each method and of `best` modulo 90 degrees, -45 to 45 [deg].

    The points (N, 3) are one segment, in the order in which they fired.
    """
    config = DetectorConfig()
    segments = Segments(label=np.zeros(len(points), np.int64), count=1)
    linkage = tlinkage.link(points, segments, config.linkage)
    candidates = selection.select(
        points, segments, linkage, rectangles.fit(points, segments, linkage, config.rectangles), config.selection
    )
    found = dict(zip(METHODS, np.rad2deg(candidates.heading[0, : len(METHODS)]), strict=True))
    found["best"] = np.rad2deg(candidates.heading[0, candidates.best[0]])
    return {name: float((value - heading_deg + 45.0) % 90.0 - 45.0) for name, value in found.items()}
