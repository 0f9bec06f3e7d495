"""Which azimuths of a fan may meet a thing: the interval that it spans, seen from a unit.

A thing that moves during the sweep, or is passed by the ego, is taken larger by the way it goes in that time.
"""

import math

import numpy as np
from numba import njit

from sensor_model.arrays import Floats, Ints
from sensor_model.kernels.records import EgoDrive

_SLACK = 1e-9  # of a step: rounding must not lose the beam that just grazes a thing


@njit(cache=True)
def bodies_in_sight(
    motion: Floats, bounds: Floats, origin: Floats, rotation: Floats, reach: float, half_width: float, time: float,
    drive: EgoDrive, interval: Floats,
) -> None:  # fmt: skip
    """Fill `interval` (A, 2) with lowest and highest azimuth of the beams that may meet each body; empty, NaN, if none.

    Parameters
    ----------
    motion, bounds
        As in `records.Solids`.
    origin, rotation, reach, half_width
        Of the unit: pose in the ego frame, range, and half of a beam's width.
    time
        The longest that any of its beams fires before or after the frame's time [s].
    """
    x, y = np.empty(8), np.empty(8)
    passed, turned = _passed(drive, origin, time)
    for a in range(len(motion)):
        interval[a, 0], interval[a, 1] = math.nan, math.nan
        radius = _radius(bounds, a)
        margin = passed + abs(motion[a, 7]) * time * radius
        margin += _way(motion[a, 3], motion[a, 4], motion[a, 5], motion[a, 6], time)
        if math.hypot(motion[a, 0] - origin[0], motion[a, 1] - origin[1]) - radius - margin < reach:
            _body_corners(bounds, motion, a, margin, origin, rotation, x, y)
            low, high = _azimuth_interval(x, y)
            interval[a, 0], interval[a, 1] = low - turned - half_width, high + turned + half_width


@njit(cache=True)
def walls_in_sight(
    ends: Floats, z: Floats, origin: Floats, rotation: Floats, reach: float, half_width: float, time: float,
    drive: EgoDrive, interval: Floats,
) -> None:  # fmt: skip
    """Like `bodies_in_sight`, of walls (E,)."""
    x, y = np.empty(8), np.empty(8)
    passed, turned = _passed(drive, origin, time)
    for w in range(len(ends)):
        interval[w, 0], interval[w, 1] = math.nan, math.nan
        if _distance(ends, w, origin) < reach + passed:
            _wall_corners(ends, z, w, passed, origin, rotation, x, y)
            low, high = _azimuth_interval(x, y)
            interval[w, 0], interval[w, 1] = low - turned - half_width, high + turned + half_width


@njit(cache=True)
def reach_of_rig(origin: Floats, reach: Floats, time: float, drive: EgoDrive) -> float:
    """Return how far from the ego, in plan, a beam of any unit gets, straight on or by way of mirrors [m].

    Parameters
    ----------
    origin, reach
        (U, 3) where each unit is in the ego frame, and (U,) its range.
    time
        The longest that a beam fires before or after the frame's time [s].
    """
    farthest = 0.0
    for u in range(len(reach)):
        passed, _ = _passed(drive, origin[u], time)
        farthest = max(farthest, math.hypot(origin[u, 0], origin[u, 1]) + passed + reach[u])
    return farthest


@njit(cache=True)
def azimuths_in(interval: Floats, first: float, step: float, count: int, rows: Ints) -> int:
    """Fill `rows` (thing, first azimuth, end) with what of each thing's interval is in a fan; return how many.

    A thing has two rows if it is at both ends of a fan that goes all around.
    """
    used = 0
    for thing in range(len(interval)):
        low, high = interval[thing, 0], interval[thing, 1]
        if high - low >= 2.0 * math.pi:
            rows[used, 0], rows[used, 1], rows[used, 2] = thing, 0, count
            used += 1
        elif low <= high:
            for turn in range(-1, 2):
                shift = 2.0 * math.pi * turn - first
                begin = max(0.0, math.ceil((high + shift) / step - _SLACK))
                last = min(count - 1.0, math.floor((low + shift) / step + _SLACK))
                if begin <= last:
                    rows[used, 0], rows[used, 1], rows[used, 2] = thing, int(begin), int(last) + 1
                    used += 1
    return used


@njit(cache=True)
def _passed(drive: EgoDrive, origin: Floats, time: float) -> tuple[float, float]:
    """How far a unit goes with the ego in a time [m], and how far it turns [rad], at most."""
    turned = abs(drive.yaw_rate) * time
    return _way(drive.vx, drive.vy, drive.ax, drive.ay, time) + turned * math.hypot(origin[0], origin[1]), turned


@njit(cache=True)
def _way(vx: float, vy: float, ax: float, ay: float, time: float) -> float:
    """Upper bound of how far a thing goes in a time."""
    return math.hypot(vx, vy) * time + 0.5 * math.hypot(ax, ay) * time * time


@njit(cache=True)
def _radius(bounds: Floats, a: int) -> float:
    """Of the circle around the origin that holds box a in plan."""
    return math.hypot(max(-bounds[a, 0, 0], bounds[a, 1, 0]), max(-bounds[a, 0, 1], bounds[a, 1, 1]))


@njit(cache=True)
def _body_corners(
    bounds: Floats, motion: Floats, a: int, margin: float, origin: Floats, rotation: Floats, x: Floats, y: Floats
) -> None:
    """Fill x and y (8,) with the corners, in a unit's frame, of body a's box grown by a margin."""
    cos, sin = math.cos(motion[a, 2]), math.sin(motion[a, 2])
    for i in range(8):
        front, left, top = i & 1, (i >> 1) & 1, (i >> 2) & 1
        bx = bounds[a, front, 0] + (2 * front - 1) * margin
        by = bounds[a, left, 1] + (2 * left - 1) * margin
        ex, ey = motion[a, 0] + cos * bx - sin * by - origin[0], motion[a, 1] + sin * bx + cos * by - origin[1]
        x[i], y[i] = _in_unit(ex, ey, bounds[a, top, 2] - origin[2], rotation)


@njit(cache=True)
def _wall_corners(
    ends: Floats, z: Floats, w: int, margin: float, origin: Floats, rotation: Floats, x: Floats, y: Floats
) -> None:
    """Fill x and y (8,) with the corners, in a unit's frame, of a box around wall w grown by a margin."""
    ex, ey = ends[w, 2] - ends[w, 0], ends[w, 3] - ends[w, 1]
    ux, uy = margin * ex / math.hypot(ex, ey), margin * ey / math.hypot(ex, ey)
    for i in range(8):
        far, left, top = i & 1, (i >> 1) & 1, (i >> 2) & 1
        along, across = 2 * far - 1, 2 * left - 1
        wx = ends[w, 0] + far * ex + along * ux - across * uy - origin[0]
        wy = ends[w, 1] + far * ey + along * uy + across * ux - origin[1]
        x[i], y[i] = _in_unit(wx, wy, z[w, top] - origin[2], rotation)


@njit(cache=True)
def _in_unit(x: float, y: float, z: float, rotation: Floats) -> tuple[float, float]:
    """First two coordinates of a vector in the frame of a unit."""
    return (
        rotation[0, 0] * x + rotation[1, 0] * y + rotation[2, 0] * z,
        rotation[0, 1] * x + rotation[1, 1] * y + rotation[2, 1] * z,
    )


@njit(cache=True, error_model="numpy")
def _azimuth_interval(x: Floats, y: Floats) -> tuple[float, float]:
    """Lowest and highest azimuth of the convex hull of 8 points from the origin; infinite if that may be inside."""
    cx, cy = 0.0, 0.0
    for i in range(8):
        cx, cy = cx + x[i], cy + y[i]
    # Tangents of the angles to the middle, which order the points as long as all are ahead.
    low, high, behind = 0.0, 0.0, False
    for i in range(8):
        ahead, aside = cx * x[i] + cy * y[i], cx * y[i] - cy * x[i]
        low, high, behind = min(low, aside / ahead), max(high, aside / ahead), behind or ahead <= 0.0
    if behind:
        return _wide_interval(x, y, cx, cy)
    centre = math.atan2(cy, cx)
    return centre + math.atan(low), centre + math.atan(high)


@njit(cache=True)
def _wide_interval(x: Floats, y: Floats, cx: float, cy: float) -> tuple[float, float]:
    """The same where some point is more than a right angle off the middle (cx, cy)."""
    low, high = 0.0, 0.0
    for i in range(8):
        turned = math.atan2(cx * y[i] - cy * x[i], cx * x[i] + cy * y[i])
        low, high = min(low, turned), max(high, turned)
    if high - low >= math.pi or (cx == 0.0 and cy == 0.0):
        return -math.inf, math.inf
    centre = math.atan2(cy, cx)
    return centre + low, centre + high


@njit(cache=True)
def _distance(ends: Floats, w: int, origin: Floats) -> float:
    """Distance in plan of a point to wall w."""
    ex, ey = ends[w, 2] - ends[w, 0], ends[w, 3] - ends[w, 1]
    gx, gy = ends[w, 0] - origin[0], ends[w, 1] - origin[1]
    along = min(1.0, max(0.0, -(gx * ex + gy * ey) / (ex * ex + ey * ey)))
    return math.hypot(gx + along * ex, gy + along * ey)
