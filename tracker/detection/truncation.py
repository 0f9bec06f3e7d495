"""Where a thing is cut off: something nearer hides the rest of it, so that it is longer than it looks.

Beams of a layer that follow one another in the sweep are neighbours. Where the one meets a thing and the next something
nearer, the thing does not end there; where the next passes it by, it does. Order in the sweep tells this without the
places of the units, by which directions from the ego's centre are off by up to twenty degrees for things beside it.
"""

from dataclasses import dataclass

import numpy as np

from tracker.arrays import Bools
from tracker.records import Segments
from tracker.scan import Scan


@dataclass(frozen=True, slots=True)
class TruncationConfig:
    """What counts as next to each other, and as nearer."""

    neighbour_s: float = 0.00025
    """Beams of one unit and layer no farther apart than this are neighbours [s]: 1.1 degrees of a sweep at 12.5 Hz,
    two beams, of which one may be lost."""
    nearer_m: float = 0.5
    """What hides a thing is nearer by at least this much [m]; parts of one body differ by less at its ends."""

    def __post_init__(self) -> None:
        if self.neighbour_s < 0.0 or self.nearer_m <= 0.0:
            raise ValueError("neighbour_s must not be negative and nearer_m must be above 0")


def cut_off(scan: Scan, keep: Bools, segments: Segments, config: TruncationConfig) -> Bools:
    """(N,) whether a thing may go on beyond this point of it, hidden or where nobody looks.

    That is the first and the last return of a layer, too: there its field of view may end. `scan` is as it came:
    points that were moved have lost their times, and points without times have no neighbours.
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
    cut[order[[0, -1]]] = True
    cut[one[~same_layer]] = cut[other[~same_layer]] = True
    cut[one[beside & (farther > config.nearer_m)]] = True
    cut[other[beside & (-farther > config.nearer_m)]] = True
    return cut
