"""A frame's motions, body by body."""

import math

import numpy as np
from numba import njit

from sim.arrays import Floats, Ints
from sim.physical.kernels.path_following import drive, put
from sim.physical.kernels.records import (
    ACCELERATION,
    SPEED,
    TRAILER_RATE,
    TRAILER_YAW,
    YAW,
    YAW_ACCELERATION,
    YAW_RATE,
    Builds,
    Led,
    Said,
    X,
    Y,
)
from sim.physical.kernels.smoothing import smoothed, wrapped

WIDTH = 11
"""Columns of a motion: pose (3), velocity (2), acceleration (2), yaw rate, articulation, deviation (2)."""


@njit(cache=True)
def settle(
    frame: int, known: int, rows: Ints, said: Said, weights: Floats, led: Led, builds: Builds, leads: bool, dt: float
) -> Floats:
    """Return the motions (N, WIDTH) of the bodies `rows` (N,) in a frame, the one after the last that was settled.

    Parameters
    ----------
    frame, known
        The frame, and the number of frames that were pushed.
    said, weights
        See `smoothed`.
    led
        Bodies as of the frame before; written.
    builds
        Their builds.
    leads
        Whether bodies are led by their fronts, or only smoothed.
    dt
        Time between frames [s].
    """
    motion = np.zeros((len(rows), WIDTH))
    path = np.empty((3, 3))
    now = frame % said.frame.shape[1]
    for n in range(len(rows)):
        body = rows[n]
        smoothed(said.frame[body], said.path[body], said.speed[body], weights, frame, known, leads, dt, path)
        raw_x, raw_y, raw_yaw = said.raw[body, now]
        if leads:
            _follow(led, builds, body, frame, path, raw_yaw, dt)
            _write(motion[n], led.state[body], builds, body)
            front_x = led.state[body, X] + builds.lead[body] * math.cos(led.state[body, YAW])
            front_y = led.state[body, Y] + builds.lead[body] * math.sin(led.state[body, YAW])
        else:
            motion[n, :3], motion[n, 3:5], motion[n, 5:7] = path[0], path[1, :2], path[2, :2]
            motion[n, 7] = path[1, 2]
            front_x, front_y = path[0, 0], path[0, 1]
        motion[n, 2] = wrapped(motion[n, 2])
        cos, sin = math.cos(path[0, 2]), math.sin(path[0, 2])
        off_x, off_y = front_x - raw_x, front_y - raw_y
        motion[n, 9], motion[n, 10] = off_x * cos + off_y * sin, off_y * cos - off_x * sin
    return motion


@njit(cache=True)
def _follow(led: Led, builds: Builds, body: int, frame: int, path: Floats, yaw: float, dt: float) -> None:
    """Take a body to a frame along its path, or put it there if it is new."""
    state, trail = led.state[body], led.trail[body]
    lead, arm, yaw_rate_max = builds.lead[body], builds.arm[body], builds.yaw_rate_max[body]
    goal = trail[frame % len(trail)]
    for order in range(3):
        goal[2 * order], goal[2 * order + 1] = path[order, 0], path[order, 1]
    if led.settled[body] == frame - 1:
        drive(state, trail, led.since[body], frame, lead, arm, yaw_rate_max, dt)
        if builds.base[body] > 0:
            # Heun's method: the mean of the rates at the start and, by a first guess, at the end
            yaw_before, rate = state[TRAILER_YAW], state[TRAILER_RATE]
            guess = _trailer_rate(state, builds, body, yaw_before + rate * dt)
            state[TRAILER_YAW] = yaw_before + 0.5 * (rate + guess) * dt
    else:
        led.since[body] = frame
        put(state, goal, yaw, lead, yaw_rate_max)
        state[TRAILER_YAW] = yaw
    if builds.base[body] > 0:
        state[TRAILER_RATE] = _trailer_rate(state, builds, body, state[TRAILER_YAW])
    led.settled[body] = frame


@njit(cache=True)
def _trailer_rate(state: Floats, builds: Builds, body: int, yaw: float) -> float:
    """Return the yaw rate [rad/s] of a trailer that stands at a yaw: the kingpin's speed across it over its base."""
    bend = state[YAW] - yaw
    pin = builds.kingpin[body] * state[YAW_RATE]
    rate: float = (state[SPEED] * math.sin(bend) + pin * math.cos(bend)) / builds.base[body]
    return rate


@njit(cache=True)
def _write(motion: Floats, state: Floats, builds: Builds, body: int) -> None:
    """Write a led body's motion, deviation excepted; of one that bends, that of the trailer's box."""
    bends = builds.base[body] > 0
    ahead = builds.kingpin[body] if bends else builds.lead[body] - 0.5 * builds.length[body]
    cos, sin = math.cos(state[YAW]), math.sin(state[YAW])
    swing = ahead * state[YAW_RATE]
    along = state[ACCELERATION] - swing * state[YAW_RATE]
    across = state[SPEED] * state[YAW_RATE] + ahead * state[YAW_ACCELERATION]
    motion[0], motion[1], motion[2] = state[X] + ahead * cos, state[Y] + ahead * sin, state[YAW]
    motion[3], motion[4] = state[SPEED] * cos - swing * sin, state[SPEED] * sin + swing * cos
    motion[5], motion[6] = along * cos - across * sin, along * sin + across * cos
    motion[7] = state[YAW_RATE]
    if bends:
        _tow(motion, state, builds, body)


@njit(cache=True)
def _tow(motion: Floats, state: Floats, builds: Builds, body: int) -> None:
    """Replace the motion of the kingpin by that of the box centre behind it, laid along the trailer."""
    yaw, rate, box = state[TRAILER_YAW], state[TRAILER_RATE], builds.box[body]
    cos, sin = math.cos(yaw), math.sin(yaw)
    along = motion[3] * cos + motion[4] * sin
    turning = (motion[6] * cos - motion[5] * sin - rate * along) / builds.base[body]
    motion[8] = wrapped(state[YAW] - yaw)
    motion[0] += box * cos
    motion[1] += box * sin
    motion[2], motion[7] = yaw, rate
    motion[3] -= box * rate * sin
    motion[4] += box * rate * cos
    motion[5] += box * (-turning * sin - rate**2 * cos)
    motion[6] += box * (turning * cos - rate**2 * sin)
