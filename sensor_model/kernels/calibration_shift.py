"""Displacement of points by the errors of mounting poses and firing times."""

import math

import numpy as np

from luxloop.arrays import Bytes, Floats, Ints
from luxloop.compiled import kernel
from luxloop.sensor_model.kernels.records import MountErrors


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
