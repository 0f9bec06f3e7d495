"""Drivers: they lead the front of each body along its path, and the rear axle follows.

The path's derivatives say what to do, and a little feedback mends what is left: along the way by speed, across it by
steering, as in Hoffmann et al., "Autonomous Automobile Trajectory Tracking for Off-Road Driving" (American Control
Conference 2007), equation 5, with a distance ahead in place of its gain over speed.
"""

import math

import numpy as np

from sim.physical.path import Path, Trail, along_across, within
from sim.physical.rolling import (
    LATERAL_ACCELERATION,
    STANDING,
    STEERING,
    STEERING_S,
    Build,
    Rolling,
    roll,
)
from sim.world import Floats, Ints

STEP_S = 0.04
"""[s] Longest step of the integration."""
AHEAD_S, BEHIND_S = 0.3, 3.0
"""[s] Who is ahead of or behind the path's time steers for where it will be or was then, up to these."""
LAG_STEP_S = 0.1
"""[s] by which that time may change in a step; paths that turn back have several that are as near."""
SLOW = 1.0
"""[m/s] Slower paths tell little by their direction."""
CATCH_UP = 1.2
"""[1/s] Speed per metre behind the path."""
CATCH_UP_SHARE, CATCH_UP_LEAST = 0.25, 2.0
"""[1], [m/s] Who is behind goes faster by at most this share of the path's speed, or this."""
AIM_M, AIM_S, AIM_RAD = 3.0, 0.5, 0.5
"""[m], [s], [rad] Who is beside the path steers for a point on it so far ahead, but by no more than this angle."""
CREEP = 0.3
"""[m/s] Who would close a gap to a standing path slower than this stays where it is."""


def drive(state: Rolling, lag: Floats, id: Ints, trail: Trail, build: Build, dt: float) -> tuple[Rolling, Floats]:
    """Follow paths up to their latest frame, from the one before.

    Parameters
    ----------
    state
        Of N bodies.
    lag
        (N,) by how much time they are behind their paths [s].
    id
        (N,) their numbers.
    trail
        Paths of their fronts.
    build
        Their bodies.
    dt
        Time between frames [s].

    Returns
    -------
    state, lag
        A frame later.
    """
    steps = math.ceil(dt / STEP_S)
    for step in range(steps):
        left = dt * (steps - step - 1) / steps
        state, lag = _step(state, lag, id, trail, left, build, dt / steps)
    return state, lag


def _step(
    state: Rolling, lag: Floats, id: Ints, trail: Trail, left: float, build: Build, dt: float
) -> tuple[Rolling, Floats]:
    """Follow the paths for a step that ends `left` [s] before their latest frame."""
    front, _, _ = state.at(build.lead)
    lag = _lag(lag, front, trail.at(id, left + dt + lag))
    goal = trail.at(id, left + lag)
    speed = np.hypot(*goal.velocity.T)
    short, beside = along_across(goal.shifted(np.full(len(lag), -dt)).place - front, state.yaw)

    # what the steering is told now, the body does a little later
    yaw = state.yaw + state.yaw_rate * (dt + STEERING_S)
    ahead, across = along_across(goal.shifted(np.full(len(lag), STEERING_S)).velocity, yaw)
    nudge = within(np.arctan(beside / (AIM_M + AIM_S * speed)), AIM_RAD)
    angle = np.arctan2(across, ahead) + nudge
    reachable, angle = np.abs(angle) <= STEERING, within(angle, STEERING)
    moving = speed > STANDING
    curvature = np.where(moving, np.tan(angle) / build.lead, 0.0)

    behind = np.where(moving, lag * np.maximum(speed, SLOW), short)
    hurry = within(CATCH_UP * behind, np.maximum(CATCH_UP_SHARE * speed, CATCH_UP_LEAST))
    hurry = np.where(reachable, hurry, 0.0)
    wanted = np.where(moving, np.maximum(speed * np.cos(angle) + hurry, 0.0), np.where(hurry > CREEP, hurry, 0.0))
    fastest = _fastest(goal, speed)
    own = along_across(goal.acceleration, yaw)[0] + across * state.yaw_rate
    feedforward = np.where(moving & reachable & (wanted < fastest), own, 0.0)
    return roll(state, np.minimum(wanted, fastest), curvature, feedforward, build, dt), lag


def _lag(lag: Floats, front: Floats, path: Path) -> Floats:
    """Return by how much time (N,) [s] fronts (N, 2) are behind, given where they ought to be if it were `lag`."""
    speed_squared = np.maximum(np.einsum("nc,nc->n", path.velocity, path.velocity), SLOW**2)
    more = np.einsum("nc,nc->n", path.place - front, path.velocity) / speed_squared
    later = np.clip(lag + within(more, LAG_STEP_S), -AHEAD_S, BEHIND_S)
    return np.where(speed_squared > SLOW**2, later, np.where(lag > 0, later, 0.0))


def _fastest(path: Path, speed: Floats) -> Floats:
    """Return the greatest speed (N,) [m/s] in the bends of paths that go at `speed` (N,); on straights, twice that."""
    across = np.maximum(path.acceleration_across(), LATERAL_ACCELERATION / 4)
    return np.maximum(speed, CATCH_UP_LEAST) * np.sqrt(LATERAL_ACCELERATION / across)
