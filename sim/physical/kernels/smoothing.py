"""Kernel that smooths the path of one point over neighbouring frames."""

import math

from luxloop import elementary
from luxloop.arrays import Floats, Ints
from luxloop.compiled import kernel


@kernel()
def wrap_angle(angle: float) -> float:
    """Wrap an angle [rad] into (-pi, pi]."""
    return math.pi - (math.pi - angle) % (2 * math.pi)


@kernel()
def smooth_path(
    frames: Ints,
    path: Floats,
    speed: Floats,
    weights: Floats,
    frame: int,
    pushed: int,
    rolling: bool,
    dt: float,
    out: Floats,
) -> None:
    """Write the path's position, first and second derivative at a frame to `out` (3, 3), with columns x, y and yaw.

    With `rolling`, the course is not smoothed and has no derivatives. Outside of its known frames, the body is
    extrapolated: straight at its speed with `rolling`, else by its last known step, turn included.

    Parameters
    ----------
    frames, path, speed
        (L,), (L, 3) and (L,) of the body, see `RawHistory`.
    weights
        (3, 2 H + 1) weights of the path and its derivatives.
    frame, pushed
        The frame, and the number of frames pushed so far.
    rolling
        The point is a front whose body follows, see `PhysicalTruth`.
    dt
        Time between frames [s].
    """
    half, length = weights.shape[1] // 2, len(frames)
    now_x, now_y, now_yaw = path[frame % length]
    out[:] = 0.0
    for sign in (1, -1):
        last = 0
        while last < half and _is_known(frames, frame + sign * (last + 1), pushed):
            last += 1
        end_x, end_y, end_yaw = path[(frame + sign * last) % length]
        step_x, step_y, step_yaw = _extrapolated_step(frames, path, speed, frame, pushed, sign, last, rolling, dt)
        for n in range(1, half + 1):
            if n <= last:
                x, y, yaw = path[(frame + sign * n) % length]
            else:
                x, y, yaw = end_x + (n - last) * step_x, end_y + (n - last) * step_y, end_yaw + (n - last) * step_yaw
            turn = 0.0 if rolling else wrap_angle(yaw - now_yaw)  # only the present course of a front is used
            for order in range(3):
                weight = weights[order, half + sign * n]
                out[order, 0] += weight * (x - now_x)
                out[order, 1] += weight * (y - now_y)
                out[order, 2] += weight * turn
    out[0, 0] += now_x
    out[0, 1] += now_y
    out[0, 2] += now_yaw


@kernel()
def _is_known(frames: Ints, frame: int, pushed: int) -> bool:
    return 0 <= frame < pushed and frames[frame % len(frames)] == frame


@kernel()
def _extrapolated_step(
    frames: Ints, path: Floats, speed: Floats, frame: int, pushed: int, sign: int, last: int, rolling: bool, dt: float
) -> tuple[float, float, float]:
    """Return the step that continues a path beyond its last known pose, in direction `sign` of time."""
    length = len(frames)
    x, y, yaw = path[(frame + sign * last) % length]
    before = frame + sign * (last - 1)  # with last = 0 this is on the other side of the frame
    if not rolling and _is_known(frames, before, pushed):
        x_before, y_before, yaw_before = path[before % length]
        return x - x_before, y - y_before, wrap_angle(yaw - yaw_before)
    distance = sign * speed[(frame + sign * last) % length] * dt
    return distance * elementary.cos(yaw), distance * elementary.sin(yaw), 0.0
