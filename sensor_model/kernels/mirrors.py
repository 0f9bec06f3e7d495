"""Beams that are mirrored by the surface that they meet."""

import math

import numpy as np
from numba import njit

from sensor_model.arrays import Bytes, Floats, Ints
from sensor_model.kernels.motion import ego_at
from sensor_model.kernels.records import EgoDrive

Vector = tuple[float, float, float]

_OFF_SURFACE_M = 1e-3  # mirrored rays start this far away, so as not to meet the mirror itself


@njit(cache=True)
def bright_mirrors(
    beam: Ints, range_: Floats, target: Ints, surface: Ints, part: Bytes,
    pose: Floats, yaw_rate: Floats, planes: Floats, f0: Floats, quality: Floats,
    origin: Floats, rotation: Floats, drive: EgoDrive,
    unit: Bytes, direction: Floats, time: Floats, gain: Floats, threshold: Floats,
) -> tuple[Ints, Floats]:  # fmt: skip
    """Find, among N returns, the surfaces that mirror enough to show something white at no distance.

    Parameters
    ----------
    beam, range_, target, surface, part
        (N,) as in `returns.Returns`.
    pose, yaw_rate, planes
        (A, 3), (A,), (Q, 4) as in `bodies.Bodies`.
    f0, quality
        By part: reflectance at normal incidence, and share of the mirrored power that stays together.
    origin, rotation
        (U, 3), (U, 3, 3) of the units in the ego frame.
    unit, direction, time, gain, threshold
        (B,), (B, 3), (B,), (B,), (B,) of each beam: its unit, its direction there, when it fires, its sensitivity and
        the power that it needs.

    Returns
    -------
    (M,) rows of the returns; (M, 7) where each beam meets the mirror, where it goes from there, and the share of its
    power that is mirrored
    """
    row, ray = np.empty(len(beam), np.int64), np.empty((len(beam), 7))
    count = 0
    for i in range(len(beam)):
        b = beam[i]
        least = math.sqrt(threshold[b] / gain[b]) * range_[i] if gain[b] > 0.0 else math.inf
        if target[i] < 0 or quality[part[i]] < least:
            continue
        turned = drive.yaw_rate * time[b]
        d = _turn(_along(rotation[unit[b]], direction[b]), turned)
        p = planes[surface[i]]
        n = _turn((p[0], p[1], p[2]), pose[target[i], 2] + yaw_rate[target[i]] * time[b])
        cosine = -(d[0] * n[0] + d[1] * n[1] + d[2] * n[2])
        share = quality[part[i]] * (f0[part[i]] + (1.0 - f0[part[i]]) * (1.0 - cosine) ** 5)
        if cosine <= 0.0 or share < least:
            continue
        start = origin[unit[b]]
        x, y, z = _turn((start[0], start[1], start[2]), turned)
        ego_x, ego_y = ego_at(drive, time[b])
        o = (x + ego_x, y + ego_y, z)
        for axis in range(3):
            ray[count, axis] = o[axis] + range_[i] * d[axis] + _OFF_SURFACE_M * n[axis]
            ray[count, 3 + axis] = d[axis] + 2.0 * cosine * n[axis]
        row[count], ray[count, 6] = i, share
        count += 1
    return row[:count].copy(), ray[:count].copy()


@njit(cache=True)
def _along(rotation: Floats, v: Floats) -> Vector:
    """Rotate a vector (3,) by a matrix (3, 3)."""
    return (
        rotation[0, 0] * v[0] + rotation[0, 1] * v[1] + rotation[0, 2] * v[2],
        rotation[1, 0] * v[0] + rotation[1, 1] * v[1] + rotation[1, 2] * v[2],
        rotation[2, 0] * v[0] + rotation[2, 1] * v[1] + rotation[2, 2] * v[2],
    )


@njit(cache=True)
def _turn(v: Vector, yaw: float) -> Vector:
    """Rotate a vector about z."""
    cos, sin = math.cos(yaw), math.sin(yaw)
    return cos * v[0] - sin * v[1], sin * v[0] + cos * v[1], v[2]
