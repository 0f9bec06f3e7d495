"""Beams mirrored by the surfaces that they hit."""

import math

import numpy as np

from luxloop import elementary
from luxloop.arrays import Floats, Ints
from luxloop.compiled import kernel
from luxloop.sensor_model.kernels.motion import ego_at
from luxloop.sensor_model.kernels.records import BeamAxes, EgoDrive, MovingPlanes, Reflectance, SurfaceHits, UnitPoses

Vector = tuple[float, float, float]

_OFF_SURFACE_M = 1e-3  # offset of a mirrored ray's origin from the mirror, so that it does not hit the mirror again


@kernel()
def bright_mirrors(
    hits: SurfaceHits, bodies: MovingPlanes, reflectance: Reflectance, poses: UnitPoses, drive: EgoDrive,
    axes: BeamAxes, gain: Floats, threshold: Floats,
) -> tuple[Ints, Floats]:  # fmt: skip
    """Find, among N returns, the surfaces that mirror enough power to show a white surface at zero distance.

    Parameters
    ----------
    gain, threshold
        (B,) sensitivity of each beam, and minimum power of an echo.

    Returns
    -------
    (M,) rows of the returns; (M, 7) origin and direction of each mirrored ray in the ego frame, and the share of the
    beam's power that is mirrored.
    """
    # Unpacked once: each access to a record's array costs an atomic reference count.
    beam, range_, target, surface, part = hits.beam, hits.range, hits.target, hits.surface, hits.part
    pose, yaw_rate, planes = bodies.pose, bodies.yaw_rate, bodies.planes
    f0, quality = reflectance.normal, reflectance.quality
    origin, rotation, unit, direction, time = poses.origin, poses.rotation, axes.unit, axes.direction, axes.time
    row, ray = np.empty(len(beam), np.int64), np.empty((len(beam), 7))
    count = 0
    for i in range(len(beam)):
        b = beam[i]
        least = math.sqrt(threshold[b] / gain[b]) * range_[i] if gain[b] > 0.0 else math.inf
        if target[i] < 0 or quality[part[i]] < least:
            continue
        turned = drive.yaw_rate * time[b]
        d = _turn(_rotated(rotation[unit[b]], direction[b]), turned)
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


@kernel()
def _rotated(rotation: Floats, v: Floats) -> Vector:
    """Rotate a vector (3,) by a matrix (3, 3)."""
    return (
        rotation[0, 0] * v[0] + rotation[0, 1] * v[1] + rotation[0, 2] * v[2],
        rotation[1, 0] * v[0] + rotation[1, 1] * v[1] + rotation[1, 2] * v[2],
        rotation[2, 0] * v[0] + rotation[2, 1] * v[1] + rotation[2, 2] * v[2],
    )


@kernel()
def _turn(v: Vector, yaw: float) -> Vector:
    """Rotate a vector about z."""
    cos, sin = elementary.cos(yaw), elementary.sin(yaw)
    return cos * v[0] - sin * v[1], sin * v[0] + cos * v[1], v[2]
