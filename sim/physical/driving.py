"""Drivers: they lead the front of each body along its path, and the rear axle follows.

The path's derivatives say what to do, and a little feedback mends what is left: along the way by speed, across it by
steering, as in Hoffmann et al., "Autonomous Automobile Trajectory Tracking for Off-Road Driving" (American Control
Conference 2007), equation 5, with a distance ahead in place of its gain over speed.
"""

import math

import numpy as np

from sim.physical.path import Path, along_across, within
from sim.physical.rolling import (
    LATERAL_ACCELERATION,
    STANDING,
    STEERING,
    STEERING_S,
    Build,
    Rolling,
    roll,
)
from sim.world import Floats

STEP_S = 0.04
"""[s] Longest step of the integration."""
LAG_S = 0.3
"""[s] Who is behind or ahead of the path steers for where it was or will be then, up to this time."""
CATCH_UP = 1.2
"""[1/s] Speed per metre behind the path."""
CATCH_UP_SHARE, CATCH_UP_LEAST = 0.25, 2.0
"""[1], [m/s] Who is behind goes faster by at most this share of the path's speed, or this."""
AIM_M, AIM_S, AIM_RAD = 3.0, 0.5, 0.5
"""[m], [s], [rad] Who is beside the path steers for a point on it so far ahead, but by no more than this angle."""
CREEP = 0.3
"""[m/s] Who would close a gap to a standing path slower than this stays where it is."""


def drive(state: Rolling, start: Path, end: Path, build: Build, dt: float) -> Rolling:
    """Follow the paths of N fronts for a frame: they lead from `start` to `end`, `dt` [s] later."""
    steps = math.ceil(dt / STEP_S)
    for step in range(steps):
        now, then = (start.toward(end, (step + later) / steps, dt) for later in (0, 1))
        state = _step(state, now, then, build, dt / steps)
    return state


def _step(state: Rolling, now: Path, then: Path, build: Build, dt: float) -> Rolling:
    front, _, _ = state.at(build.lead)
    lag = now.lag_of(front, LAG_S)
    goal = then.shifted(-lag)
    speed = np.hypot(*goal.velocity.T)
    behind, beside = along_across(now.shifted(-lag).place - front, state.yaw)

    # what the steering is told now, the body does a little later
    yaw = state.yaw + state.yaw_rate * (dt + STEERING_S)
    ahead, across = along_across(goal.shifted(np.full(len(lag), STEERING_S)).velocity, yaw)
    nudge = within(np.arctan(beside / (AIM_M + AIM_S * speed)), AIM_RAD)
    angle = np.arctan2(across, ahead) + nudge
    reachable, angle = np.abs(angle) <= STEERING, within(angle, STEERING)
    moving = speed > STANDING
    curvature = np.where(moving, np.tan(angle) / build.lead, 0.0)

    hurry = within(CATCH_UP * (behind + lag * speed), np.maximum(CATCH_UP_SHARE * speed, CATCH_UP_LEAST))
    hurry = np.where(reachable, hurry, 0.0)
    wanted = np.where(moving, np.maximum(speed * np.cos(angle) + hurry, 0.0), np.where(hurry > CREEP, hurry, 0.0))
    fastest = _fastest(goal, speed)
    own = along_across(goal.acceleration, yaw)[0] + across * state.yaw_rate
    feedforward = np.where(moving & reachable & (wanted < fastest), own, 0.0)
    return roll(state, np.minimum(wanted, fastest), curvature, feedforward, build, dt)


def _fastest(path: Path, speed: Floats) -> Floats:
    """Return the greatest speed (N,) [m/s] in the bends of paths that go at `speed` (N,); on straights, twice that."""
    across = np.maximum(path.acceleration_across(), LATERAL_ACCELERATION / 4)
    return np.maximum(speed, CATCH_UP_LEAST) * np.sqrt(LATERAL_ACCELERATION / across)
