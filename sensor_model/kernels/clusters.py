"""Intersections of beams with clusters of droplets."""

import math

import numpy as np

from luxloop import elementary
from luxloop.arrays import Floats
from luxloop.compiled import kernel
from luxloop.sensor_model.kernels.philox import Key, philox, uniform
from luxloop.sensor_model.kernels.records import BeamAxes, Droplets, Fans, UnitPoses

_UNIT_BITS = 8  # a unit's number is a byte; the purpose in the counter's bits above separates these draws from others


@kernel()
def cluster_echoes(
    key: Key, frame: int, purpose: int, clusters: Droplets, poses: UnitPoses, velocity: Floats, axes: BeamAxes,
    fans: Fans,
) -> Floats:  # fmt: skip
    """Return the (B,) range of the nearest echo from C clusters of droplets, infinite without one [m].

    Parameters
    ----------
    poses, velocity
        Poses of the units, and their velocity (2,) over ground in the ego frame [m/s]; the ego's rotation is neglected.
    """
    # Unpacked once: each access to a record's array costs an atomic reference count.
    centre, radius, share, tag = clusters.centre, clusters.radius, clusters.share, clusters.tag
    origin, rotation = poses.origin, poses.rotation
    index, direction, time = axes.number, axes.direction, axes.time
    fan_unit, fan_row, fan_azimuth, row_beam = fans.fan_unit, fans.fan_row, fans.fan_azimuth, fans.row_beam
    nearest = np.full(len(time), np.inf)
    to, drift = np.empty(3), np.empty(3)
    longest = 0.0
    for b in range(len(time)):
        longest = max(longest, abs(time[b]))
    margin = longest * elementary.hypot(velocity[0], velocity[1])  # of a unit since the frame's time
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
                begin, end = _beams_near(to, radius[c] + margin, fan_azimuth[f], columns, turn)
                for row in range(fan_row[f], fan_row[f + 1]):
                    for b in range(row_beam[row] + begin, row_beam[row] + end):
                        middle, half = _chord(to, drift, radius[c], direction[b], time[b])
                        if half > 0.0 and middle > 0.0:
                            words = philox(frame, u + (purpose << _UNIT_BITS), index[b], tag[c], key[0], key[1])
                            along = middle + half * (2.0 * uniform(words[1]) - 1.0)
                            if uniform(words[0]) < share[c] and along > 0.0:
                                nearest[b] = min(nearest[b], along)
    return nearest


@kernel()
def _chord(to: Floats, drift: Floats, radius: float, direction: Floats, time: float) -> tuple[float, float]:
    """Return the range of the middle of a beam's chord through a sphere, and half its length, 0 if it misses.

    `to` (3,) is the vector from the unit to the sphere's centre, `drift` (3,) the unit's velocity, in the unit's frame.
    """
    middle, square = 0.0, radius * radius
    for axis in range(3):
        d = to[axis] - time * drift[axis]
        middle += d * direction[axis]
        square -= d * d
    square += middle * middle
    return middle, math.sqrt(square) if square > 0.0 else 0.0


@kernel()
def _beams_near(to: Floats, reach: float, azimuth: Floats, count: int, turn: int) -> tuple[int, int]:
    """Return the beams [begin, end) of a fan that may pass within `reach` of `to` (3,), which is `turn` turns away.

    `to` is in the unit's frame, `azimuth` (2,) is the fan's first azimuth and negative step, `count` its beams per row.
    """
    away = elementary.hypot(to[0], to[1])
    if away <= reach:
        return (0, count) if turn == 0 else (0, 0)
    half, middle = elementary.asin(reach / away), elementary.atan2(to[1], to[0]) + 2.0 * math.pi * turn
    begin = math.ceil((middle + half - azimuth[0]) / azimuth[1])
    end = math.floor((middle - half - azimuth[0]) / azimuth[1]) + 1
    return max(0, int(begin)), min(count, int(end))
