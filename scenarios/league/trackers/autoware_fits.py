"""Detector with the rectangles of Autoware's rule, `tracker.detection.baselines.autoware`, instead of its own."""

import numpy as np

from luxloop.arrays import Ints
from luxloop.tracker.detection.baselines import autoware
from luxloop.tracker.detection.detector import Detector
from luxloop.tracker.detection.rectangles import measure
from luxloop.tracker.geometry import fold
from luxloop.tracker.records import Candidates, Linkage, SegmentedPoints

POINTS_MAX = 400
"""Largest number of points of a fit, evenly chosen."""


class AutowareDetector(Detector):
    """The shipped detector with another fit."""

    def fit(self, points: SegmentedPoints, linkage: Linkage) -> Candidates:
        """Fit one rectangle to every segment; its sides are measured on the points on lines, as for all methods."""
        count = points.segments.count
        parts = np.split(points.xy, points.offset[1:-1]) if count else []
        angles = [autoware(part[_even(len(part))]) for part in parts]
        heading = fold(np.reshape(angles, (-1, 1)).astype(np.float64))
        center, size = measure(points, linkage, heading, self.config.lidar.range_std_m)
        best = np.zeros(count, dtype=np.int64)
        return Candidates(heading, center, size, np.zeros_like(heading), best)


def _even(count: int) -> Ints:
    """Return the indices of at most `POINTS_MAX` of `count` points."""
    kept = min(count, POINTS_MAX)
    return np.arange(kept) * count // max(kept, 1)
