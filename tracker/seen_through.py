"""Free space: places that the beams of all units pass, without the positions of the units.

A unit is within a known distance of the ego's centre. Its bearing of a place then differs from that of the centre by a
known angle at most. If all returns in this window of bearings are farther than the place, nothing is there.
"""

import numpy as np

from luxloop.tracker.arrays import Bools, Floats
from luxloop.tracker.kernels import free_space as kernel


def seen_through(places: Floats, returns: Floats, unit_offset_m: float, margin_m: float) -> Bools:
    """(C,) mask of places that all returns near their bearing lie behind.

    Parameters
    ----------
    places
        (C, 2) relative to the ego's centre [m].
    returns
        (N, 2) all points of a scan relative to the ego's centre [m]; those within `unit_offset_m` are ignored.
    unit_offset_m
        Maximum distance of a unit from the ego's centre [m].
    margin_m
        Minimum distance of returns behind a place [m].
    """
    return np.asarray(kernel.seen_through(places, returns, unit_offset_m, margin_m))
