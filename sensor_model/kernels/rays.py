"""Rays of a block of azimuths, and their intersections with the ground.

All rays at one azimuth of a fan start at one origin at one time. The inner loops run over them without branches, so
that the compiler can vectorise them. `error_model="numpy"` makes a division by zero infinite.
"""

import numpy as np

from luxloop import elementary
from luxloop.arrays import Floats
from luxloop.compiled import kernel
from luxloop.sensor_model.kernels.motion import ego_at
from luxloop.sensor_model.kernels.records import (
    INNER_SURFACE,
    INVERSE_DEPTH,
    NONE,
    TARGET,
    EgoDrive,
    Grid,
    Rays,
)
from luxloop.sensor_model.returns import GROUND, NOTHING


@kernel()
def aim_rays(
    grid: Grid, f: int, first: int, layers: int, azimuth: Floats, time: Floats, u: int, origin: Floats,
    rotation: Floats, drive: EgoDrive, uneven: bool,
) -> Rays:  # fmt: skip
    """Return the rays of K successive azimuths of fan f of unit u at their firing times, before any intersection.

    Parameters
    ----------
    first
        Index of the first azimuth in the fan.
    azimuth, time
        (K, 2) cosine and sine; (K,) firing times, evenly spaced [s].
    origin, rotation
        (3,), (3, 3) pose of the unit in the ego frame.
    uneven
        True if the ground is not flat.
    """
    shape = (len(time), layers, grid.side.shape[2])
    per_azimuth = shape[1] * shape[2]
    begin = grid.fan_ray[f] + first * per_azimuth
    rays = slice(begin, begin + len(time) * per_azimuth)
    line = np.empty((12, len(time)))
    _aim(azimuth, time, origin, rotation, drive, line)
    return Rays(
        line, grid.side[u], grid.slope[rays].reshape(shape), grid.cos[rays].reshape(shape),
        grid.far[rays].reshape(shape), np.empty((4, *shape)), np.empty((3, *shape), np.int64),
        np.empty(shape if uneven else (0, 0, 0)),
    )  # fmt: skip


@kernel()
def _aim(azimuth: Floats, time: Floats, origin: Floats, rotation: Floats, drive: EgoDrive, line: Floats) -> None:
    """Fill the lines (12, K): origin, forward, left and up in the ego frame."""
    cos, sin, step_cos, step_sin = rotation_steps(drive.yaw_rate * time[0], drive.yaw_rate, time)
    for k in range(len(time)):
        ego_x, ego_y = ego_at(drive, time[k])
        line[0, k], line[1, k] = cos * origin[0] - sin * origin[1] + ego_x, sin * origin[0] + cos * origin[1] + ego_y
        line[2, k] = origin[2]
        ca, sa = azimuth[k, 0], azimuth[k, 1]
        for axis, (ahead, aside) in ((3, (ca, sa)), (6, (-sa, ca))):
            fx, fy = rotation[0, 0] * ahead + rotation[0, 1] * aside, rotation[1, 0] * ahead + rotation[1, 1] * aside
            line[axis, k], line[axis + 1, k] = cos * fx - sin * fy, sin * fx + cos * fy
            line[axis + 2, k] = rotation[2, 0] * ahead + rotation[2, 1] * aside
        line[9, k] = cos * rotation[0, 2] - sin * rotation[1, 2]
        line[10, k] = sin * rotation[0, 2] + cos * rotation[1, 2]
        line[11, k] = rotation[2, 2]
        cos, sin = cos * step_cos - sin * step_sin, sin * step_cos + cos * step_sin


@kernel()
def rotation_steps(start: float, rate: float, time: Floats) -> tuple[float, float, float, float]:
    """Return cosine and sine of a start angle, and of the rotation between successive, evenly spaced times.

    Multiplying by the step replaces a cosine and a sine per step; the error after 2000 steps is below 1e-12.
    """
    step = rate * (time[1] - time[0]) if len(time) > 1 else 0.0
    return elementary.cos(start), elementary.sin(start), elementary.cos(step), elementary.sin(step)


@kernel(error_model="numpy")
def intersect_ground(rays: Rays) -> None:
    """End the rays on the ground, the plane z = 0, or on nothing at the maximum range."""
    # Unpacked once: each access to a record's array costs an atomic reference count.
    line, side, slope, far = rays.line, rays.side, rays.slope, rays.far
    inverse_depth = rays.hit[INVERSE_DEPTH]
    target, inner_surface = rays.hit_id[TARGET], rays.hit_id[INNER_SURFACE]
    for k in range(len(slope)):
        per_cos, per_sin, per_slope = -line[5, k] / line[2, k], -line[8, k] / line[2, k], -line[11, k] / line[2, k]
        for layer in range(slope.shape[1]):
            for r in range(slope.shape[2]):
                at = side[0, r] * per_cos + side[1, r] * per_sin + slope[k, layer, r] * per_slope
                inverse_depth[k, layer, r] = max(at, far[k, layer, r])
                target[k, layer, r] = GROUND if at > far[k, layer, r] else NOTHING
                inner_surface[k, layer, r] = NONE
