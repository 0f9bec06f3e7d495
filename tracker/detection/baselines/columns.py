"""Baselines as additional columns of the candidates."""

from collections.abc import Callable

import numpy as np

from luxloop.tracker.arrays import Floats
from luxloop.tracker.detection.baselines import autoware, jlinkage, principal_axes, ransac_lines, two_set_split
from luxloop.tracker.detection.baselines.baseline_config import BaselineConfig
from luxloop.tracker.detection.rectangles import measure
from luxloop.tracker.geometry import fold
from luxloop.tracker.records import BASELINES, Candidates, Linkage, SegmentedPoints

Baseline = Callable[[Floats, BaselineConfig], float]
"""Function from points (N, 2) of a segment in the ego frame [m], at two places at least, to a heading modulo 90 degrees
[rad]."""

HEADINGS: dict[str, Baseline] = {
    "principal_axes": principal_axes.heading,
    "two_set_split": two_set_split.heading,
    "ransac_lines": ransac_lines.heading,
    "jlinkage": jlinkage.heading,
    "autoware": autoware.heading,
}


def append(points: SegmentedPoints, linkage: Linkage, candidates: Candidates, config: BaselineConfig) -> Candidates:
    """Return the candidates with the columns of `BASELINES` appended.

    The heading of a baseline uses all points of a segment; its sides are measured on the points on lines, as those of
    the other methods. It has no cost and is not selected. Columns are NaN if not fitted.
    """
    shape = (points.segments.count, len(BASELINES))
    heading, center, size = np.full(shape, np.nan), np.full((*shape, 2), np.nan), np.full((*shape, 2), np.nan)
    if config.enabled and points.segments.count:
        heading = fold(np.array([headings(part, config) for part in np.split(points.xy, points.offset[1:-1])]))
        center, size = measure(points, linkage, heading)
    return Candidates(
        heading=np.concatenate([candidates.heading, heading], axis=1),
        center_ego=np.concatenate([candidates.center_ego, center], axis=1),
        size=np.concatenate([candidates.size, size], axis=1),
        cost=np.concatenate([candidates.cost, np.full(shape, np.nan)], axis=1),
        best=candidates.best,
        covariance=candidates.covariance,
    )


def headings(points: Floats, config: BaselineConfig) -> list[float]:
    """Return the heading of points (N, 2) by each baseline [rad]; 0 if all points are at one place."""
    if not np.ptp(points, axis=0).any():
        return [0.0] * len(BASELINES)
    kept = min(len(points), config.points_max)
    sample = points[np.arange(kept) * len(points) // kept]
    return [HEADINGS[name](sample, config) for name in BASELINES]
