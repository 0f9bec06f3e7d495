"""Points from the ego frame to the odometry frame."""

import math

import numpy as np

from tracker.arrays import Floats
from tracker.compiled import kernel


@kernel()
def placed(points: Floats, pose: Floats) -> Floats:
    """(N, 2) points (N, 2 or more) of the ego frame in the odometry frame, in which the ego has a pose (3,)."""
    cos, sin = math.cos(pose[2]), math.sin(pose[2])
    found = np.empty((len(points), 2))
    for i in range(len(points)):
        found[i, 0] = cos * points[i, 0] - sin * points[i, 1] + pose[0]
        found[i, 1] = sin * points[i, 0] + cos * points[i, 1] + pose[1]
    return found
