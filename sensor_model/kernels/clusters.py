"""Beams through clusters of droplets."""

import math

import numpy as np
import numpy.typing as npt
from numba import njit

from sensor_model.arrays import Bytes, Floats, Ints, Key
from sensor_model.kernels.philox import philox, uniform

_UNIT_BITS = 8  # a beam's unit is a byte: what stands above it in the counter keeps these draws apart from all others


@njit(cache=True)
def cluster_echoes(
    key: Key, frame: int, purpose: int, centre: Floats, radius: Floats, share: Floats, tag: Ints,
    origin: Floats, rotation: Floats, velocity: Floats,
    unit: Bytes, index: npt.NDArray[np.int32], time: Floats, direction: Floats,
    fan_unit: Ints, fan_row: Ints, fan_azimuth: Floats, row_beam: Ints,
) -> Floats:  # fmt: skip
    """(B,) range of the nearest echo from C clusters of droplets, infinite where there is none [m].

    Parameters
    ----------
    centre, radius, share, tag
        (C, 3), (C,), (C,), (C,) spheres in the ego frame [m], the share of the beams through them that give an echo,
        and a number below 2^32 that tells a cluster's draws from those of others.
    origin, rotation, velocity
        (U, 3), (U, 3, 3), (2,) of the units in the ego frame [m], and over ground [m/s]; turning is neglected.
    direction
        (B, 3) in the frame of the beam's unit.
    time
        (B,) when each beam fires, from the frame's time [s].
    unit, index, fan_unit, fan_row, fan_azimuth, row_beam
        As in `beams.BeamTable`.
    """
    nearest = np.full(len(unit), np.inf)
    to, drift = np.empty(3), np.empty(3)
    longest = 0.0
    for b in range(len(time)):
        longest = max(longest, abs(time[b]))
    margin = longest * math.hypot(velocity[0], velocity[1])  # how far a unit is from where it is at the frame's time
    for c in range(len(centre)):
        for f in range(len(fan_unit)):
            u = fan_unit[f]
            for axis in range(3):
                drift[axis] = rotation[u, 0, axis] * velocity[0] + rotation[u, 1, axis] * velocity[1]
                to[axis] = 0.0
                for k in range(3):
                    to[axis] += rotation[u, k, axis] * (centre[c, k] - origin[u, k])
            columns = row_beam[fan_row[f] + 1] - row_beam[fan_row[f]]
            for turn in range(-1, 2):
                begin, end = _beams_towards(to, radius[c] + margin, fan_azimuth[f], columns, turn)
                for row in range(fan_row[f], fan_row[f + 1]):
                    for b in range(row_beam[row] + begin, row_beam[row] + end):
                        middle, half = _chord(to, drift, radius[c], direction[b], time[b])
                        if half > 0.0 and middle > 0.0:
                            words = philox(frame, u + (purpose << _UNIT_BITS), index[b], tag[c], key[0], key[1])
                            along = middle + half * (2.0 * uniform(words[1]) - 1.0)
                            if uniform(words[0]) < share[c] and along > 0.0:
                                nearest[b] = min(nearest[b], along)
    return nearest


@njit(cache=True)
def _chord(to: Floats, drift: Floats, radius: float, direction: Floats, time: float) -> tuple[float, float]:
    """Range of the middle of a beam's chord through a sphere, and half its length, 0 if it passes by.

    `to` (3,) is the sphere's centre from the unit, which moves with `drift` (3,), in the unit's frame.
    """
    middle, square = 0.0, radius * radius
    for axis in range(3):
        d = to[axis] - time * drift[axis]
        middle += d * direction[axis]
        square -= d * d
    square += middle * middle
    return middle, math.sqrt(square) if square > 0.0 else 0.0


@njit(cache=True)
def _beams_towards(to: Floats, reach: float, azimuth: Floats, count: int, turn: int) -> tuple[int, int]:
    """Beams [begin, end) of a fan that may pass within `reach` of `to` (3,), in the unit's frame, `turn` turns away.

    `azimuth` (2,) is the fan's first one and its step, negative; `count` its beams per row.
    """
    away = math.hypot(to[0], to[1])
    if away <= reach:
        return (0, count) if turn == 0 else (0, 0)
    half, middle = math.asin(reach / away), math.atan2(to[1], to[0]) + 2.0 * math.pi * turn
    begin = math.ceil((middle + half - azimuth[0]) / azimuth[1])
    end = math.floor((middle - half - azimuth[0]) / azimuth[1]) + 1
    return max(0, int(begin)), min(count, int(end))
