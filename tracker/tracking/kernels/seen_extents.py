"""Memory of the seen extents of a vehicle."""

import numpy as np
from numba import njit

from tracker.arrays import Bools, Floats, Ints


@njit(cache=True)
def remember(
    seen: Floats, observed: Floats, whole: Bools, whole_views: Ints, gains: tuple[float, float], face_min_m: float
) -> Floats:
    """Return the remembered extents (2,) after one more observation; see `tracker.tracking.extent.remember`.

    `gains` are the first and the last one.
    """
    remembered = np.empty(2)
    for axis in range(2):
        gain = max(gains[0] / (1 + whole_views[axis]), gains[1])
        if observed[axis] <= seen[axis]:
            gain = 0.5 * gain if whole[axis] and observed[axis] > face_min_m else 0.0
        remembered[axis] = seen[axis] + gain * (observed[axis] - seen[axis])
    return remembered
