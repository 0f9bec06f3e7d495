"""Rays of one fan, and their intersections with ground and walls.

A fan fires columns: at each azimuth, n rays from one origin at one time, in one plane. The inner loops run over the
rays of a column without branches, so that the compiler can vectorise them. `error_model="numpy"` makes a division by
zero infinite.
"""

import math

import numpy as np
from numba import njit

from sensor_model.arrays import Floats, Ints
from sensor_model.kernels.motion import ego_at
from sensor_model.kernels.records import (
    COSINE,
    INNER_SURFACE,
    INVERSE_DEPTH,
    NONE,
    SURFACE,
    TARGET,
    EgoDrive,
    Grid,
    Rays,
    StaticScene,
)
from sensor_model.returns import GROUND, NOTHING, WALL


@njit(cache=True)
def aim_rays(grid: Grid, f: int, time: Floats, origin: Floats, rotation: Floats, drive: EgoDrive) -> Rays:
    """Return the rays of fan f at their firing times, before any intersection.

    Parameters
    ----------
    time
        (M / J,) firing times of the fan's azimuths, evenly spaced [s].
    origin, rotation
        (3,), (3, 3) pose of the unit in the ego frame.
    """
    first, end = grid.fan_column[f], grid.fan_column[f + 1]
    rays = slice(grid.fan_ray[f], grid.fan_ray[f + 1])
    columns = end - first
    shape = (columns, (grid.fan_ray[f + 1] - grid.fan_ray[f]) // columns)
    column = np.empty((9, columns))
    _aim(grid.azimuth, first, grid.rays_wide, time, origin, rotation, drive, column)
    return Rays(
        column, grid.slope[rays].reshape(shape), grid.cos[rays].reshape(shape), grid.far[rays].reshape(shape),
        np.empty((4, *shape)), np.empty((3, *shape), np.int64),
    )  # fmt: skip


@njit(cache=True)
def _aim(
    azimuth: Floats, first: int, rays_wide: int, time: Floats, origin: Floats, rotation: Floats, drive: EgoDrive,
    column: Floats,
) -> None:  # fmt: skip
    """Fill the columns (9, M): origin, forward and up in the ego frame."""
    cos, sin, step_cos, step_sin = rotation_steps(drive.yaw_rate * time[0], drive.yaw_rate, time)
    for k in range(len(time)):
        ego_x, ego_y = ego_at(drive, time[k])
        x, y = cos * origin[0] - sin * origin[1] + ego_x, sin * origin[0] + cos * origin[1] + ego_y
        up_x, up_y = cos * rotation[0, 2] - sin * rotation[1, 2], sin * rotation[0, 2] + cos * rotation[1, 2]
        for m in range(k * rays_wide, (k + 1) * rays_wide):
            ca, sa = azimuth[0, first + m], azimuth[1, first + m]
            fx, fy = rotation[0, 0] * ca + rotation[0, 1] * sa, rotation[1, 0] * ca + rotation[1, 1] * sa
            column[0, m], column[1, m], column[2, m] = x, y, origin[2]
            column[3, m], column[4, m] = cos * fx - sin * fy, sin * fx + cos * fy
            column[5, m] = rotation[2, 0] * ca + rotation[2, 1] * sa
            column[6, m], column[7, m], column[8, m] = up_x, up_y, rotation[2, 2]
        cos, sin = cos * step_cos - sin * step_sin, sin * step_cos + cos * step_sin


@njit(cache=True)
def rotation_steps(start: float, rate: float, time: Floats) -> tuple[float, float, float, float]:
    """Return cosine and sine of a start angle, and of the rotation between successive, evenly spaced times.

    Multiplying by the step replaces a cosine and a sine per step; the error after 2000 steps is below 1e-12.
    """
    step = rate * (time[1] - time[0]) if len(time) > 1 else 0.0
    return math.cos(start), math.sin(start), math.cos(step), math.sin(step)


@njit(cache=True, error_model="numpy")
def intersect_ground(rays: Rays) -> None:
    """End the rays on the ground, the plane z = 0, or on nothing at the maximum range."""
    # Unpacked once: each access to a record's array costs an atomic reference count.
    column, slope, far = rays.column, rays.slope, rays.far
    inverse_depth = rays.hit[INVERSE_DEPTH]
    target, inner_surface = rays.hit_id[TARGET], rays.hit_id[INNER_SURFACE]
    for m in range(len(slope)):
        level, per_slope = -column[5, m] / column[2, m], -column[8, m] / column[2, m]
        for i in range(slope.shape[1]):
            at = level + slope[m, i] * per_slope
            inverse_depth[m, i] = max(at, far[m, i])
            target[m, i] = GROUND if at > far[m, i] else NOTHING
            inner_surface[m, i] = NONE


@njit(cache=True, error_model="numpy")
def intersect_walls(rows: Ints, rays_wide: int, rays: Rays, static: StaticScene) -> None:
    """End the rays on walls nearer than their hits so far; rows (K, 3) are wall, first azimuth and end."""
    for row in range(len(rows)):
        _intersect_wall(rows[row, 0], rows[row, 1] * rays_wide, rows[row, 2] * rays_wide, rays, static)


@njit(cache=True, error_model="numpy")
def _intersect_wall(w: int, first: int, end: int, rays: Rays, static: StaticScene) -> None:
    """End the rays of columns [first, end) on wall w where it is nearer than their hits so far."""
    # Unpacked once: each access to a record's array costs an atomic reference count.
    ends, z, column, slope, cos = static.ends, static.z, rays.column, rays.slope, rays.cos
    inverse_depth, cosine = rays.hit[INVERSE_DEPTH], rays.hit[COSINE]
    target, surface = rays.hit_id[TARGET], rays.hit_id[SURFACE]
    ex, ey = ends[w, 2] - ends[w, 0], ends[w, 3] - ends[w, 1]
    length = math.sqrt(ex * ex + ey * ey)
    ex, ey = ex / length, ey / length
    for m in range(first, end):
        gx, gy = ends[w, 0] - column[0, m], ends[w, 1] - column[1, m]
        aside, before = gx * ey - gy * ex, gx * ex + gy * ey
        for i in range(slope.shape[1]):
            dx, dy = column[3, m] + slope[m, i] * column[6, m], column[4, m] + slope[m, i] * column[7, m]
            at = (dx * ey - dy * ex) / aside
            along = (dx * ex + dy * ey) / at - before
            height = column[2, m] + (column[5, m] + slope[m, i] * column[8, m]) / at
            if inverse_depth[m, i] < at < math.inf and 0.0 <= along <= length and z[w, 0] <= height <= z[w, 1]:
                inverse_depth[m, i], target[m, i], surface[m, i] = at, WALL, w
                cosine[m, i] = abs(aside) * at * cos[m, i]
