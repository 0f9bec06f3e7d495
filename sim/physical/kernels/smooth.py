"""The smooth path of a point, from the frames around one."""

import math

from numba import njit

from sim.physical.kernels.records import Said
from sim.world import Floats


@njit(cache=True)
def wrapped(angle: float) -> float:
    """Bring an angle [rad] into (-pi, pi]."""
    return math.pi - (math.pi - angle) % (2 * math.pi)


@njit(cache=True)
def smoothed(
    said: Said, weights: Floats, frame: int, known: int, body: int, leads: bool, dt: float, out: Floats
) -> None:
    """Write the path's place, first and second derivative at a frame to `out` (3, 3): x, y and yaw in its columns.

    The course of a front that leads is not smoothed, and has no derivatives.

    Where the body was not (yet) known, it is taken to go straight on at its speed if a front leads, and else to go on
    with the last known step, turn included.

    Parameters
    ----------
    said
        What the simulator said.
    weights
        (3, 2 H + 1) of the path and its derivatives.
    frame, known
        The frame, and the number of frames that were pushed.
    body
        Its row.
    leads
        Whether the point is a front that leads.
    dt
        Time between frames [s].
    """
    half = weights.shape[1] // 2
    length = said.frame.shape[1]
    now = said.path[body, frame % length]
    out[:] = 0.0
    for sign in (1, -1):
        last = 0
        while last < half and _there(said, frame + sign * (last + 1), known, body):
            last += 1
        step_x, step_y, step_yaw = _onward(said, frame, known, body, sign, last, leads, dt)
        end = said.path[body, (frame + sign * last) % length]
        for n in range(1, half + 1):
            if n <= last:
                pose = said.path[body, (frame + sign * n) % length]
                x, y, yaw = pose[0] - now[0], pose[1] - now[1], pose[2]
            else:
                x = end[0] - now[0] + (n - last) * step_x
                y = end[1] - now[1] + (n - last) * step_y
                yaw = end[2] + (n - last) * step_yaw
            turn = 0.0 if leads else wrapped(yaw - now[2])  # a front's course matters now only
            for order in range(3):
                weight = weights[order, half + sign * n]
                out[order, 0] += weight * x
                out[order, 1] += weight * y
                out[order, 2] += weight * turn
    out[0] += now


@njit(cache=True)
def _there(said: Said, frame: int, known: int, body: int) -> bool:
    return 0 <= frame < known and said.frame[body, frame % said.frame.shape[1]] == frame


@njit(cache=True)
def _onward(
    said: Said, frame: int, known: int, body: int, sign: int, last: int, leads: bool, dt: float
) -> tuple[float, float, float]:
    """Return the step by which a path goes on, in direction `sign` of time, after its last known pose."""
    length = said.frame.shape[1]
    end = said.path[body, (frame + sign * last) % length]
    if not leads:
        before = frame + sign * (last - 1)  # with last = 0 it is on the other side of the frame
        if _there(said, before, known, body):
            pose = said.path[body, before % length]
            return end[0] - pose[0], end[1] - pose[1], wrapped(end[2] - pose[2])
    way = sign * said.speed[body, (frame + sign * last) % length] * dt
    return way * math.cos(end[2]), way * math.sin(end[2]), 0.0
