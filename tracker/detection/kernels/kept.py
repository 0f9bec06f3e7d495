"""Kernel of preprocessing: points to keep."""

import math

import numpy as np

from luxloop.tracker.arrays import Bools, Floats, Ints
from luxloop.tracker.compiled import kernel


@kernel()
def kept_points(points: Floats, time: Floats, flags: Ints, drop: int, range_max: float, half_size: Floats) -> Bools:
    """(N,) mask of points (N, 3) to keep: finite, without a flag of `drop`, and in range.

    Points within `half_size` (2,) of the origin along x and y are on the ego.
    """
    keep = np.zeros(len(points), np.bool_)
    for i in range(len(points)):
        x, y, z = points[i, 0], points[i, 1], points[i, 2]
        keep[i] = (
            flags[i] & drop == 0
            and math.isfinite(z + time[i])
            and math.sqrt(x * x + y * y) <= range_max
            and (abs(x) > half_size[0] or abs(y) > half_size[1])
        )
    return keep
