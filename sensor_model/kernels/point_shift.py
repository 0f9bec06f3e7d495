"""Displacement of echoes by the relief of their surfaces, and of points by errors of mounts and firing times."""

import math

import numpy as np

from luxloop import elementary
from luxloop.arrays import Bytes, Floats, Ints
from luxloop.compiled import kernel
from luxloop.sensor_model.kernels.motion import straight_point
from luxloop.sensor_model.kernels.records import MountErrors, RoughPlanes

_LEAST_COSINE = 0.3  # of incidence for a displacement along a beam; details hide each other at grazing incidence


@kernel()
def shift_to_relief(
    target: Ints, surface: Ints, direction: Floats, planes: RoughPlanes, scale: float, ranges: Floats, points: Floats
) -> None:
    """Move N echoes to the relief of their surfaces: a height h moves an echo by -h / cos(incidence) along its beam.

    Parameters
    ----------
    target, surface, direction
        (N,), (N,), (N, 3) as in `Echoes`.
    scale
        Factor of the heights.
    ranges, points
        (N,), (N, 3) in and out: range [m], and point in the frame of its body [m].
    """
    normals, turn, relief, pivot, waves = planes
    per_wave = scale * math.sqrt(2.0 / waves.shape[1])
    for e in range(len(target)):
        a, q = target[e], surface[e]
        if a < 0 or relief[q] == 0.0:
            continue
        x, y = straight_point(points[e, 0], points[e, 1], turn[q], pivot[q])
        height = 0.0
        for w in range(waves.shape[1]):
            height += elementary.cos(
                waves[a, w, 0] * x + waves[a, w, 1] * y + waves[a, w, 2] * points[e, 2] + waves[a, w, 3]
            )
        cosine = 0.0
        for axis in range(3):
            cosine -= normals[q, axis] * direction[e, axis]
        shift = -per_wave * relief[q] * height / max(cosine, _LEAST_COSINE)
        ranges[e] += shift
        for axis in range(3):
            points[e, axis] += shift * direction[e, axis]


@kernel()
def calibration_shift(
    beam: Ints, range_: Floats, target: Ints, unit: Bytes, direction: Floats, errors: MountErrors, motion: Floats,
    velocity: Floats, yaw_rate: float,
) -> Floats:  # fmt: skip
    """Return the (N,) displacement of each point on an actor, 0 elsewhere [m].

    Parameters
    ----------
    beam, range_, target
        (N,) as in `returns.Returns`.
    unit, direction
        (B,), (B, 3) unit and nominal direction of each beam, in the ego frame.
    motion
        As in `records.Solids`.
    velocity, yaw_rate
        (2,) of the ego over ground, in the ego frame [m/s, rad/s].
    """
    nominal, moved, rotation, delay = errors
    distance, shift = np.zeros(len(beam)), np.empty(3)
    for i in range(len(beam)):
        a, b = target[i], beam[i]
        if a < 0:
            continue
        u, r = unit[b], range_[i]
        for axis in range(3):
            turned = -direction[b, axis]
            for k in range(3):
                turned += rotation[u, axis, k] * direction[b, k]
            shift[axis] = moved[u, axis] + r * turned
        x, y = nominal[u, 0] + r * direction[b, 0], nominal[u, 1] + r * direction[b, 1]
        # Velocity of the actor's surface at the point, in the rotating frame of the ego.
        vx = motion[a, 3] - velocity[0] - motion[a, 7] * (y - motion[a, 1]) + yaw_rate * y
        vy = motion[a, 4] - velocity[1] + motion[a, 7] * (x - motion[a, 0]) - yaw_rate * x
        shift[0] += delay[u] * vx
        shift[1] += delay[u] * vy
        distance[i] = math.sqrt(shift[0] * shift[0] + shift[1] * shift[1] + shift[2] * shift[2])
    return distance
