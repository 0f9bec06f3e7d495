"""One step of a body that rolls: its rear axle does not slip; speed and yaw rate change as vehicles can change them.

That is the kinematic bicycle model (Rajamani, "Vehicle Dynamics and Control", 2nd ed. 2012, section 2.2) with limits.
"""

import math

from numba import njit

from sim.arrays import Floats
from sim.physical.kernels.records import (
    ACCELERATION,
    SPEED,
    YAW,
    YAW_ACCELERATION,
    YAW_RATE,
    X,
    Y,
)
from sim.physical.limits import (
    GRIP,
    HIGHEST_ACCELERATION,
    JERK,
    LATERAL_ACCELERATION,
    LATERAL_JERK,
    SETTLING_S,
    STANDING,
    STEERING,
    STEERING_S,
    SWING,
    SWING_ABOVE,
)


@njit(cache=True)
def within(value: float, limit: float) -> float:
    """Cut a value to a limit on both sides of zero."""
    return min(max(value, -limit), limit)


@njit(cache=True)
def fastest_turn(speed: float, lead: float, yaw_rate_max: float) -> float:
    """Return the greatest yaw rate [rad/s] at a speed [m/s]."""
    return min(speed * math.tan(STEERING) / lead, LATERAL_ACCELERATION / max(speed, 0.1), yaw_rate_max)


@njit(cache=True)
def roll(
    state: Floats, speed_wanted: float, curvature: float, own: float, lead: float, arm: float, most: float, dt: float
) -> None:
    """Move a body for a step.

    Parameters
    ----------
    state
        (10,) of the body; written.
    speed_wanted
        [m/s]
    curvature
        Wanted, of the rear axle's way [1/m], positive to the left.
    own
        The acceleration that the wanted speed has itself [m/s^2].
    lead, arm, most
        Of its build, `most` the greatest yaw rate [rad/s].
    dt
        Length of the step [s].
    """
    speed, acceleration = _accelerated(state, speed_wanted, own, dt)
    yaw_rate, yaw_acceleration = _turned(state, curvature, speed, fastest_turn(speed, lead, most), arm, dt)
    way = 0.5 * (state[SPEED] + speed) * dt
    turn = 0.5 * (state[YAW_RATE] + yaw_rate) * dt
    middle = state[YAW] + 0.5 * turn
    if abs(turn) > 1e-9:
        way *= math.sin(0.5 * turn) / (0.5 * turn)  # the chord of the arc
    state[X] += way * math.cos(middle)
    state[Y] += way * math.sin(middle)
    state[YAW] += turn
    state[SPEED], state[ACCELERATION] = speed, acceleration
    state[YAW_RATE], state[YAW_ACCELERATION] = yaw_rate, yaw_acceleration


@njit(cache=True)
def _accelerated(state: Floats, wanted: float, own: float, dt: float) -> tuple[float, float]:
    """Return speed [m/s] and acceleration [m/s^2] after a step towards a wanted speed."""
    before = state[ACCELERATION]
    expected = state[SPEED] + 0.5 * (before + own) * dt
    across = min(state[SPEED] * abs(state[YAW_RATE]), GRIP)
    # brake as hard as the tyres allow, and so that the brake can be let go before standstill
    hardest = -min(math.sqrt(GRIP**2 - across**2), math.sqrt(JERK * state[SPEED]))
    acceleration = min(max(own + (wanted - expected) / SETTLING_S, hardest), HIGHEST_ACCELERATION)
    acceleration = before + within(acceleration - before, JERK * dt)
    speed = state[SPEED] + 0.5 * (before + acceleration) * dt
    if speed <= 0 or (wanted == 0 and speed < STANDING):
        return 0.0, 0.0
    return speed, acceleration


@njit(cache=True)
def _turned(state: Floats, curvature: float, speed: float, limit: float, arm: float, dt: float) -> tuple[float, float]:
    """Return yaw rate [rad/s] and yaw acceleration [rad/s^2] after a step towards a wanted curvature."""
    error = within(curvature * speed, limit) - state[YAW_RATE]
    reach = max(abs(arm), 0.5)
    jerk = LATERAL_JERK / reach
    swing = SWING
    if error * state[YAW_RATE] > 0:
        room = LATERAL_ACCELERATION + SWING_ABOVE - speed * abs(state[YAW_RATE])
        swing = min(max(room, 0.1), SWING)
    most = min(LATERAL_JERK / max(speed, 1.0), swing / reach)
    # turn in so that the turning-in can be let go when the yaw rate is there
    wanted = within(error / STEERING_S, min(most, math.sqrt(2 * jerk * abs(error))))
    acceleration = state[YAW_ACCELERATION] + within(wanted - state[YAW_ACCELERATION], jerk * dt)
    free = state[YAW_RATE] + 0.5 * (state[YAW_ACCELERATION] + acceleration) * dt
    yaw_rate = within(free, limit)
    if yaw_rate != free:
        acceleration = (yaw_rate - state[YAW_RATE]) / dt
    return yaw_rate, acceleration
