"""Rays of a fan in the frame of one body, and the columns that may hit each of its solids."""

import math

import numpy as np
from numba import njit

from sensor_model.arrays import Floats
from sensor_model.kernels.motion import body_at
from sensor_model.kernels.rays import rotation_steps

_SLACK = 1e-9  # tolerance for rounding, so that no grazing ray is culled


@njit(cache=True)
def slope_extremes(slope: Floats) -> Floats:
    """Return (2, M) slopes of the lowest and of the highest ray of each column."""
    extremes = np.empty((2, len(slope)))
    for m in range(len(slope)):
        low, high = slope[m, 0], slope[m, 0]
        for i in range(slope.shape[1]):
            low, high = min(low, slope[m, i]), max(high, slope[m, i])
        extremes[0, m], extremes[1, m] = low, high
    return extremes


@njit(cache=True, inline="always")
def into_body_frame(
    column: Floats, begin: int, stop: int, rays_wide: int, time: Floats, motion: Floats, a: int, local: Floats
) -> None:
    """Fill `local` (9, C) with the columns of azimuths [begin, stop) in the frame of body a at their firing times."""
    rate = motion[a, 7]
    cos, sin, step_cos, step_sin = rotation_steps(motion[a, 2] + rate * time[begin], rate, time)
    c = 0
    for k in range(begin, stop):
        x, y = body_at(motion, a, time[k])
        for m in range(k * rays_wide, (k + 1) * rays_wide):
            dx, dy = column[0, m] - x, column[1, m] - y
            local[0, c], local[1, c], local[2, c] = cos * dx + sin * dy, cos * dy - sin * dx, column[2, m]
            for axis in (3, 6):
                local[axis, c] = cos * column[axis, m] + sin * column[axis + 1, m]
                local[axis + 1, c] = cos * column[axis + 1, m] - sin * column[axis, m]
                local[axis + 2, c] = column[axis + 2, m]
            c += 1
        cos, sin = cos * step_cos - sin * step_sin, sin * step_cos + cos * step_sin


@njit(cache=True, error_model="numpy", inline="always")
def column_limits(local: Floats, extremes: Floats, first: int, columns: int, limits: Floats) -> None:
    """Fill (6, C): lowest and highest direction of each column in plan (x, y, x, y), and bounds of its climb.

    Climb is height over distance in plan. A ray between the lowest l and the highest h is a l + b h with a, b >= 0. It
    is steeper than both where they differ in plan by an angle v, because |a l + b h| is then shorter than
    a |l| + b |h|, by a factor down to cos(v / 2).
    """
    start = np.uint64(first)
    for c in range(np.uint64(columns)):
        down, up = extremes[0, start + c], extremes[1, start + c]
        lx, ly, lz = (
            local[3, c] + down * local[6, c],
            local[4, c] + down * local[7, c],
            local[5, c] + down * local[8, c],
        )
        hx, hy = local[3, c] + up * local[6, c], local[4, c] + up * local[7, c]
        hz = local[5, c] + up * local[8, c]
        one, other = 1.0 / math.sqrt(lx * lx + ly * ly), 1.0 / math.sqrt(hx * hx + hy * hy)
        lx, ly, lz, hx, hy, hz = one * lx, one * ly, one * lz, other * hx, other * hy, other * hz
        steeper = 1.0 / math.sqrt(0.5 * (1.0 + lx * hx + ly * hy) + 1e-12)
        fall, climb = min(lz, hz), max(lz, hz)
        limits[0, c], limits[1, c], limits[2, c], limits[3, c] = lx, ly, hx, hy
        limits[4, c] = min(fall, fall * steeper) - _SLACK
        limits[5, c] = max(climb, climb * steeper) + _SLACK


@njit(cache=True, error_model="numpy", inline="always")
def column_span(bounds: Floats, p: int, local: Floats, columns: int, limits: Floats) -> tuple[int, int]:
    """Return the range [first, end) of columns that holds every ray that may hit the box around solid p.

    Parameters
    ----------
    bounds
        (P, 2, 3) lower and upper corners of the boxes, in the frame of the body.
    local, limits
        As filled by `into_body_frame` and `column_limits`.
    """
    length, width = 0.5 * (bounds[p, 1, 0] - bounds[p, 0, 0]), 0.5 * (bounds[p, 1, 1] - bounds[p, 0, 1])
    cx, cy = 0.5 * (bounds[p, 0, 0] + bounds[p, 1, 0]), 0.5 * (bounds[p, 0, 1] + bounds[p, 1, 1])
    radius = math.sqrt(length * length + width * width)
    bottom_z, top_z = bounds[p, 0, 2], bounds[p, 1, 2]
    left, right = columns, 0
    for c in range(columns):
        x, y = cx - local[0, c], cy - local[1, c]
        lx, ly, hx, hy = limits[0, c], limits[1, c], limits[2, c], limits[3, c]
        # Offset of the box centre to the left of a ray, against the half width of the box across the ray.
        left_of_low, left_of_high = lx * y - ly * x, hx * y - hy * x
        across_low = abs(lx) * width + abs(ly) * length + _SLACK
        across_high = abs(hx) * width + abs(hy) * length + _SLACK
        distance = math.sqrt(x * x + y * y)
        near, far = max(0.0, distance - radius), distance + radius
        top = local[2, c] + max(limits[5, c] * near, limits[5, c] * far)
        bottom = local[2, c] + min(limits[4, c] * near, limits[4, c] * far)
        missed = (
            (left_of_low > across_low) & (left_of_high > across_high)
            | (left_of_low < -across_low) & (left_of_high < -across_high)
            | (lx * x + ly * y < -radius) & (hx * x + hy * y < -radius)
            | (top < bottom_z)
            | (bottom > top_z)
        )
        left = min(left, columns if missed else c)
        right = max(right, 0 if missed else c + 1)
    return left, right


@njit(cache=True, inline="always")
def plan_distance(bounds: Floats, p: int, local: Floats, c: int) -> float:
    """Return a distance in plan that the box around solid p is not nearer than to the origin of column c [m].

    A ray forward + slope x up meets the box at an inverse depth of at most sqrt(1 + slope^2) over this distance.
    """
    x, y = local[0, c], local[1, c]
    ahead = max(bounds[p, 0, 0] - x, x - bounds[p, 1, 0])
    aside = max(bounds[p, 0, 1] - y, y - bounds[p, 1, 1])
    return float(max(ahead, aside, 0.0))
