"""Points and covariances from the ego frame to the odometry frame."""

import math

import numpy as np

from luxloop.tracker.arrays import Floats
from luxloop.tracker.compiled import kernel


@kernel()
def placed(points: Floats, pose: Floats) -> Floats:
    """(N, 2) points (N, 2 or more) of the ego frame in the odometry frame, in which the ego has a pose (3,)."""
    cos, sin = math.cos(pose[2]), math.sin(pose[2])
    found = np.empty((len(points), 2))
    for i in range(len(points)):
        found[i, 0] = cos * points[i, 0] - sin * points[i, 1] + pose[0]
        found[i, 1] = sin * points[i, 0] + cos * points[i, 1] + pose[1]
    return found


@kernel()
def turned_covariances(covariance: Floats, yaw: float, floors: tuple[float, float]) -> Floats:
    """(B, 3, 3) covariances of x, y and heading, turned by a yaw angle, plus variances of position and heading."""
    x, y = math.cos(yaw), math.sin(yaw)
    turned = np.empty((len(covariance), 3, 3))
    for b in range(len(covariance)):
        xx, xy, yy = covariance[b, 0, 0], covariance[b, 0, 1], covariance[b, 1, 1]
        xh, yh = covariance[b, 0, 2], covariance[b, 1, 2]
        turned[b, 0, 0] = x * x * xx - 2.0 * x * y * xy + y * y * yy + floors[0]
        turned[b, 1, 1] = y * y * xx + 2.0 * x * y * xy + x * x * yy + floors[0]
        turned[b, 0, 1] = turned[b, 1, 0] = x * y * (xx - yy) + (x * x - y * y) * xy
        turned[b, 0, 2] = turned[b, 2, 0] = x * xh - y * yh
        turned[b, 1, 2] = turned[b, 2, 1] = y * xh + x * yh
        turned[b, 2, 2] = covariance[b, 2, 2] + floors[1]
    return turned
