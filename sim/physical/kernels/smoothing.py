"""The smooth path of a point, from the frames around one."""

import math

from numba import njit

from sim.arrays import Floats, Ints


@njit(cache=True)
def wrapped(angle: float) -> float:
    """Bring an angle [rad] into (-pi, pi]."""
    return math.pi - (math.pi - angle) % (2 * math.pi)


@njit(cache=True)
def smoothed(
    frames: Ints,
    path: Floats,
    speed: Floats,
    weights: Floats,
    frame: int,
    known: int,
    leads: bool,
    dt: float,
    out: Floats,
) -> None:
    """Write the path's place, first and second derivative at a frame to `out` (3, 3): x, y and yaw in its columns.

    The course of a front that leads is not smoothed, and has no derivatives. Where the body was not (yet) known, it is
    taken to go straight on at its speed if a front leads, and else to go on with the last known step, turn included.

    Parameters
    ----------
    frames, path, speed
        (L,), (L, 3) and (L,) of the body, see `Said`.
    weights
        (3, 2 H + 1) of the path and its derivatives.
    frame, known
        The frame, and the number of frames that were pushed.
    leads
        Whether the point is a front that leads.
    dt
        Time between frames [s].
    """
    half, length = weights.shape[1] // 2, len(frames)
    now_x, now_y, now_yaw = path[frame % length]
    out[:] = 0.0
    for sign in (1, -1):
        last = 0
        while last < half and _there(frames, frame + sign * (last + 1), known):
            last += 1
        end_x, end_y, end_yaw = path[(frame + sign * last) % length]
        step_x, step_y, step_yaw = _onward(frames, path, speed, frame, known, sign, last, leads, dt)
        for n in range(1, half + 1):
            if n <= last:
                x, y, yaw = path[(frame + sign * n) % length]
            else:
                x, y, yaw = end_x + (n - last) * step_x, end_y + (n - last) * step_y, end_yaw + (n - last) * step_yaw
            turn = 0.0 if leads else wrapped(yaw - now_yaw)  # a front's course matters now only
            for order in range(3):
                weight = weights[order, half + sign * n]
                out[order, 0] += weight * (x - now_x)
                out[order, 1] += weight * (y - now_y)
                out[order, 2] += weight * turn
    out[0, 0] += now_x
    out[0, 1] += now_y
    out[0, 2] += now_yaw


@njit(cache=True)
def _there(frames: Ints, frame: int, known: int) -> bool:
    return 0 <= frame < known and frames[frame % len(frames)] == frame


@njit(cache=True)
def _onward(
    frames: Ints, path: Floats, speed: Floats, frame: int, known: int, sign: int, last: int, leads: bool, dt: float
) -> tuple[float, float, float]:
    """Return the step by which a path goes on, in direction `sign` of time, after its last known pose."""
    length = len(frames)
    x, y, yaw = path[(frame + sign * last) % length]
    before = frame + sign * (last - 1)  # with last = 0 it is on the other side of the frame
    if not leads and _there(frames, before, known):
        x_before, y_before, yaw_before = path[before % length]
        return x - x_before, y - y_before, wrapped(yaw - yaw_before)
    way = sign * speed[(frame + sign * last) % length] * dt
    return way * math.cos(yaw), way * math.sin(yaw), 0.0
