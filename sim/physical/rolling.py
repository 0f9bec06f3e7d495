"""Bodies that roll: their rear axles do not slip, and speed and yaw rate change as fast as vehicles can change them.

That is the kinematic bicycle model (Rajamani, "Vehicle Dynamics and Control", 2nd ed. 2012, section 2.2) with limits.
"""

import math
from dataclasses import dataclass

import numpy as np

from sim.physical.path import Path, along_across, within
from sim.world import Floats

ACCELERATION = 6.0
"""[m/s^2] Highest along the body: a motorcycle that starts."""
GRIP = 9.5
"""[m/s^2] Of the tyres on a dry road, along and across together (Kamm's circle): what a curve takes, a brake lacks."""
JERK = 30.0
"""[m/s^3] of the acceleration along the body."""
LATERAL_ACCELERATION = 5.4
"""[m/s^2] Speed x yaw rate; most drivers stay below 4, and tyres end near 9."""
LATERAL_JERK = 20.0
"""[m/s^3] of the rear axle, and of what the box centre's swing adds."""
SWING = 3.0
"""[m/s^2] Acceleration of the box centre across the body by yaw acceleration alone."""
SWING_ABOVE = 0.4
"""[m/s^2] by which it may, added to speed x yaw rate, exceed that one's limit."""
YAW_RATE, YAW_RATE_ON_FOOT = 1.1, 3.0
"""[rad/s] On wheels and on foot."""
STEERING = math.radians(70.0)
"""[rad] Greatest angle between the way of a body's front and its heading; at the front wheels it is smaller."""
STANDING = 0.02
"""[m/s] Slower than this is standing."""
SETTLING_S = 0.25
"""[s] in which an error of the speed decays."""
STEERING_S = 0.1
"""[s] in which an error of the yaw rate decays."""


@dataclass(frozen=True, slots=True, eq=False)
class Build:
    """What matters of N bodies."""

    lead: Floats
    """(N,) from the rear axle to the point at the front that leads [m]."""
    arm: Floats
    """(N,) from the rear axle to the point whose acceleration is limited [m]."""
    yaw_rate_max: Floats
    """(N,) [rad/s]."""


@dataclass(frozen=True, slots=True, eq=False)
class Rolling:
    """The motion of N bodies at one instant."""

    axle: Floats
    """(N, 2) middle of the rear axle [m]."""
    yaw: Floats
    """(N,) [rad], not wrapped."""
    speed: Floats
    """(N,) of the rear axle [m/s], never negative."""
    acceleration: Floats
    """(N,) of the rear axle along the body [m/s^2]."""
    yaw_rate: Floats
    """(N,) [rad/s]."""
    yaw_acceleration: Floats
    """(N,) [rad/s^2]."""

    def at(self, distance: Floats) -> tuple[Floats, Floats, Floats]:
        """Return place, velocity and acceleration, (N, 2) each, of points `distance` (N,) [m] ahead of the axle."""
        u = np.column_stack([np.cos(self.yaw), np.sin(self.yaw)])
        n = np.column_stack([-u[:, 1], u[:, 0]])
        along = self.acceleration - distance * self.yaw_rate**2
        across = self.speed * self.yaw_rate + distance * self.yaw_acceleration
        return (
            self.axle + distance[:, None] * u,
            self.speed[:, None] * u + (distance * self.yaw_rate)[:, None] * n,
            along[:, None] * u + across[:, None] * n,
        )


def set_rolling(path: Path, yaw: Floats, build: Build) -> Rolling:
    """Put bodies with their fronts on paths, at yaws (N,) [rad], as if they had always followed them."""
    along, across = along_across(path.velocity, yaw)
    speed = np.maximum(along, 0.0)
    steering = np.where(speed > STANDING, across / np.maximum(speed, STANDING), 0.0)
    yaw_rate = within(speed * steering / build.lead, fastest_turn(speed, build))
    acceleration = np.clip(along_across(path.acceleration, yaw)[0], -GRIP, ACCELERATION)
    axle = path.place - build.lead[:, None] * np.column_stack([np.cos(yaw), np.sin(yaw)])
    return Rolling(axle, yaw, speed, np.where(speed > 0, acceleration, 0.0), yaw_rate, np.zeros(len(yaw)))


def roll(
    state: Rolling, speed_wanted: Floats, curvature_wanted: Floats, feedforward: Floats, build: Build, dt: float
) -> Rolling:
    """Move for a step.

    Parameters
    ----------
    state
        Of N bodies.
    speed_wanted
        (N,) [m/s].
    curvature_wanted
        (N,) of the rear axle's way [1/m], positive to the left.
    feedforward
        (N,) acceleration that the wanted speed has itself [m/s^2].
    build
        Their bodies.
    dt
        Length of the step [s].
    """
    speed, acceleration = _accelerated(state, speed_wanted, feedforward, dt)
    yaw_rate, yaw_acceleration = _turned(state, curvature_wanted, speed, build, dt)
    way = 0.5 * (state.speed + speed) * dt
    turn = 0.5 * (state.yaw_rate + yaw_rate) * dt
    middle, chord = state.yaw + 0.5 * turn, way * np.sinc(turn / (2 * np.pi))
    axle = state.axle + chord[:, None] * np.column_stack([np.cos(middle), np.sin(middle)])
    return Rolling(axle, state.yaw + turn, speed, acceleration, yaw_rate, yaw_acceleration)


def fastest_turn(speed: Floats, build: Build) -> Floats:
    """Return the greatest yaw rate (N,) [rad/s] at speeds (N,) [m/s]."""
    locked = speed * math.tan(STEERING) / build.lead
    return np.minimum(np.minimum(locked, LATERAL_ACCELERATION / np.maximum(speed, 0.1)), build.yaw_rate_max)


def _accelerated(state: Rolling, wanted: Floats, feedforward: Floats, dt: float) -> tuple[Floats, Floats]:
    """Return speed [m/s] and acceleration [m/s^2] after a step towards a wanted speed."""
    expected = state.speed + 0.5 * (state.acceleration + feedforward) * dt
    acceleration = feedforward + (wanted - expected) / SETTLING_S
    across = np.minimum(state.speed * np.abs(state.yaw_rate), GRIP)
    # brake as hard as the tyres allow, and so that the brake can be let go before standstill
    hardest = -np.minimum(np.sqrt(GRIP**2 - across**2), np.sqrt(JERK * state.speed))
    acceleration = np.minimum(np.maximum(acceleration, hardest), ACCELERATION)
    acceleration = state.acceleration + within(acceleration - state.acceleration, JERK * dt)
    speed = state.speed + 0.5 * (state.acceleration + acceleration) * dt
    stands = (speed <= 0) | ((wanted == 0) & (speed < STANDING))
    return np.where(stands, 0.0, speed), np.where(stands, 0.0, acceleration)


def _turned(state: Rolling, curvature: Floats, speed: Floats, build: Build, dt: float) -> tuple[Floats, Floats]:
    """Return yaw rate [rad/s] and yaw acceleration [rad/s^2] after a step towards a wanted curvature."""
    limit = fastest_turn(speed, build)
    error = within(curvature * speed, limit) - state.yaw_rate
    reach = np.maximum(np.abs(build.arm), 0.5)
    jerk = LATERAL_JERK / reach
    room = LATERAL_ACCELERATION + SWING_ABOVE - speed * np.abs(state.yaw_rate)
    swing = np.where(error * state.yaw_rate > 0, np.clip(room, 0.1, SWING), SWING)
    most = np.minimum(LATERAL_JERK / np.maximum(speed, 1.0), swing / reach)
    # turn in so that the turning-in can be let go when the yaw rate is there
    wanted = within(error / STEERING_S, np.minimum(most, np.sqrt(2 * jerk * np.abs(error))))
    acceleration = state.yaw_acceleration + within(wanted - state.yaw_acceleration, jerk * dt)
    free = state.yaw_rate + 0.5 * (state.yaw_acceleration + acceleration) * dt
    yaw_rate = within(free, limit)
    return yaw_rate, np.where(yaw_rate == free, acceleration, (yaw_rate - state.yaw_rate) / dt)
