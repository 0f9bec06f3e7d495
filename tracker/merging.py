"""One vehicle seen in pieces: a tractor and its trailer, the side and the rear of a lorry with a blind gap between.

Pieces that drive as one, nearer to each other than drivers keep, are one vehicle. Once it is known as a whole, all
that is seen inside its box is one segment.
"""

from dataclasses import dataclass

import numpy as np

from tracker.arrays import Bools, Floats, Ints
from tracker.geometry import inside, reach, rotate
from tracker.records import Segments


@dataclass(frozen=True, slots=True)
class MergeConfig:
    """When pieces are one vehicle."""

    speed_min_mps: float = 5.0
    """Slower vehicles may follow each other as closely as pieces of one [m/s]."""
    headway_max_s: float = 0.35
    """A gap driven through in less is none between vehicles [s]; half a second is the least that drivers keep."""
    speed_difference_max_mps: float = 1.0
    """Pieces of one vehicle differ in speed by the error of their filters only [m/s]."""
    turn_max_rad: float = 0.09
    """Their sides are parallel but for the fit's error [rad]; a trailer bends by more only where it turns slowly."""
    length_max_m: float = 18.8
    """Longest vehicle on the road [m], a lorry with its trailer (Directive 96/53/EC)."""
    width_max_m: float = 2.8
    """Widest one [m]: 2.55 and the error of two fits."""
    hits_min: int = 8
    """Observations by which the speed of both is known."""
    margin_m: float = 0.3
    """Points so far outside a vehicle's box are still its own [m]."""
    share_min: float = 0.9
    """A segment is a vehicle's with this share of its points."""


@dataclass(frozen=True, slots=True, eq=False)
class Pieces:
    """T tracks as far as each of them was seen, in the odometry frame."""

    center: Floats
    """(T, 2) [m]."""
    heading: Floats
    """(T,)."""
    size: Floats
    """(T, 2) seen length and width [m]."""
    velocity: Floats
    """(T, 2) [m/s]."""
    hits: Ints
    """(T,)."""


def hull(pieces: Pieces, a: int, b: int) -> tuple[Floats, Floats]:
    """Low and high corner (2,) of the box around two pieces, in the frame of the first [m]."""
    away = rotate(pieces.center[b] - pieces.center[a], -pieces.heading[a])
    other = reach(pieces.size[b], pieces.heading[b] - pieces.heading[a])
    low, high = np.minimum(-pieces.size[a], 2 * away - other), np.maximum(pieces.size[a], 2 * away + other)
    return 0.5 * low, 0.5 * high


def one_vehicle(pieces: Pieces, a: int, b: int, config: MergeConfig) -> bool:
    """Whether two tracks are pieces of one vehicle."""
    velocity = pieces.velocity[[a, b]]
    speed = float(np.hypot(*velocity.T).min())
    if speed < config.speed_min_mps or pieces.hits[[a, b]].min() < config.hits_min:
        return False
    if np.hypot(*(velocity[1] - velocity[0])) > config.speed_difference_max_mps:
        return False
    if abs(np.sin(2 * (pieces.heading[b] - pieces.heading[a]))) > 2 * config.turn_max_rad:
        return False
    low, high = hull(pieces, a, b)
    length, width = high - low
    gap = length - pieces.size[[a, b], 0].sum()
    fits = length <= config.length_max_m and width <= config.width_max_m
    return bool(fits and gap <= config.headway_max_s * speed)


def claim(points_odom: Floats, segments: Segments, pieces: Pieces, config: MergeConfig) -> Segments:
    """Make one segment of all that lie in the box of the same vehicle, for points (N, 2) [m]."""
    if not len(pieces.hits):
        return segments
    label = segments.label.copy()
    held = _held(points_odom, segments, pieces, config)
    for vehicle in range(held.shape[1]):
        own = np.unique(label[np.isin(segments.label, np.flatnonzero(held[:, vehicle]))])
        label[np.isin(label, own)] = own.min(initial=segments.count)
    used = label >= 0
    names, label[used] = np.unique(label[used], return_inverse=True)
    return Segments(label=label, count=len(names))


def _held(points_odom: Floats, segments: Segments, pieces: Pieces, config: MergeConfig) -> Bools:
    """(S, T) whether nearly all of a segment lies in the box of a vehicle."""
    used = np.flatnonzero(segments.label >= 0)
    within = inside(points_odom[used], pieces.center, pieces.heading, pieces.size + 2 * config.margin_m)
    label = segments.label[used]
    count = np.stack([np.bincount(label, own, segments.count) for own in within.T], axis=1)
    return np.asarray(count >= config.share_min * np.bincount(label, minlength=segments.count)[:, None])
