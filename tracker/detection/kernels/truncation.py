"""Kernel of truncation: points at the edges of the field of view, and at occlusion boundaries."""

import numpy as np

from luxloop.tracker.arrays import Bools, Floats, Ints
from luxloop.tracker.compiled import kernel


@kernel()
def truncated_points(
    order: Ints,
    channel: Ints,
    time: Floats,
    range_m: Floats,
    label: Ints,
    limits: Floats,
    neighbour_s: float,
    nearer_m: float,
) -> Bools:
    """(N,) mask of points at truncated ends.

    Parameters
    ----------
    order
        (P,) points by channel and time.
    channel, time, range_m, label
        (N,) channel of a unit, time [s], range [m] and segment of each point.
    limits
        (C, 2) times of the first and the last beam of each channel [s]; (0, 2) if they are unknown: the first and the
        last return of a channel are then at the edges of its field of view.
    neighbour_s
        Maximum time between neighbouring beams [s].
    nearer_m
        Minimum difference of range at an occlusion boundary [m].
    """
    cut = np.zeros(len(channel), np.bool_)
    for k in range(len(order)):
        i, before = order[k], order[max(k - 1, 0)]
        begins = k == 0 or channel[before] != channel[i]
        if len(limits) > 0:
            first, last = limits[channel[i]]
            cut[i] |= time[i] - first <= neighbour_s or last - time[i] <= neighbour_s
        elif begins:
            cut[before], cut[i] = True, True
        if not begins and 0.0 < time[i] - time[before] <= neighbour_s and label[i] != label[before]:
            cut[i] |= range_m[i] - range_m[before] > nearer_m
            cut[before] |= range_m[before] - range_m[i] > nearer_m
    if len(limits) == 0:
        cut[order[-1]] = True
    return cut
