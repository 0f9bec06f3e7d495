"""Path-following controller: the front of each body follows its path, the rear axle rolls behind.

Feedforward comes from the path's derivatives. Feedback corrects the longitudinal error by speed and the lateral error
by steering, as in Hoffmann et al., "Autonomous Automobile Trajectory Tracking for Off-Road Driving" (American Control
Conference 2007), equation 5, with a look-ahead distance in place of its gain over speed.
"""

import math

import numpy as np

from luxloop import elementary
from luxloop.arrays import Floats
from luxloop.compiled import kernel
from luxloop.sim.physical.kernels.records import ACCELERATION, LAG, SPEED, YAW, YAW_RATE, X, Y
from luxloop.sim.physical.kernels.rolling_body import clamp, step_body, yaw_rate_limit
from luxloop.sim.physical.limits import (
    ACCELERATION_MAX,
    AHEAD_S,
    AIM_M,
    AIM_RAD,
    AIM_S,
    BEHIND_S,
    CATCH_UP,
    CATCH_UP_LEAST,
    CATCH_UP_SHARE,
    CREEP,
    GRIP,
    LAG_STEP_S,
    LATERAL_ACCELERATION,
    SLOW,
    STANDING,
    STEERING,
    STEERING_S,
    STEP_S,
)


@kernel()
def initialise_body(state: Floats, target: Floats, yaw: float, front_offset: float, yaw_rate_max: float) -> None:
    """Initialise a body `state` (10,) at a yaw [rad], with its front on the path at `target` (6,), in steady motion."""
    cos, sin = elementary.cos(yaw), elementary.sin(yaw)
    speed = max(target[2] * cos + target[3] * sin, 0.0)
    state[:] = 0.0
    state[X], state[Y], state[YAW] = target[0] - front_offset * cos, target[1] - front_offset * sin, yaw
    if speed > 0:
        state[SPEED] = speed
        state[ACCELERATION] = min(max(target[4] * cos + target[5] * sin, -GRIP), ACCELERATION_MAX)
    if speed > STANDING:
        limit = yaw_rate_limit(speed, front_offset, yaw_rate_max)
        state[YAW_RATE] = clamp((target[3] * cos - target[2] * sin) / front_offset, limit)


@kernel()
def advance_body(
    state: Floats,
    trail: Floats,
    first_frame: int,
    frame: int,
    front_offset: float,
    limit_offset: float,
    yaw_rate_max: float,
    dt: float,
) -> None:
    """Advance a body from the previous frame to a frame whose path is already in the trail.

    Parameters
    ----------
    state, trail, first_frame
        (10,), (K, 6) and the body's first frame, see `BodyStates`.
    frame
        Frame to reach.
    front_offset, limit_offset, yaw_rate_max
        See `BodyDimensions`.
    dt
        Time between frames [s].
    """
    steps = math.ceil(dt / STEP_S)
    target = np.empty(6)
    for step in range(steps):
        left = dt * (steps - step - 1) / steps
        front_x = state[X] + front_offset * elementary.cos(state[YAW])
        front_y = state[Y] + front_offset * elementary.sin(state[YAW])
        _interpolate_trail(trail, first_frame, frame, left + dt / steps + state[LAG], dt, target)
        state[LAG] = _next_lag(state[LAG], target[0] - front_x, target[1] - front_y, target[2], target[3])
        _interpolate_trail(trail, first_frame, frame, left + state[LAG], dt, target)
        _follow_step(state, target, front_x, front_y, front_offset, limit_offset, yaw_rate_max, dt / steps)


@kernel()
def _follow_step(
    state: Floats,
    target: Floats,
    front_x: float,
    front_y: float,
    front_offset: float,
    limit_offset: float,
    yaw_rate_max: float,
    dt: float,
) -> None:
    """Advance a body by one step towards the path's `target` (6,) at the end of the step."""
    cos, sin, lag = elementary.cos(state[YAW]), elementary.sin(state[YAW]), state[LAG]
    speed = elementary.hypot(target[2], target[3])
    moving = speed > STANDING
    error_x = target[0] - dt * target[2] + 0.5 * dt**2 * target[4] - front_x
    error_y = target[1] - dt * target[3] + 0.5 * dt**2 * target[5] - front_y
    along_error, cross_error = error_x * cos + error_y * sin, error_y * cos - error_x * sin

    # steering commands take effect after a delay
    yaw_ahead = state[YAW] + state[YAW_RATE] * (dt + STEERING_S)
    cos, sin = elementary.cos(yaw_ahead), elementary.sin(yaw_ahead)
    velocity_x, velocity_y = target[2] + STEERING_S * target[4], target[3] + STEERING_S * target[5]
    across = velocity_y * cos - velocity_x * sin
    steer = elementary.atan2(across, velocity_x * cos + velocity_y * sin)
    steer += clamp(elementary.atan(cross_error / (AIM_M + AIM_S * speed)), AIM_RAD)
    angle = clamp(steer, STEERING)
    curvature = elementary.tan(angle) / front_offset if moving else 0.0

    catch_up_speed = 0.0
    if abs(steer) <= STEERING:
        distance_behind = lag * max(speed, SLOW) if moving else along_error
        catch_up_speed = clamp(CATCH_UP * distance_behind, max(CATCH_UP_SHARE * speed, CATCH_UP_LEAST))
    speed_target, speed_max = max(speed * elementary.cos(angle) + catch_up_speed, 0.0), _speed_limit(target, speed)
    if not moving:
        speed_target = catch_up_speed if catch_up_speed > CREEP else 0.0
    feedforward = 0.0
    if moving and angle == steer and speed_target < speed_max:
        feedforward = target[4] * cos + target[5] * sin + across * state[YAW_RATE]
    step_body(state, min(speed_target, speed_max), curvature, feedforward, front_offset, limit_offset, yaw_rate_max, dt)


@kernel()
def _next_lag(lag: float, error_x: float, error_y: float, velocity_x: float, velocity_y: float) -> float:
    """Return the lag of a front behind its path [s], given its offset from the path at the previous `lag`."""
    speed_squared = velocity_x**2 + velocity_y**2
    more = (error_x * velocity_x + error_y * velocity_y) / max(speed_squared, SLOW**2)
    later = min(max(lag + clamp(more, LAG_STEP_S), -AHEAD_S), BEHIND_S)
    return later if speed_squared > SLOW**2 or lag > 0 else 0.0


@kernel()
def _speed_limit(target: Floats, speed: float) -> float:
    """Return the maximum speed [m/s] in the bend of a path with a given speed; on a straight, twice that speed."""
    across = abs(target[2] * target[5] - target[3] * target[4]) / max(speed, 0.1)
    return max(speed, CATCH_UP_LEAST) * math.sqrt(LATERAL_ACCELERATION / max(across, LATERAL_ACCELERATION / 4))


@kernel()
def _interpolate_trail(trail: Floats, first_frame: int, frame: int, ago: float, dt: float, out: Floats) -> None:
    """Write the path `ago` [s] before the latest frame to `out` (6,), by cubic interpolation between frames.

    Before the first and after the last known frame, the path is extrapolated by its derivatives.
    """
    length = len(trail)
    position = frame - ago / dt
    first = max(first_frame, frame - length + 1)
    before = min(max(math.floor(position), first), max(frame - 1, first))
    s = min(max(position - before, 0.0), min(frame - before, 1))
    start = trail[before % length]
    end = trail[(before + 1) % length]
    rest = (position - before - s) * dt
    for c in range(2):
        place = (
            (1 + 2 * s) * (1 - s) * (1 - s) * start[c]
            + s * (1 - s) * (1 - s) * dt * start[2 + c]
            + s * s * (3 - 2 * s) * end[c]
            + s * s * (s - 1) * dt * end[2 + c]
        )
        velocity = start[2 + c] + s * (end[2 + c] - start[2 + c])
        acceleration = start[4 + c] + s * (end[4 + c] - start[4 + c])
        out[c] = place + rest * velocity + 0.5 * rest**2 * acceleration
        out[2 + c] = velocity + rest * acceleration
        out[4 + c] = acceleration
