"""Ordered two-set split (Shen, Pendleton and Ang, CIS and RAM 2015): split the points in two perpendicular sides."""

import numpy as np

from luxloop.tracker.arrays import Floats, Ints
from luxloop.tracker.detection.baselines.baseline_config import BaselineConfig


def heading(points_ego: Floats, _: BaselineConfig) -> float:
    """Direction of the best two perpendicular lines through points (N, 2), split in two by azimuth [rad].

    For every split of the ordered points the lines n . p = c1 through the first set and m . p = c2 through the second,
    m being n turned by a quarter, are fitted together by least squares: with the scatter matrices S1 and S2 of the
    sets, S2 turned by a quarter, the smaller eigenvalue of S1 + S2 is the sum of squared residuals, and its
    eigenvector n. The split with the least residual is chosen; one set may contain all points.
    """
    ordered = points_ego[by_azimuth(points_ego)] - points_ego.mean(axis=0)
    first, second = running_scatter(ordered), running_scatter(ordered[::-1])[::-1]
    second = np.append(second[1:], np.zeros((1, 3)), axis=0)
    xx, xy, yy = (first + np.array([1.0, -1.0, 1.0]) * second[:, ::-1]).T
    residual = 0.5 * (xx + yy) - np.hypot(0.5 * (xx - yy), xy)
    best = residual.argmin()
    return float(0.5 * np.arctan2(2.0 * xy[best], xx[best] - yy[best]))


def by_azimuth(points_ego: Floats) -> Ints:
    """(N,) order of points (N, 2) by azimuth, from right to left, at any bearing from the ego."""
    x, y = points_ego.T
    middle_x, middle_y = points_ego.mean(axis=0)
    azimuth = np.arctan2(middle_x * y - middle_y * x, middle_x * x + middle_y * y)
    return np.argsort(azimuth, kind="stable")


def running_scatter(points: Floats) -> Floats:
    """(N, 3) sums of xx, xy and yy of the first 1, 2, ... N points about their mean [m^2]."""
    x, y = points.T
    count = np.arange(1, len(points) + 1)
    sum_x, sum_y = np.cumsum(x), np.cumsum(y)
    return np.stack(
        [
            np.cumsum(x * x) - sum_x * sum_x / count,
            np.cumsum(x * y) - sum_x * sum_y / count,
            np.cumsum(y * y) - sum_y * sum_y / count,
        ],
        axis=1,
    )
