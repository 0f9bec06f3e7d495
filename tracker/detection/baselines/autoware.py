"""Closeness as Autoware has it (perception/shape_estimation, bounding_box.cpp), against points inside the outline."""

import numpy as np

from tracker.arrays import Floats
from tracker.detection.baselines.baseline_config import BaselineConfig

ANGLES = np.deg2rad(np.arange(90.0))
FLOOR_M, DEPTH_MAX_M = 0.1, 0.4
"""Nearer points count no more, deeper ones not at all: a rear window, a mirror seen from behind."""


def heading(points_ego: Floats, _: BaselineConfig) -> float:
    """Heading of the rectangle whose nearest edge is closest to the points (N, 2), to one degree [rad].

    Zhang 2017 but for three things: the nearer of two edges is chosen for each point and not once for all, distances
    count squared, and points deeper than `DEPTH_MAX_M` are ignored.
    """
    cos, sin = np.cos(ANGLES), np.sin(ANGLES)
    squared = np.minimum(to_edge(points_ego @ [cos, sin]), to_edge(points_ego @ [-sin, cos])) ** 2
    closeness = np.where(squared <= DEPTH_MAX_M**2, 1.0 / np.maximum(squared, FLOOR_M**2), 0.0).sum(axis=0)
    return float(ANGLES[closeness.argmax()])


def to_edge(place: Floats) -> Floats:
    """Distance of places (N, A) along A directions to the lower or upper end of each, whichever is nearer [m]."""
    return np.asarray(np.minimum(place - place.min(axis=0), place.max(axis=0) - place))
