"""Culling of bodies and walls: azimuths of a fan that may hit each, by those that the boxes around them cover.

An object that moves during the scan, or that the ego passes, is enlarged by the distance it moves in that time.
"""

import math

import numpy as np

from luxloop import elementary
from luxloop.arrays import Floats, Ints
from luxloop.compiled import kernel
from luxloop.sensor_model.kernels.records import EgoDrive


@kernel()
def body_interval(
    bounds: Floats, motion: Floats, a: int, margin: float, origin: Floats, rotation: Floats, x: Floats, y: Floats
) -> tuple[float, float]:
    """Return the lowest and highest azimuth of body a's box enlarged by a margin; `x` and `y` (8,) are work arrays."""
    cos, sin = elementary.cos(motion[a, 2]), elementary.sin(motion[a, 2])
    for i in range(8):
        front, left, top = i & 1, (i >> 1) & 1, (i >> 2) & 1
        bx = bounds[a, front, 0] + (2 * front - 1) * margin
        by = bounds[a, left, 1] + (2 * left - 1) * margin
        ex, ey = motion[a, 0] + cos * bx - sin * by - origin[0], motion[a, 1] + sin * bx + cos * by - origin[1]
        x[i], y[i] = _in_unit_frame(ex, ey, bounds[a, top, 2] - origin[2], rotation)
    return _hull_interval(x, y)


@kernel()
def wall_interval(
    ends: Floats, z: Floats, w: int, margin: float, origin: Floats, rotation: Floats, x: Floats, y: Floats
) -> tuple[float, float]:
    """Return the same of a box around wall w enlarged by a margin."""
    ex, ey = ends[w, 2] - ends[w, 0], ends[w, 3] - ends[w, 1]
    ux, uy = margin * ex / elementary.hypot(ex, ey), margin * ey / elementary.hypot(ex, ey)
    for i in range(8):
        far, left, top = i & 1, (i >> 1) & 1, (i >> 2) & 1
        along, across = 2 * far - 1, 2 * left - 1
        wx = ends[w, 0] + far * ex + along * ux - across * uy - origin[0]
        wy = ends[w, 1] + far * ey + along * uy + across * ux - origin[1]
        x[i], y[i] = _in_unit_frame(wx, wy, z[w, top] - origin[2], rotation)
    return _hull_interval(x, y)


@kernel()
def _in_unit_frame(x: float, y: float, z: float, rotation: Floats) -> tuple[float, float]:
    """Return x and y of a vector in the frame of a unit."""
    return (
        rotation[0, 0] * x + rotation[1, 0] * y + rotation[2, 0] * z,
        rotation[0, 1] * x + rotation[1, 1] * y + rotation[2, 1] * z,
    )


@kernel(error_model="numpy")
def _hull_interval(x: Floats, y: Floats) -> tuple[float, float]:
    """Return the azimuth interval of the convex hull of 8 points; infinite if the origin may be inside."""
    cx, cy = 0.0, 0.0
    for i in range(8):
        cx, cy = cx + x[i], cy + y[i]
    # Tangents of the angles to the mean direction order the points as long as all are ahead.
    low, high, behind = 0.0, 0.0, False
    for i in range(8):
        ahead, aside = cx * x[i] + cy * y[i], cx * y[i] - cy * x[i]
        low, high, behind = min(low, aside / ahead), max(high, aside / ahead), behind or ahead <= 0.0
    if behind:
        return _wide_interval(x, y, cx, cy)
    centre = elementary.atan2(cy, cx)
    return centre + elementary.atan(low), centre + elementary.atan(high)


@kernel()
def _wide_interval(x: Floats, y: Floats, cx: float, cy: float) -> tuple[float, float]:
    """Return the same if a point is more than a right angle away from the mean direction (cx, cy)."""
    low, high = 0.0, 0.0
    for i in range(8):
        turned = elementary.atan2(cx * y[i] - cy * x[i], cx * x[i] + cy * y[i])
        low, high = min(low, turned), max(high, turned)
    if high - low >= math.pi or (cx == 0.0 and cy == 0.0):
        return -math.inf, math.inf
    centre = elementary.atan2(cy, cx)
    return centre + low, centre + high


_SLACK = 1e-9  # share of an azimuth step: tolerance for rounding, so that no grazing beam is culled


@kernel()
def body_intervals(
    motion: Floats, bounds: Floats, origin: Floats, rotation: Floats, reach: float, half_width: float, time: float,
    drive: EgoDrive, interval: Floats,
) -> None:  # fmt: skip
    """Fill `interval` (A, 2) with the lowest and highest azimuth of the beams that may hit each body, NaN if none may.

    Parameters
    ----------
    motion, bounds
        As in `records.Solids`.
    origin, rotation, reach, half_width
        Pose of the unit in the ego frame, maximum range, and half of a beam's width.
    time
        Largest time between the firing of a beam and the frame's time [s].
    """
    x, y = np.empty(8), np.empty(8)
    passed, turned = _unit_motion(drive, origin, time)
    for a in range(len(motion)):
        interval[a, 0], interval[a, 1] = math.nan, math.nan
        radius = _radius(bounds, a)
        margin = passed + abs(motion[a, 7]) * time * radius
        margin += _distance_moved(motion[a, 3], motion[a, 4], motion[a, 5], motion[a, 6], time)
        if elementary.hypot(motion[a, 0] - origin[0], motion[a, 1] - origin[1]) - radius - margin < reach:
            low, high = body_interval(bounds, motion, a, margin, origin, rotation, x, y)
            interval[a, 0], interval[a, 1] = low - turned - half_width, high + turned + half_width


@kernel()
def wall_intervals(
    ends: Floats, z: Floats, origin: Floats, rotation: Floats, reach: float, half_width: float, time: float,
    drive: EgoDrive, interval: Floats,
) -> None:  # fmt: skip
    """Fill `interval` (E, 2) with the lowest and highest azimuth of the beams that may hit each wall, NaN if none may.

    Parameters
    ----------
    ends, z
        As in `records.StaticScene`.
    origin, rotation, reach, half_width, time
        As in `body_intervals`.
    """
    x, y = np.empty(8), np.empty(8)
    passed, turned = _unit_motion(drive, origin, time)
    for w in range(len(ends)):
        interval[w, 0], interval[w, 1] = math.nan, math.nan
        if _wall_distance(ends, w, origin) < reach + passed:
            low, high = wall_interval(ends, z, w, passed, origin, rotation, x, y)
            interval[w, 0], interval[w, 1] = low - turned - half_width, high + turned + half_width


@kernel()
def rig_reach(origin: Floats, reach: Floats, time: float, drive: EgoDrive) -> float:
    """Return the largest distance from the ego, in plan, that a beam of any unit covers, also by way of mirrors [m].

    Parameters
    ----------
    origin, reach
        (U, 3) position of each unit in the ego frame, and (U,) its maximum range.
    time
        Largest time between the firing of a beam and the frame's time [s].
    """
    farthest = 0.0
    for u in range(len(reach)):
        passed, _ = _unit_motion(drive, origin[u], time)
        farthest = max(farthest, elementary.hypot(origin[u, 0], origin[u, 1]) + passed + reach[u])
    return farthest


@kernel()
def azimuths_in_fan(interval: Floats, first: float, step: float, count: int, rows: Ints) -> int:
    """Fill `rows` (object, first azimuth, end) with the part of each object's interval in a fan; return their number.

    An object has two rows if it is at both ends of a fan of a full turn.
    """
    used = 0
    for item in range(len(interval)):
        low, high = interval[item, 0], interval[item, 1]
        if high - low >= 2.0 * math.pi:
            rows[used, 0], rows[used, 1], rows[used, 2] = item, 0, count
            used += 1
        elif low <= high:
            for turn in range(-1, 2):
                shift = 2.0 * math.pi * turn - first
                begin = max(0.0, math.ceil((high + shift) / step - _SLACK))
                last = min(count - 1.0, math.floor((low + shift) / step + _SLACK))
                if begin <= last:
                    rows[used, 0], rows[used, 1], rows[used, 2] = item, int(begin), int(last) + 1
                    used += 1
    return used


@kernel()
def _unit_motion(drive: EgoDrive, origin: Floats, time: float) -> tuple[float, float]:
    """Return upper bounds of a unit's translation [m] and rotation [rad] with the ego in a time."""
    turned = abs(drive.yaw_rate) * time
    distance = _distance_moved(drive.vx, drive.vy, drive.ax, drive.ay, time)
    return distance + turned * elementary.hypot(origin[0], origin[1]), turned


@kernel()
def _distance_moved(vx: float, vy: float, ax: float, ay: float, time: float) -> float:
    """Return an upper bound of the distance moved in a time [m]."""
    return elementary.hypot(vx, vy) * time + 0.5 * elementary.hypot(ax, ay) * time * time


@kernel()
def _radius(bounds: Floats, a: int) -> float:
    """Return the radius of the circle around the origin that holds box a in plan."""
    return elementary.hypot(max(-bounds[a, 0, 0], bounds[a, 1, 0]), max(-bounds[a, 0, 1], bounds[a, 1, 1]))


@kernel()
def _wall_distance(ends: Floats, w: int, origin: Floats) -> float:
    """Return the distance in plan from a point to wall w."""
    ex, ey = ends[w, 2] - ends[w, 0], ends[w, 3] - ends[w, 1]
    gx, gy = ends[w, 0] - origin[0], ends[w, 1] - origin[1]
    along = min(1.0, max(0.0, -(gx * ex + gy * ey) / (ex * ex + ey * ey)))
    return elementary.hypot(gx + along * ex, gy + along * ey)
