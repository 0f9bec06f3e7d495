"""Truncation: mark segment ends that are truncated by an occluder or the field of view.

Successive beams of a layer are neighbours. If one beam hits an object and the next a nearer one, the object continues
behind the occlusion boundary; if the next beam passes the object, it ends there. The order of the sweep gives
neighbours without the positions of the units; bearings from the ego's centre differ from those of the units by up to
twenty degrees for objects beside the ego.
"""

from dataclasses import dataclass

import numpy as np

from luxloop import elementwise
from luxloop.arrays import Bools, Floats, Ints
from luxloop.compiled import kernel
from luxloop.tracker.detection.point_groups import by_group, by_key
from luxloop.tracker.records import Segments
from luxloop.tracker.scan import Scan

NEARER_M = 0.5
"""Minimum difference of range at an occlusion boundary [m]; parts of one body differ by less at its ends."""


@dataclass(frozen=True, slots=True)
class TruncationConfig:
    """Definition of neighbouring beams."""

    neighbour_s: float = 0.00025
    """Maximum time between neighbouring beams of one unit and layer [s]: 1.1 degrees of a sweep at 12.5 Hz, two beam
    spacings, so that one beam may be lost. Change it with the rate and the resolution of the units."""

    def __post_init__(self) -> None:
        if self.neighbour_s < 0.0:
            raise ValueError(f"neighbour_s is {self.neighbour_s}; give 0 or more")


def cut_off(scan: Scan, keep: Bools, segments: Segments, range_max_m: float, config: TruncationConfig) -> Bools:
    """(N,) mask of points at truncated ends: their object may continue behind an occluder or outside the field of view.

    Returns of the first and the last beams of a layer are truncated by the field of view. If its limits are unknown,
    the first and the last return of a layer count as truncated. Points near `range_max_m` are truncated by it. `scan`
    must not be deskewed: deskewed points have lost their times, and points without times have no neighbours.
    """
    first = np.flatnonzero(keep & (scan.echo == 0))
    if not scan.time_offset[first].any():
        return np.zeros(len(scan), dtype=np.bool_)
    limits = np.empty((0, 2)) if scan.sweep_limits is None else scan.sweep_limits.reshape(-1, 2)
    layers = 256 if scan.sweep_limits is None else scan.sweep_limits.shape[1]
    channel = scan.unit.astype(np.int64) * layers + scan.layer
    range_m = elementwise.hypot(scan.points_ego[:, 0], scan.points_ego[:, 1])
    time = np.asarray(scan.time_offset, dtype=np.float64)
    in_channels, start = by_group(channel[first], int(channel.max(initial=-1)) + 1)
    first = first.take(in_channels)
    cut = truncated_points(
        first.take(by_key(time.take(first), start)),
        channel,
        time,
        np.asarray(range_m, dtype=np.float64),
        segments.label,
        np.asarray(limits, dtype=np.float64),
        config.neighbour_s,
        NEARER_M,
    )
    return cut | keep & (range_m > range_max_m - NEARER_M)


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
