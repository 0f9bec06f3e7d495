"""Kernels of deskewing: motion of the ego and of objects during a sweep."""

import math

import numpy as np

from luxloop.tracker.arrays import Floats, Ints
from luxloop.tracker.compiled import kernel


@kernel()
def without_ego_motion(points: Floats, tau: Floats, velocity: Floats, yaw_rate: float) -> Floats:
    """(N, 3) points measured `tau` (N,) [s] later by a body with that twist, in its current frame [m]."""
    still = np.empty((len(points), 3))
    for i in range(len(points)):
        half, x, y = 0.5 * yaw_rate * tau[i], points[i, 0], points[i, 1]
        cos, sin = math.cos(half), math.sin(half)
        chord = 2.0 * sin / yaw_rate if yaw_rate != 0.0 else tau[i]
        # Rotate by half the angle, move along the chord, and rotate by the other half.
        x, y = cos * x - sin * y + chord * velocity[0], sin * x + cos * y + chord * velocity[1]
        still[i, 0], still[i, 1], still[i, 2] = cos * x - sin * y, sin * x + cos * y, points[i, 2]
    return still


@kernel()
def without_motion(points: Floats, tau: Floats, mover: Ints, velocity: Floats) -> Floats:
    """(N, 3) points without the motion in `tau` (N,) [s] of their movers (N,), -1 for none, with velocities (T, 2)."""
    still = points.copy()
    for i in range(len(points)):
        if mover[i] >= 0:
            for axis in range(2):
                still[i, axis] = points[i, axis] - velocity[mover[i], axis] * tau[i]
    return still
