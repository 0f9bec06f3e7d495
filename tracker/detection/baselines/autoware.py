"""Closeness criterion of Autoware (perception/shape_estimation, bounding_box.cpp), which ignores points well inside."""

import numpy as np

from luxloop.tracker.arrays import Floats
from luxloop.tracker.detection.baselines.baseline_config import BaselineConfig

ANGLES = np.deg2rad(np.arange(90.0))
FLOOR_M, DEPTH_MAX_M = 0.1, 0.4
"""Lower limit of a distance, and maximum depth of a point that counts, which excludes rear windows and mirrors."""


def heading(points_ego: Floats, _: BaselineConfig) -> float:
    """Heading of the rectangle whose nearest edge is closest to the points (N, 2), to one degree [rad].

    Three differences from Zhang 2017: the nearer of two edges is chosen per point and not once for all, distances are
    squared, and points deeper than `DEPTH_MAX_M` are ignored.
    """
    cos, sin = np.cos(ANGLES), np.sin(ANGLES)
    squared = np.minimum(to_edge(points_ego @ [cos, sin]), to_edge(points_ego @ [-sin, cos])) ** 2
    closeness = np.where(squared <= DEPTH_MAX_M**2, 1.0 / np.maximum(squared, FLOOR_M**2), 0.0).sum(axis=0)
    return float(ANGLES[closeness.argmax()])


def to_edge(place: Floats) -> Floats:
    """Distance of places (N, A) along A directions to the nearer end of each direction [m]."""
    return np.asarray(np.minimum(place - place.min(axis=0), place.max(axis=0) - place))
