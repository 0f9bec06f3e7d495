"""The rays of a fan, and what they meet of ground and walls.

A fan fires columns: at each azimuth n rays from one point at one time, in one plane. The inner loops run over the rays
of a column and hold no branch, so that the compiler can vectorise them; hence `error_model="numpy"`: a division by
zero is infinite.
"""

import math

import numpy as np
from numba import njit

from sensor_model.arrays import Floats, Ints
from sensor_model.kernels.motion import ego_at
from sensor_model.kernels.records import EgoDrive, Grid, Rays, StaticScene
from sensor_model.returns import GROUND, NOTHING, WALL

NONE = -1
"""No plane."""


@njit(cache=True)
def aimed(grid: Grid, f: int, time: Floats, origin: Floats, rotation: Floats, drive: EgoDrive) -> Rays:
    """Rays of fan f, from where its unit is when they fire; they have met nothing yet.

    Parameters
    ----------
    time
        (M / J,) of the fan's azimuths, evenly spaced [s].
    origin, rotation
        (3,), (3, 3) of the unit in the ego frame.
    """
    first, end = grid.fan_column[f], grid.fan_column[f + 1]
    rays = slice(grid.fan_ray[f], grid.fan_ray[f + 1])
    columns = end - first
    shape = (columns, (grid.fan_ray[f + 1] - grid.fan_ray[f]) // columns)
    column = np.empty((9, columns))
    _aim(grid.azimuth, first, grid.turns, time, origin, rotation, drive, column)
    floats, ints = np.empty((4, *shape)), np.empty((3, *shape), np.int64)
    return Rays(
        column, grid.slope[rays].reshape(shape), grid.cos[rays].reshape(shape), grid.far[rays].reshape(shape),
        floats[0], ints[0], ints[1], floats[1], ints[2], floats[2], floats[3],
    )  # fmt: skip


@njit(cache=True)
def _aim(
    azimuth: Floats, first: int, turns: int, time: Floats, origin: Floats, rotation: Floats, drive: EgoDrive,
    column: Floats,
) -> None:  # fmt: skip
    """Fill the columns (9, M): origin, forward and up."""
    cos, sin, step_cos, step_sin = even_turns(drive.yaw_rate * time[0], drive.yaw_rate, time)
    for k in range(len(time)):
        ego_x, ego_y = ego_at(drive, time[k])
        x, y = cos * origin[0] - sin * origin[1] + ego_x, sin * origin[0] + cos * origin[1] + ego_y
        up_x, up_y = cos * rotation[0, 2] - sin * rotation[1, 2], sin * rotation[0, 2] + cos * rotation[1, 2]
        for m in range(k * turns, (k + 1) * turns):
            ca, sa = azimuth[0, first + m], azimuth[1, first + m]
            fx, fy = rotation[0, 0] * ca + rotation[0, 1] * sa, rotation[1, 0] * ca + rotation[1, 1] * sa
            column[0, m], column[1, m], column[2, m] = x, y, origin[2]
            column[3, m], column[4, m] = cos * fx - sin * fy, sin * fx + cos * fy
            column[5, m] = rotation[2, 0] * ca + rotation[2, 1] * sa
            column[6, m], column[7, m], column[8, m] = up_x, up_y, rotation[2, 2]
        cos, sin = cos * step_cos - sin * step_sin, sin * step_cos + cos * step_sin


@njit(cache=True)
def even_turns(start: float, rate: float, time: Floats) -> tuple[float, float, float, float]:
    """Cosine and sine of a first angle, and of how far a thing turns from one of evenly spaced times to the next.

    To turn on from there by products saves a cosine and a sine a step; 2000 steps are off by less than 1e-12.
    """
    step = rate * (time[1] - time[0]) if len(time) > 1 else 0.0
    return math.cos(start), math.sin(start), math.cos(step), math.sin(step)


@njit(cache=True, error_model="numpy")
def meet_ground(
    column: Floats, slope: Floats, far: Floats, nearness: Floats, target: Ints, inner_surface: Ints
) -> None:
    """End the rays on the ground, the plane z = 0, or at the farthest range on nothing."""
    for m in range(len(slope)):
        level, per_slope = -column[5, m] / column[2, m], -column[8, m] / column[2, m]
        for i in range(slope.shape[1]):
            at = level + slope[m, i] * per_slope
            nearness[m, i] = max(at, far[m, i])
            target[m, i] = GROUND if at > far[m, i] else NOTHING
            inner_surface[m, i] = NONE


@njit(cache=True, error_model="numpy")
def meet_walls(rows: Ints, turns: int, rays: Rays, around: StaticScene) -> None:
    """Shorten the rays that meet walls; rows (K, 3) are wall, first azimuth and end."""
    for row in range(len(rows)):
        w = rows[row, 0]
        for m in range(rows[row, 1] * turns, rows[row, 2] * turns):
            _meet_wall(
                around.ends, around.z, w, rays.column, m, rays.slope, rays.cos,
                rays.nearness, rays.target, rays.surface, rays.cosine,
            )  # fmt: skip


@njit(cache=True, error_model="numpy")
def _meet_wall(
    ends: Floats, z: Floats, w: int, column: Floats, m: int, slope: Floats, cos: Floats,
    nearness: Floats, target: Ints, surface: Ints, cosine: Floats,
) -> None:  # fmt: skip
    """Shorten the rays of column m that meet wall w."""
    ex, ey = ends[w, 2] - ends[w, 0], ends[w, 3] - ends[w, 1]
    length = math.sqrt(ex * ex + ey * ey)
    ex, ey = ex / length, ey / length
    gx, gy = ends[w, 0] - column[0, m], ends[w, 1] - column[1, m]
    aside, before = gx * ey - gy * ex, gx * ex + gy * ey
    for i in range(slope.shape[1]):
        dx, dy = column[3, m] + slope[m, i] * column[6, m], column[4, m] + slope[m, i] * column[7, m]
        at = (dx * ey - dy * ex) / aside
        along = (dx * ex + dy * ey) / at - before
        height = column[2, m] + (column[5, m] + slope[m, i] * column[8, m]) / at
        if nearness[m, i] < at < math.inf and 0.0 <= along <= length and z[w, 0] <= height <= z[w, 1]:
            nearness[m, i], target[m, i], surface[m, i] = at, WALL, w
            cosine[m, i] = abs(aside) * at * cos[m, i]
