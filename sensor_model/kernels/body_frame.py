"""Rays of a block of azimuths in the frame of one body, and the azimuths that may hit each of its solids."""

import math

import numpy as np

from luxloop.arrays import Floats
from luxloop.compiled import kernel
from luxloop.sensor_model.kernels.motion import body_at
from luxloop.sensor_model.kernels.rays import rotation_steps

_WIDER = 1.1  # factor of a beam's width that covers the second order of its rays' angles
_SLACK = 1e-9  # tolerance for rounding, so that no grazing ray is culled


@kernel()
def slope_extremes(slope: Floats) -> tuple[Floats, Floats]:
    """Return (2, K) least and largest slope of the rays of each azimuth, and (K,) length of the longest per forward."""
    extremes, longest = np.empty((2, len(slope))), np.empty(len(slope))
    for k in range(len(slope)):
        low, high = slope[k, 0, 0], slope[k, 0, 0]
        for layer in range(slope.shape[1]):
            low, high = min(low, slope[k, layer, 0]), max(high, slope[k, layer, -1])
        extremes[0, k], extremes[1, k] = low, high
        longest[k] = math.sqrt(1.0 + max(low * low, high * high)) + _SLACK
    return extremes, longest


@kernel(inline="always")
def into_body_frame(line: Floats, begin: int, stop: int, time: Floats, motion: Floats, a: int, local: Floats) -> None:
    """Fill `local` (12, C) with the lines of azimuths [begin, stop) in the frame of body a at their firing times."""
    rate = motion[a, 7]
    cos, sin, step_cos, step_sin = rotation_steps(motion[a, 2] + rate * time[begin], rate, time)
    for k in range(begin, stop):
        c = k - begin
        x, y = body_at(motion, a, time[k])
        dx, dy = line[0, k] - x, line[1, k] - y
        local[0, c], local[1, c], local[2, c] = cos * dx + sin * dy, cos * dy - sin * dx, line[2, k]
        for axis in (3, 6, 9):
            local[axis, c] = cos * line[axis, k] + sin * line[axis + 1, k]
            local[axis + 1, c] = cos * line[axis + 1, k] - sin * line[axis, k]
            local[axis + 2, c] = line[axis + 2, k]
        cos, sin = cos * step_cos - sin * step_sin, sin * step_cos + cos * step_sin


@kernel(error_model="numpy", inline="always")
def azimuth_limits(
    local: Floats, extremes: Floats, first: int, azimuths: int, half_width: float, limits: Floats
) -> None:
    """Fill (7, C): extreme directions of each azimuth in plan (x, y, x, y), bounds of its climb, and its width.

    Climb is height over distance in plan. A ray between the lowest l and the highest h is a l + b h with a, b >= 0. It
    is steeper than both where they differ in plan by an angle v, because |a l + b h| is then shorter than
    a |l| + b |h|, by a factor down to cos(v / 2). The width is the largest angle in plan between a ray and the centre
    of its beam; it grows with the climb.
    """
    start = np.uint64(first)
    for c in range(np.uint64(azimuths)):
        down, up = extremes[0, start + c], extremes[1, start + c]
        lx, ly, lz = (
            local[3, c] + down * local[9, c],
            local[4, c] + down * local[10, c],
            local[5, c] + down * local[11, c],
        )
        hx, hy = local[3, c] + up * local[9, c], local[4, c] + up * local[10, c]
        hz = local[5, c] + up * local[11, c]
        one, other = 1.0 / math.sqrt(lx * lx + ly * ly), 1.0 / math.sqrt(hx * hx + hy * hy)
        lx, ly, lz, hx, hy, hz = one * lx, one * ly, one * lz, other * hx, other * hy, other * hz
        steeper = 1.0 / math.sqrt(0.5 * (1.0 + lx * hx + ly * hy) + 1e-12)
        fall, climb = min(lz, hz), max(lz, hz)
        limits[0, c], limits[1, c], limits[2, c], limits[3, c] = lx, ly, hx, hy
        fall, climb = min(fall, fall * steeper), max(climb, climb * steeper)
        beside = _WIDER * half_width * (1.0 + max(fall * fall, climb * climb))
        limits[4, c], limits[5, c], limits[6, c] = fall - beside - _SLACK, climb + beside + _SLACK, beside


@kernel(error_model="numpy", inline="always")
def azimuth_span(bounds: Floats, p: int, local: Floats, azimuths: int, limits: Floats) -> tuple[int, int]:
    """Return the range [first, end) of azimuths that holds every ray that may hit the box around solid p.

    Parameters
    ----------
    bounds
        (P, 2, 3) lower and upper corners of the boxes, in the frame of the body.
    local, limits
        As in `into_body_frame` and `azimuth_limits`.
    """
    length, width = 0.5 * (bounds[p, 1, 0] - bounds[p, 0, 0]), 0.5 * (bounds[p, 1, 1] - bounds[p, 0, 1])
    cx, cy = 0.5 * (bounds[p, 0, 0] + bounds[p, 1, 0]), 0.5 * (bounds[p, 0, 1] + bounds[p, 1, 1])
    radius = math.sqrt(length * length + width * width)
    bottom_z, top_z = bounds[p, 0, 2], bounds[p, 1, 2]
    left, right = azimuths, 0
    for c in range(azimuths):
        x, y = cx - local[0, c], cy - local[1, c]
        lx, ly, hx, hy = limits[0, c], limits[1, c], limits[2, c], limits[3, c]
        distance = math.sqrt(x * x + y * y)
        near, far = max(0.0, distance - radius), distance + radius
        beside = limits[6, c] * far + _SLACK  # of rays that are not at the centre of their beam
        # Offset of the box centre to the left of a ray, against the half width of the box across the ray.
        left_of_low, left_of_high = lx * y - ly * x, hx * y - hy * x
        across_low = abs(lx) * width + abs(ly) * length + beside
        across_high = abs(hx) * width + abs(hy) * length + beside
        top = local[2, c] + max(limits[5, c] * near, limits[5, c] * far)
        bottom = local[2, c] + min(limits[4, c] * near, limits[4, c] * far)
        missed = (
            (left_of_low > across_low) & (left_of_high > across_high)
            | (left_of_low < -across_low) & (left_of_high < -across_high)
            | (lx * x + ly * y < -radius - beside) & (hx * x + hy * y < -radius - beside)
            | (top < bottom_z)
            | (bottom > top_z)
        )
        left = min(left, azimuths if missed else c)
        right = max(right, 0 if missed else c + 1)
    return left, right


@kernel(inline="always")
def plan_distance(bounds: Floats, p: int, local: Floats, c: int) -> float:
    """Return a distance in plan that the box around solid p is not nearer than to the origin of azimuth c [m].

    A ray forward + slope x up meets the box at an inverse depth of at most sqrt(1 + slope^2) over this distance.
    """
    x, y = local[0, c], local[1, c]
    ahead = max(bounds[p, 0, 0] - x, x - bounds[p, 1, 0])
    aside = max(bounds[p, 0, 1] - y, y - bounds[p, 1, 1])
    return float(max(ahead, aside, 0.0))


@kernel(inline="always")
def farthest_distance(bounds: Floats, p: int, local: Floats, c: int) -> float:
    """Return the distance of the farthest corner of the box around solid or body p from the origin of azimuth c [m]."""
    squared = 0.0
    for axis in range(3):
        origin = local[axis, c]
        squared += max(bounds[p, 1, axis] - origin, origin - bounds[p, 0, axis]) ** 2
    return math.sqrt(squared)
