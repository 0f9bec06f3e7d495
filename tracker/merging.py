"""Pairs of pieces that together have the shape of one vehicle."""

from dataclasses import dataclass

import numpy as np

from luxloop import elementary, elementwise
from luxloop.arrays import Bools, Floats, Ints
from luxloop.compiled import kernel
from luxloop.tracker.kernels import inside
from luxloop.tracker.records import NOT_USED, OrientedBoxes, Segments
from luxloop.tracker.vehicle_classes import LONGEST_M, WIDEST_M


@kernel()
def hull_bounds(center: Floats, heading: Floats, size: Floats, a: int, b: int) -> tuple[float, float, float, float]:
    """Return low x, low y, high x and high y of the box around two pieces, from and along the first one [m]."""
    cos, sin = elementary.cos(heading[a]), elementary.sin(heading[a])
    x, y = center[b, 0] - center[a, 0], center[b, 1] - center[a, 1]
    along, across = cos * x + sin * y, cos * y - sin * x
    cos, sin = abs(elementary.cos(heading[b] - heading[a])), abs(elementary.sin(heading[b] - heading[a]))
    length, width = 0.5 * (cos * size[b, 0] + sin * size[b, 1]), 0.5 * (sin * size[b, 0] + cos * size[b, 1])
    own_length, own_width = 0.5 * size[a, 0], 0.5 * size[a, 1]
    low = min(-own_length, along - length), min(-own_width, across - width)
    high = max(own_length, along + length), max(own_width, across + width)
    return low[0], low[1], high[0], high[1]


@kernel()
def hull_fits(
    center: Floats, heading: Floats, size: Floats, a: int, b: int, length_max_m: float, width_max_m: float
) -> bool:
    """Return True if the box around two pieces has the size of a vehicle."""
    low_x, low_y, high_x, high_y = hull_bounds(center, heading, size, a, b)
    return high_x - low_x <= length_max_m and high_y - low_y <= width_max_m


@kernel()
def fitting_pairs(
    center: Floats, heading: Floats, size: Floats, length_max_m: float, width_max_m: float, turn_max_rad: float
) -> Ints:
    """(K, 2) pairs of T pieces, parallel or at right angles, that fit into one vehicle, in ascending order.

    Pieces have centres (T, 2) [m], headings (T,) and sizes (T, 2) [m].
    """
    pairs = []
    for a in range(len(heading)):
        for b in range(a + 1, len(heading)):
            near = elementary.hypot(center[b, 0] - center[a, 0], center[b, 1] - center[a, 1]) < length_max_m
            parallel = abs(elementary.sin(2.0 * (heading[b] - heading[a]))) <= 2.0 * turn_max_rad
            if near and parallel and hull_fits(center, heading, size, a, b, length_max_m, width_max_m):
                pairs.append((a, b))
    found = np.empty((len(pairs), 2), np.int64)
    for k, pair in enumerate(pairs):
        found[k, 0], found[k, 1] = pair
    return found


SPEED_MIN_MPS = 5.0
"""Minimum speed of pieces [m/s]: slower vehicles may follow each other as closely."""

HEADWAY_MAX_S = 0.35
"""Maximum time gap between pieces [s]; half a second is the minimum headway of drivers."""

SPEED_DIFFERENCE_MAX_MPS = 1.0
"""Maximum difference of speed [m/s], due to filter errors only."""

TURN_MAX_RAD = 0.09
"""Maximum difference of heading [rad], due to fit errors; trailers articulate by more only in slow turns."""

HITS_MIN = 8
"""Minimum observations of each piece, after which its speed is known."""

MARGIN_M = 0.3
"""Margin around a vehicle's box within which points belong to it [m]."""

MEMBER_FRACTION_MIN = 0.9
"""Minimum fraction of a segment's points inside the box for the segment to belong to the vehicle."""


@dataclass(frozen=True, slots=True)
class MergeConfig:
    """Conditions for pieces to be one vehicle."""

    gap_max_m: float = 6.0
    """Maximum gap between pieces of a fast vehicle [m]: what units leave blind beside the ego. Change it with the
    places of the units."""


def hull(pieces: OrientedBoxes, a: int, b: int) -> tuple[Floats, Floats]:
    """Return the low and high corner (2,) of the box around two pieces, in the frame of the first [m]."""
    low_x, low_y, high_x, high_y = hull_bounds(pieces.center, pieces.heading, pieces.size, a, b)
    return np.array([low_x, low_y]), np.array([high_x, high_y])


def gap(pieces: OrientedBoxes, a: int, b: int) -> float:
    """Return the gap between two pieces along the heading of the first [m]."""
    low_x, _, high_x, _ = hull_bounds(pieces.center, pieces.heading, pieces.size, a, b)
    return float(high_x - low_x - pieces.size[a, 0] - pieces.size[b, 0])


def may_be_one(pieces: OrientedBoxes) -> list[tuple[int, int]]:
    """Return the pairs of pieces that together have the shape of one vehicle."""
    known = np.flatnonzero(pieces.hits >= HITS_MIN)
    places = pieces.center[known], pieces.heading[known], pieces.size[known]
    found = fitting_pairs(*places, LONGEST_M, WIDEST_M, TURN_MAX_RAD)
    return [(a, b) for a, b in known[found].tolist()]


def one_vehicle(pieces: OrientedBoxes, a: int, b: int, config: MergeConfig) -> bool:
    """Return True if a pair of `may_be_one` is equally fast and has a gap below any headway."""
    speed = float(elementwise.hypot(*pieces.velocity[[a, b]].T).min())
    if speed < SPEED_MIN_MPS:
        return False
    same = elementwise.hypot(*(pieces.velocity[b] - pieces.velocity[a])) <= SPEED_DIFFERENCE_MAX_MPS
    return bool(same) and gap(pieces, a, b) <= min(HEADWAY_MAX_S * speed, config.gap_max_m)


def fits(pieces: OrientedBoxes, a: int, b: int) -> bool:
    """Return True if the box around two pieces has the size of a vehicle."""
    place = pieces.center, pieces.heading, pieces.size
    return bool(hull_fits(*place, a, b, LONGEST_M, WIDEST_M))


def merge_segments(points_odom: Floats, segments: Segments, pieces: OrientedBoxes) -> Segments:
    """Merge the segments of points (N, 2) [m] that lie in the box of the same vehicle."""
    if not len(pieces):
        return segments
    used = np.flatnonzero(segments.label >= 0)
    label = segments.label[used]
    size = np.bincount(label, minlength=segments.count)
    within = inside(points_odom.take(used, axis=0), pieces.center, pieces.heading, pieces.size + 2 * MARGIN_M)
    name = _joined(_belongs(within, label, size))
    present = size > 0
    names, number = np.unique(name[present], return_inverse=True)
    renumbered = np.full(segments.count + 1, NOT_USED)  # the last one is that of points in no segment
    renumbered[:-1][present] = number
    return Segments(label=renumbered[segments.label], count=len(names))


def _belongs(within: Bools, label: Ints, size: Ints) -> Bools:
    """(S, T) mask of segments of `size` (S,) that lie almost completely in the box of a vehicle.

    Points with labels (N,) are `within` (N, T) these boxes.
    """
    count = np.stack([np.bincount(label, own, len(size)) for own in within.T], axis=1)
    return np.asarray((count >= MEMBER_FRACTION_MIN * size[:, None]) & (size > 0)[:, None])


def _joined(belongs: Bools) -> Ints:
    """(S,) name of each segment, the lowest number of those that are one vehicle by a mask (S, T)."""
    name = np.arange(len(belongs))
    for vehicle in np.flatnonzero(belongs.sum(axis=0) > 1):
        own = np.unique(name[belongs[:, vehicle]])
        name[np.isin(name, own)] = own[0]
    return name
