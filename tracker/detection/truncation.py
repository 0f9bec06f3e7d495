"""Truncation: mark segment ends that are truncated by an occluder or the field of view.

Successive beams of a layer are neighbours. If one beam hits an object and the next a nearer one, the object continues
behind the occlusion boundary; if the next beam passes the object, it ends there. The order of the sweep gives
neighbours without the positions of the units; bearings from the ego's centre differ from those of the units by up to
twenty degrees for objects beside the ego.
"""

from dataclasses import dataclass

import numpy as np

from tracker.arrays import Bools, Ints
from tracker.records import Segments
from tracker.scan import Scan


@dataclass(frozen=True, slots=True)
class TruncationConfig:
    """Definition of neighbouring beams and of occluders."""

    neighbour_s: float = 0.00025
    """Maximum time between neighbouring beams of one unit and layer [s]: 1.1 degrees of a sweep at 12.5 Hz, two beam
    spacings, so that one beam may be lost."""
    nearer_m: float = 0.5
    """Minimum difference of range at an occlusion boundary [m]; parts of one body differ by less at its ends."""

    def __post_init__(self) -> None:
        if self.neighbour_s < 0.0 or self.nearer_m <= 0.0:
            raise ValueError("neighbour_s must not be negative and nearer_m must be above 0")


def cut_off(scan: Scan, keep: Bools, segments: Segments, range_max_m: float, config: TruncationConfig) -> Bools:
    """(N,) mask of points at truncated ends: their object may continue behind an occluder or outside the field of view.

    Returns of the first and the last beams of a layer are truncated by the field of view. If its limits are unknown,
    the first and the last return of a layer count as truncated. Points near `range_max_m` are truncated by it. `scan`
    must not be deskewed: deskewed points have lost their times, and points without times have no neighbours.
    """
    cut = np.zeros(len(scan), dtype=np.bool_)
    first = np.flatnonzero(keep & (scan.echo == 0))
    if not scan.time_offset[first].any():
        return cut
    order = first[np.lexsort((scan.time_offset[first], scan.layer[first], scan.unit[first]))]
    one, other = order[:-1], order[1:]
    wait = scan.time_offset[other] - scan.time_offset[one]
    same_layer = (scan.unit[one] == scan.unit[other]) & (scan.layer[one] == scan.layer[other])
    beside = same_layer & (wait > 0.0) & (wait <= config.neighbour_s) & (segments.label[one] != segments.label[other])
    range_m = np.hypot(scan.points_ego[:, 0], scan.points_ego[:, 1])
    farther = range_m[one] - range_m[other]
    cut[_at_edges(scan, order, same_layer, config)] = True
    cut[one[beside & (farther > config.nearer_m)]] = True
    cut[other[beside & (-farther > config.nearer_m)]] = True
    cut |= keep & (range_m > range_max_m - config.nearer_m)
    return cut


def _at_edges(scan: Scan, order: Ints, same_layer: Bools, config: TruncationConfig) -> Ints:
    """Return the points at the edges of the field of view.

    Parameters
    ----------
    order
        (P,) points by unit, layer and time.
    same_layer
        (P - 1,) mask of successive points of one layer.
    """
    if scan.sweep_limits is None:
        return np.concatenate([order[[0, -1]], order[:-1][~same_layer], order[1:][~same_layer]])
    first, last = scan.sweep_limits[scan.unit[order], scan.layer[order]].T
    time = scan.time_offset[order]
    return np.asarray(order[(time - first <= config.neighbour_s) | (last - time <= config.neighbour_s)])
