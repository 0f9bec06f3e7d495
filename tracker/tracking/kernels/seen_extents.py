"""Memory of the seen extents of a vehicle."""

import numpy as np

from luxloop.tracker.arrays import Bools, Floats, Ints
from luxloop.tracker.compiled import kernel


@kernel()
def remember(
    seen: float, observed: float, whole: bool, whole_views: int, gains: tuple[float, float], face_min_m: float
) -> float:
    """Return the remembered extent of a side after one more observation [m].

    A vehicle is at least as large as its visible part. A side that is not seen from end to end may be longer, so a
    short observation of it has no effect. The gain falls from the first to the last of `gains` with the earlier
    observations of the whole side.
    """
    gain = max(gains[0] / (1 + whole_views), gains[1])
    if observed <= seen:
        gain = 0.5 * gain if whole and observed > face_min_m else 0.0
    return seen + gain * (observed - seen)


@kernel()
def observe(
    seen: Floats,
    whole_views: Ints,
    observed: Floats,
    whole: Bools,
    gains: tuple[float, float],
    face_min_m: float,
    growth_m: tuple[float, float],
) -> Floats:
    """Return the remembered extents (2,) after one more observation, and count views (2,) of the whole sides, in place.

    A side that grows by more than the first of `growth_m`, but not beyond the second one, the length of a car, was not
    whole before: earlier views do not slow its growth down.
    """
    remembered = np.empty(2)
    for axis in range(2):
        grown = seen[axis] + growth_m[0] < observed[axis] < growth_m[1]
        views = 0 if grown else whole_views[axis]
        remembered[axis] = remember(seen[axis], observed[axis], whole[axis], views, gains, face_min_m)
        whole_views[axis] += whole[axis] and observed[axis] > face_min_m
    return remembered
