"""Principal axes (Zhao et al., ICRA 2009): the direction of largest spread."""

import math

from luxloop.tracker.arrays import Floats
from luxloop.tracker.detection.baselines.baseline_config import BaselineConfig


def heading(points_ego: Floats, _: BaselineConfig) -> float:
    """Direction of the first principal axis of points (N, 2) [rad].

    It is the heading if one side is visible; for two sides of similar length it is a diagonal.
    """
    return direction(points_ego)


def direction(points: Floats) -> float:
    """Direction of the total least squares line through points (N, 2) [rad]."""
    x, y = (points - points.mean(axis=0)).T
    return 0.5 * math.atan2(2.0 * (x @ y), x @ x - y @ y)
