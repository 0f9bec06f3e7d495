"""Kernel that advances a rolling body by one step, with limited rates of speed and yaw rate.

The rear axle does not slip: this is the kinematic bicycle model (Rajamani, "Vehicle Dynamics and Control", 2nd ed.
2012, section 2.2) with limits.
"""

import math

from luxloop import elementary
from luxloop.arrays import Floats
from luxloop.compiled import kernel
from luxloop.sim.physical.kernels.records import (
    ACCELERATION,
    SPEED,
    YAW,
    YAW_ACCELERATION,
    YAW_RATE,
    X,
    Y,
)
from luxloop.sim.physical.limits import (
    ACCELERATION_MAX,
    GRIP,
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


@kernel()
def clamp(value: float, limit: float) -> float:
    """Limit the magnitude of a value."""
    return min(max(value, -limit), limit)


@kernel()
def yaw_rate_limit(speed: float, front_offset: float, yaw_rate_max: float) -> float:
    """Return the maximum yaw rate [rad/s] at a speed [m/s]."""
    return min(speed * elementary.tan(STEERING) / front_offset, LATERAL_ACCELERATION / max(speed, 0.1), yaw_rate_max)


@kernel()
def step_body(
    state: Floats,
    speed_target: float,
    curvature: float,
    feedforward: float,
    front_offset: float,
    limit_offset: float,
    yaw_rate_max: float,
    dt: float,
) -> None:
    """Advance a body by one step.

    Parameters
    ----------
    state
        (10,) state of the body; written.
    speed_target
        Target speed [m/s].
    curvature
        Target curvature of the rear axle's path [1/m], positive to the left.
    feedforward
        Derivative of the target speed [m/s^2].
    front_offset, limit_offset, yaw_rate_max
        See `BodyDimensions`.
    dt
        Length of the step [s].
    """
    speed, acceleration = _next_speed(state, speed_target, feedforward, dt)
    yaw_rate, yaw_acceleration = _next_yaw_rate(
        state, curvature, speed, yaw_rate_limit(speed, front_offset, yaw_rate_max), limit_offset, dt
    )
    distance = 0.5 * (state[SPEED] + speed) * dt
    turn = 0.5 * (state[YAW_RATE] + yaw_rate) * dt
    middle = state[YAW] + 0.5 * turn
    if abs(turn) > 1e-9:
        distance *= elementary.sin(0.5 * turn) / (0.5 * turn)  # the chord of the arc
    state[X] += distance * elementary.cos(middle)
    state[Y] += distance * elementary.sin(middle)
    state[YAW] += turn
    state[SPEED], state[ACCELERATION] = speed, acceleration
    state[YAW_RATE], state[YAW_ACCELERATION] = yaw_rate, yaw_acceleration


@kernel()
def _next_speed(state: Floats, target: float, feedforward: float, dt: float) -> tuple[float, float]:
    """Return speed [m/s] and acceleration [m/s^2] after a step towards a target speed."""
    before = state[ACCELERATION]
    expected = state[SPEED] + 0.5 * (before + feedforward) * dt
    across = min(state[SPEED] * abs(state[YAW_RATE]), GRIP)
    # limited by tyre grip, and such that the brake can be released before standstill within the jerk limit
    acceleration_min = -min(math.sqrt(GRIP**2 - across**2), math.sqrt(JERK * state[SPEED]))
    acceleration = min(max(feedforward + (target - expected) / SETTLING_S, acceleration_min), ACCELERATION_MAX)
    acceleration = before + clamp(acceleration - before, JERK * dt)
    speed = state[SPEED] + 0.5 * (before + acceleration) * dt
    if speed <= 0 or (target == 0 and speed < STANDING):
        return 0.0, 0.0
    return speed, acceleration


@kernel()
def _next_yaw_rate(
    state: Floats, curvature: float, speed: float, limit: float, limit_offset: float, dt: float
) -> tuple[float, float]:
    """Return yaw rate [rad/s] and yaw acceleration [rad/s^2] after a step towards a target curvature."""
    error = clamp(curvature * speed, limit) - state[YAW_RATE]
    reach = max(abs(limit_offset), 0.5)
    jerk = LATERAL_JERK / reach
    swing = SWING
    if error * state[YAW_RATE] > 0:
        room = LATERAL_ACCELERATION + SWING_ABOVE - speed * abs(state[YAW_RATE])
        swing = min(max(room, 0.1), SWING)
    acceleration_max = min(LATERAL_JERK / max(speed, 1.0), swing / reach)
    # limited such that the yaw acceleration can return to 0 within the jerk limit when the target yaw rate is reached
    target = clamp(error / STEERING_S, min(acceleration_max, math.sqrt(2 * jerk * abs(error))))
    acceleration = state[YAW_ACCELERATION] + clamp(target - state[YAW_ACCELERATION], jerk * dt)
    free = state[YAW_RATE] + 0.5 * (state[YAW_ACCELERATION] + acceleration) * dt
    yaw_rate = clamp(free, limit)
    if yaw_rate != free:
        acceleration = (yaw_rate - state[YAW_RATE]) / dt
    return yaw_rate, acceleration
