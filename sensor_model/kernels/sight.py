"""Which columns of a fan may meet a thing: its azimuth interval, seen from a unit, is a range of columns.

A thing that moves during the sweep, or is passed by the ego, is taken larger by the way it goes in that time.
"""

import math

import numpy as np
from numba import njit

from sensor_model.kernels.records import Beams, Drive, Fans, Floats, Ints, Solids, Surroundings, Units

_SLACK = 1e-9  # of a step: rounding must not lose the beam that just grazes a thing


@njit(cache=True)
def in_sight(
    fans: Fans, f: int, beams: Beams, units: Units, bodies: Solids, around: Surroundings, drive: Drive
) -> tuple[Ints, Ints]:
    """Rows (thing, first column, end) of the bodies and of the walls that fan f may meet.

    A thing has two rows if it is at both ends of a fan that goes all around.
    """
    u, first = fans.fan_unit[f], fans.row_beam[fans.fan_row[f]]
    count = fans.row_beam[fans.fan_row[f] + 1] - first
    time = max(abs(beams.time[first]), abs(beams.time[first + count - 1]))
    origin, rotation, reach = units.origin[u], units.rotation[u], units.range_max[u]
    arm = math.hypot(origin[0], origin[1])
    turn = abs(drive.yaw_rate) * time
    way = _way(drive.vx, drive.vy, drive.ax, drive.ay, time) + turn * arm
    spread = turn + np.max(np.abs(np.arcsin(units.turn[u, :, 1])))

    motion = bodies.motion
    x, y = np.empty(8), np.empty(8)
    body_rows = np.empty((3 * len(motion), 3), np.int64)
    used = 0
    for a in range(len(motion)):
        radius = _radius(bodies.bounds[a])
        margin = way + abs(motion[a, 7]) * time * radius
        margin += _way(motion[a, 3], motion[a, 4], motion[a, 5], motion[a, 6], time)
        if math.hypot(motion[a, 0] - origin[0], motion[a, 1] - origin[1]) - radius - margin < reach:
            _body_corners(bodies.bounds[a], motion[a], margin, origin, rotation, x, y)
            low, high = _azimuth_interval(x, y)
            used = _add_columns(a, low - spread, high + spread, fans.fan_azimuth[f], count, body_rows, used)

    wall_rows = np.empty((3 * len(around.ends), 3), np.int64)
    used_walls = 0
    for w in range(len(around.ends)):
        if _distance_to_origin(around.ends[w]) < reach + way + arm:
            _wall_corners(around.ends[w], around.z[w], way, origin, rotation, x, y)
            low, high = _azimuth_interval(x, y)
            used_walls = _add_columns(w, low - spread, high + spread, fans.fan_azimuth[f], count, wall_rows, used_walls)
    return body_rows[:used], wall_rows[:used_walls]


@njit(cache=True)
def _way(vx: float, vy: float, ax: float, ay: float, time: float) -> float:
    """Upper bound of how far a thing goes in a time."""
    return math.hypot(vx, vy) * time + 0.5 * math.hypot(ax, ay) * time * time


@njit(cache=True)
def _radius(bounds: Floats) -> float:
    """Of the circle around the origin that holds a box in plan."""
    return math.hypot(max(-bounds[0, 0], bounds[1, 0]), max(-bounds[0, 1], bounds[1, 1]))


@njit(cache=True)
def _body_corners(
    bounds: Floats, pose: Floats, margin: float, origin: Floats, rotation: Floats, x: Floats, y: Floats
) -> None:
    """Fill x and y (8,) with the corners, in a unit's frame, of a body's box grown by a margin."""
    cos, sin = math.cos(pose[2]), math.sin(pose[2])
    for i in range(8):
        front, left, top = i & 1, (i >> 1) & 1, (i >> 2) & 1
        bx = bounds[front, 0] + (2 * front - 1) * margin
        by = bounds[left, 1] + (2 * left - 1) * margin
        ex, ey = pose[0] + cos * bx - sin * by - origin[0], pose[1] + sin * bx + cos * by - origin[1]
        x[i], y[i] = _in_unit(ex, ey, bounds[top, 2] - origin[2], rotation)


@njit(cache=True)
def _wall_corners(
    ends: Floats, z: Floats, margin: float, origin: Floats, rotation: Floats, x: Floats, y: Floats
) -> None:
    """Fill x and y (8,) with the corners, in a unit's frame, of a box around a wall grown by a margin."""
    ex, ey = ends[2] - ends[0], ends[3] - ends[1]
    ux, uy = margin * ex / math.hypot(ex, ey), margin * ey / math.hypot(ex, ey)
    for i in range(8):
        far, left, top = i & 1, (i >> 1) & 1, (i >> 2) & 1
        along, across = 2 * far - 1, 2 * left - 1
        wx = ends[0] + far * ex + along * ux - across * uy - origin[0]
        wy = ends[1] + far * ey + along * uy + across * ux - origin[1]
        x[i], y[i] = _in_unit(wx, wy, z[top] - origin[2], rotation)


@njit(cache=True)
def _in_unit(x: float, y: float, z: float, rotation: Floats) -> tuple[float, float]:
    """First two coordinates of a vector in the frame of a unit."""
    return (
        rotation[0, 0] * x + rotation[1, 0] * y + rotation[2, 0] * z,
        rotation[0, 1] * x + rotation[1, 1] * y + rotation[2, 1] * z,
    )


@njit(cache=True)
def _azimuth_interval(x: Floats, y: Floats) -> tuple[float, float]:
    """Azimuths of the convex hull of points seen from the origin: low, high; infinite if it is around the origin."""
    cx, cy = x.mean(), y.mean()
    low, high = 0.0, 0.0
    for i in range(len(x)):
        turned = math.atan2(cx * y[i] - cy * x[i], cx * x[i] + cy * y[i])
        low, high = min(low, turned), max(high, turned)
    if high - low >= math.pi or (cx == 0.0 and cy == 0.0):
        return -math.inf, math.inf
    centre = math.atan2(cy, cx)
    return centre + low, centre + high


@njit(cache=True)
def _add_columns(thing: int, low: float, high: float, azimuth: Floats, count: int, rows: Ints, used: int) -> int:
    """Append the columns whose azimuth is between low and high; `azimuth` (2,) is the first one and its step.

    Returns
    -------
    How many rows there are now.
    """
    if high - low >= 2.0 * math.pi:
        rows[used, 0], rows[used, 1], rows[used, 2] = thing, 0, count
        return used + 1
    for turn in range(-1, 2):
        shift = 2.0 * math.pi * turn - azimuth[0]
        first = max(0.0, math.ceil((high + shift) / azimuth[1] - _SLACK))
        last = min(count - 1.0, math.floor((low + shift) / azimuth[1] + _SLACK))
        if first <= last:
            rows[used, 0], rows[used, 1], rows[used, 2] = thing, int(first), int(last) + 1
            used += 1
    return used


@njit(cache=True)
def _distance_to_origin(ends: Floats) -> float:
    """Distance of the origin to the segment between two points (4,) x, y, x, y."""
    ex, ey = ends[2] - ends[0], ends[3] - ends[1]
    along = -(ends[0] * ex + ends[1] * ey) / (ex * ex + ey * ey)
    along = min(1.0, max(0.0, along))
    return math.hypot(ends[0] + along * ex, ends[1] + along * ey)
