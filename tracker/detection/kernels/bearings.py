"""Kernel of the order of points along an outline."""

import math

import numpy as np

from tracker.arrays import Floats, Ints
from tracker.compiled import kernel

SAME_BEARING = 1e-9
"""Weight of the range in the order of points, far below the angle between beams [rad/m]."""


@kernel(error_model="numpy")
def bearing_keys(points: Floats, offset: Ints) -> Floats:
    """(N,) keys that sort the points (N, 2 or more) of a segment by bearing from their mean, those of one by range.

    Segment s has points offset[s] to offset[s + 1].
    """
    key = np.empty(len(points))
    for s in range(len(offset) - 1):
        x, y, count = 0.0, 0.0, offset[s + 1] - offset[s]
        for i in range(offset[s], offset[s + 1]):
            x, y = x + points[i, 0], y + points[i, 1]
        x, y = x / count, y / count
        for i in range(offset[s], offset[s + 1]):
            across, ahead = x * points[i, 1] - y * points[i, 0], x * points[i, 0] + y * points[i, 1]
            key[i] = math.atan2(across, ahead) + SAME_BEARING * math.hypot(points[i, 0], points[i, 1])
    return key
