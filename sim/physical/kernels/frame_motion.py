"""Kernel that computes the motions of all bodies in a frame."""

import numpy as np

from luxloop import elementary
from luxloop.arrays import Floats, Ints
from luxloop.compiled import kernel
from luxloop.sim.physical.kernels.path_following import advance_body, initialise_body
from luxloop.sim.physical.kernels.records import (
    ACCELERATION,
    SPEED,
    TRAILER_RATE,
    TRAILER_YAW,
    YAW,
    YAW_ACCELERATION,
    YAW_RATE,
    BodyDimensions,
    BodyStates,
    RawHistory,
    X,
    Y,
)
from luxloop.sim.physical.kernels.smoothing import smooth_path, wrap_angle

WIDTH = 11
"""Columns of a motion: pose (3), velocity (2), acceleration (2), yaw rate, articulation, deviation (2)."""


@kernel()
def frame_motions(
    frame: int,
    pushed: int,
    rows: Ints,
    history: RawHistory,
    weights: Floats,
    states: BodyStates,
    dimensions: BodyDimensions,
    rolling: bool,
    dt: float,
) -> Floats:
    """Return the motions (N, WIDTH) of the bodies `rows` (N,) in the frame after the last final frame.

    The motion of a tram or train is that of its front: its sections follow along the driven path.

    Parameters
    ----------
    frame, pushed
        The frame, and the number of frames pushed so far.
    history, weights
        See `smooth_path`.
    states
        States of the bodies in the previous frame; written.
    dimensions
        Dimensions of the bodies.
    rolling
        Bodies follow the path with their fronts; else they are only smoothed.
    dt
        Time between frames [s].
    """
    motion = np.zeros((len(rows), WIDTH))
    path = np.empty((3, 3))
    now = frame % history.frame.shape[1]
    for n in range(len(rows)):
        body = rows[n]
        smooth_path(
            history.frame[body], history.path[body], history.speed[body], weights, frame, pushed, rolling, dt, path
        )
        raw_x, raw_y, raw_yaw = history.raw[body, now]
        if rolling:
            _follow_path(states, dimensions, body, frame, path, raw_yaw, dt)
            _write_motion(motion[n], states.state[body], dimensions, body)
            front_x = states.state[body, X] + dimensions.front_offset[body] * elementary.cos(states.state[body, YAW])
            front_y = states.state[body, Y] + dimensions.front_offset[body] * elementary.sin(states.state[body, YAW])
        else:
            motion[n, :3], motion[n, 3:5], motion[n, 5:7] = path[0], path[1, :2], path[2, :2]
            motion[n, 7] = path[1, 2]
            front_x, front_y = path[0, 0], path[0, 1]
        motion[n, 2] = wrap_angle(motion[n, 2])
        cos, sin = elementary.cos(path[0, 2]), elementary.sin(path[0, 2])
        error_x, error_y = front_x - raw_x, front_y - raw_y
        motion[n, 9], motion[n, 10] = error_x * cos + error_y * sin, error_y * cos - error_x * sin
    return motion


@kernel()
def _follow_path(
    states: BodyStates, dimensions: BodyDimensions, body: int, frame: int, path: Floats, yaw: float, dt: float
) -> None:
    """Advance a body along its path to a frame, or initialise it there if it is new."""
    state, trail = states.state[body], states.trail[body]
    front_offset, limit_offset, yaw_rate_max = (
        dimensions.front_offset[body],
        dimensions.limit_offset[body],
        dimensions.yaw_rate_max[body],
    )
    target = trail[frame % len(trail)]
    for order in range(3):
        target[2 * order], target[2 * order + 1] = path[order, 0], path[order, 1]
    if states.last_frame[body] == frame - 1:
        advance_body(state, trail, states.first_frame[body], frame, front_offset, limit_offset, yaw_rate_max, dt)
        if dimensions.trailer_wheelbase[body] > 0:
            # Heun's method: the mean of the rate at the start and the predicted rate at the end
            yaw_before, rate = state[TRAILER_YAW], state[TRAILER_RATE]
            predicted_rate = _trailer_rate(state, dimensions, body, yaw_before + rate * dt)
            state[TRAILER_YAW] = yaw_before + 0.5 * (rate + predicted_rate) * dt
    else:
        states.first_frame[body] = frame
        initialise_body(state, target, yaw, front_offset, yaw_rate_max)
        state[TRAILER_YAW] = yaw
    if dimensions.trailer_wheelbase[body] > 0:
        state[TRAILER_RATE] = _trailer_rate(state, dimensions, body, state[TRAILER_YAW])
    states.last_frame[body] = frame


@kernel()
def _trailer_rate(state: Floats, dimensions: BodyDimensions, body: int, yaw: float) -> float:
    """Return a trailer's yaw rate [rad/s] at a yaw: the kingpin's speed across the trailer over its wheelbase."""
    articulation = state[YAW] - yaw
    kingpin_speed = dimensions.kingpin_offset[body] * state[YAW_RATE]
    rate: float = (
        state[SPEED] * elementary.sin(articulation) + kingpin_speed * elementary.cos(articulation)
    ) / dimensions.trailer_wheelbase[body]
    return rate


@kernel()
def _write_motion(motion: Floats, state: Floats, dimensions: BodyDimensions, body: int) -> None:
    """Write a body's motion except its deviation; of an articulated vehicle the trailer's box, of a tram the front."""
    ahead = dimensions.motion_offset[body]
    cos, sin = elementary.cos(state[YAW]), elementary.sin(state[YAW])
    swing = ahead * state[YAW_RATE]
    along = state[ACCELERATION] - swing * state[YAW_RATE]
    across = state[SPEED] * state[YAW_RATE] + ahead * state[YAW_ACCELERATION]
    motion[0], motion[1], motion[2] = state[X] + ahead * cos, state[Y] + ahead * sin, state[YAW]
    motion[3], motion[4] = state[SPEED] * cos - swing * sin, state[SPEED] * sin + swing * cos
    motion[5], motion[6] = along * cos - across * sin, along * sin + across * cos
    motion[7] = state[YAW_RATE]
    if dimensions.trailer_wheelbase[body] > 0:
        _trailer_motion(motion, state, dimensions, body)


@kernel()
def _trailer_motion(motion: Floats, state: Floats, dimensions: BodyDimensions, body: int) -> None:
    """Replace the kingpin's motion by that of the box centre behind it, along the trailer."""
    yaw, rate, centre_offset = state[TRAILER_YAW], state[TRAILER_RATE], dimensions.centre_offset[body]
    cos, sin = elementary.cos(yaw), elementary.sin(yaw)
    along = motion[3] * cos + motion[4] * sin
    turning = (motion[6] * cos - motion[5] * sin - rate * along) / dimensions.trailer_wheelbase[body]
    motion[8] = wrap_angle(state[YAW] - yaw)
    motion[0] += centre_offset * cos
    motion[1] += centre_offset * sin
    motion[2], motion[7] = yaw, rate
    motion[3] -= centre_offset * rate * sin
    motion[4] += centre_offset * rate * cos
    motion[5] += centre_offset * (-turning * sin - rate**2 * cos)
    motion[6] += centre_offset * (turning * cos - rate**2 * sin)
