"""Principal axes (Zhao et al., ICRA 2009): a vehicle points where its points spread most."""

import math

from tracker.arrays import Floats
from tracker.detection.baselines.baseline_config import BaselineConfig


def heading(points_ego: Floats, _: BaselineConfig) -> float:
    """Direction of the first principal axis of points (N, 2) [rad].

    The heading if one side is seen; of two sides it is a diagonal, the more so the more alike they are.
    """
    return direction(points_ego)


def direction(points: Floats) -> float:
    """Direction of the total least squares line through points (N, 2) [rad]: that of their largest spread."""
    x, y = (points - points.mean(axis=0)).T
    return 0.5 * math.atan2(2.0 * (x @ y), x @ x - y @ y)
