"""Drivers: they lead the front of each body along its path, and the rear axle follows.

The path's derivatives say what to do, and a little feedback mends what is left: along the way by speed, across it by
steering, as in Hoffmann et al., "Autonomous Automobile Trajectory Tracking for Off-Road Driving" (American Control
Conference 2007), equation 5, with a distance ahead in place of its gain over speed.
"""

import math

import numpy as np
from numba import njit

from sim.arrays import Floats
from sim.physical.kernels.records import ACCELERATION, LAG, SPEED, YAW, YAW_RATE, X, Y
from sim.physical.kernels.rolling_body import fastest_turn, roll, within
from sim.physical.limits import (
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
    HIGHEST_ACCELERATION,
    LAG_STEP_S,
    LATERAL_ACCELERATION,
    SLOW,
    STANDING,
    STEERING,
    STEERING_S,
    STEP_S,
)


@njit(cache=True)
def put(state: Floats, goal: Floats, yaw: float, lead: float, yaw_rate_max: float) -> None:
    """Put a body `state` (10,) at a yaw [rad], its front on its path `goal` (6,), as if it had always followed it."""
    cos, sin = math.cos(yaw), math.sin(yaw)
    speed = max(goal[2] * cos + goal[3] * sin, 0.0)
    state[:] = 0.0
    state[X], state[Y], state[YAW] = goal[0] - lead * cos, goal[1] - lead * sin, yaw
    if speed > 0:
        state[SPEED] = speed
        state[ACCELERATION] = min(max(goal[4] * cos + goal[5] * sin, -GRIP), HIGHEST_ACCELERATION)
    if speed > STANDING:
        limit = fastest_turn(speed, lead, yaw_rate_max)
        state[YAW_RATE] = within((goal[3] * cos - goal[2] * sin) / lead, limit)


@njit(cache=True)
def drive(
    state: Floats, trail: Floats, since: int, frame: int, lead: float, arm: float, yaw_rate_max: float, dt: float
) -> None:
    """Lead a body, from the frame before, to a frame whose path is in the trail already.

    Parameters
    ----------
    state, trail, since
        (10,), (K, 6) and the body's first frame, see `Led`.
    frame
        Where to.
    lead, arm, yaw_rate_max
        See `Builds`.
    dt
        Time between frames [s].
    """
    steps = math.ceil(dt / STEP_S)
    goal = np.empty(6)
    for step in range(steps):
        left = dt * (steps - step - 1) / steps
        front_x = state[X] + lead * math.cos(state[YAW])
        front_y = state[Y] + lead * math.sin(state[YAW])
        _trail_at(trail, since, frame, left + dt / steps + state[LAG], dt, goal)
        state[LAG] = _lag(state[LAG], goal[0] - front_x, goal[1] - front_y, goal[2], goal[3])
        _trail_at(trail, since, frame, left + state[LAG], dt, goal)
        _lead(state, goal, front_x, front_y, lead, arm, yaw_rate_max, dt / steps)


@njit(cache=True)
def _lead(
    state: Floats, goal: Floats, front_x: float, front_y: float, lead: float, arm: float, yaw_rate_max: float, dt: float
) -> None:
    """Lead a body for a step whose end the path's `goal` (6,) is."""
    cos, sin, lag = math.cos(state[YAW]), math.sin(state[YAW]), state[LAG]
    speed = math.hypot(goal[2], goal[3])
    moving = speed > STANDING
    off_x = goal[0] - dt * goal[2] + 0.5 * dt**2 * goal[4] - front_x
    off_y = goal[1] - dt * goal[3] + 0.5 * dt**2 * goal[5] - front_y
    short, beside = off_x * cos + off_y * sin, off_y * cos - off_x * sin

    # what the steering is told now, the body does a little later
    soon = state[YAW] + state[YAW_RATE] * (dt + STEERING_S)
    cos, sin = math.cos(soon), math.sin(soon)
    velocity_x, velocity_y = goal[2] + STEERING_S * goal[4], goal[3] + STEERING_S * goal[5]
    across = velocity_y * cos - velocity_x * sin
    steer = math.atan2(across, velocity_x * cos + velocity_y * sin)
    steer += within(math.atan(beside / (AIM_M + AIM_S * speed)), AIM_RAD)
    angle = within(steer, STEERING)
    curvature = math.tan(angle) / lead if moving else 0.0

    hurry = 0.0
    if abs(steer) <= STEERING:
        behind = lag * max(speed, SLOW) if moving else short
        hurry = within(CATCH_UP * behind, max(CATCH_UP_SHARE * speed, CATCH_UP_LEAST))
    wanted, fastest = max(speed * math.cos(angle) + hurry, 0.0), _fastest(goal, speed)
    if not moving:
        wanted = hurry if hurry > CREEP else 0.0
    own = 0.0
    if moving and angle == steer and wanted < fastest:
        own = goal[4] * cos + goal[5] * sin + across * state[YAW_RATE]
    roll(state, min(wanted, fastest), curvature, own, lead, arm, yaw_rate_max, dt)


@njit(cache=True)
def _lag(lag: float, off_x: float, off_y: float, velocity_x: float, velocity_y: float) -> float:
    """Return the time by which a front is behind its path [s], given how far it is off its place of `lag` ago."""
    speed_squared = velocity_x**2 + velocity_y**2
    more = (off_x * velocity_x + off_y * velocity_y) / max(speed_squared, SLOW**2)
    later = min(max(lag + within(more, LAG_STEP_S), -AHEAD_S), BEHIND_S)
    return later if speed_squared > SLOW**2 or lag > 0 else 0.0


@njit(cache=True)
def _fastest(goal: Floats, speed: float) -> float:
    """Return the greatest speed [m/s] in the bend of a path that goes at `speed`; on a straight, twice that."""
    across = abs(goal[2] * goal[5] - goal[3] * goal[4]) / max(speed, 0.1)
    return max(speed, CATCH_UP_LEAST) * math.sqrt(LATERAL_ACCELERATION / max(across, LATERAL_ACCELERATION / 4))


@njit(cache=True)
def _trail_at(trail: Floats, since: int, frame: int, ago: float, dt: float, out: Floats) -> None:
    """Write the path `ago` [s] before a frame, the latest, to `out` (6,): a cubic between frames.

    Before the first and after the last frame that is known, the derivatives tell.
    """
    length = len(trail)
    wanted = frame - ago / dt
    first = max(since, frame - length + 1)
    before = min(max(math.floor(wanted), first), max(frame - 1, first))
    s = min(max(wanted - before, 0.0), min(frame - before, 1))
    start = trail[before % length]
    end = trail[(before + 1) % length]
    rest = (wanted - before - s) * dt
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
