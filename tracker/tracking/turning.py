"""Integrals over a turn. Vectors are complex numbers x + iy."""

from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from luxloop import elementary, elementwise
from luxloop.arrays import Floats, Ints
from luxloop.compiled import kernel
from luxloop.tracker.records import TURNING_MODELS
from luxloop.tracker.tracking.filters import Motion, Step

Complexes = npt.NDArray[np.complex128]

LEAST_SPEED_MPS = 0.3
"""Speed below which the direction and the curvature of a motion are not known [m/s]."""

SMALL_ANGLE = 1e-3
"""Angle below which integrals over a turn use their series [rad]; the next term is below 1e-9 of the result."""


@kernel()
def turned_integrals(rate: float, end: float) -> tuple[complex, complex]:
    """Integrals of exp(i rate t) and of t exp(i rate t) from 0 to `end`."""
    angle = rate * end
    if abs(angle) < SMALL_ANGLE:
        first = end * (1.0 + 0.5j * angle - angle**2 / 6)
        return first, end**2 * (0.5 + 1j * angle / 3 - angle**2 / 8)
    last = elementary.rotation(angle)
    first = (last - 1.0) / (1j * rate)
    return first, (end * last - first) / (1j * rate)


TURNING = frozenset(TURNING_MODELS)

REAR_OVERHANG_FRACTION = 0.2
"""Distance of the rear axle from the rear end as a fraction of the length: about 0.9 m of a car's 4.5 m."""

NEGLIGIBLE_FRACTION = 0.1
"""Share of the jerk of constant acceleration below which that of a turn is omitted."""


@dataclass(frozen=True, slots=True)
class Turn:
    """Known inputs of the turning models of one track."""

    yaw_rate: float
    """[rad/s]."""
    yaw_rate_variance: float
    """[rad^2/s^2]."""
    heading_variance: float
    """[rad^2]."""
    velocity: complex
    """Velocity of the tracked corner [m/s]."""
    direction: complex
    """Unit vector along the motion of the tracked corner of a vehicle that moves along its heading."""


def turning_among(models: tuple[str, ...]) -> bool:
    """Return True if one of the models is a turning model."""
    return not TURNING.isdisjoint(models)


def axle_to_corner(corner_sign: Ints, size: Floats) -> complex:
    """Return the vector from the middle of the rear axle to a corner of a vehicle of size (2,), its own frame [m]."""
    (front, left), (length, width) = corner_sign.tolist(), size.tolist()
    return complex((0.5 * front + (0.5 - REAR_OVERHANG_FRACTION)) * length, 0.5 * left * width)


def motion_direction(velocity: complex, heading: float, yaw_rate: float, from_axle: complex) -> complex:
    """Return the direction of motion of a corner, a unit vector.

    The rear axle moves along the heading, and the corner at `from_axle` [m] from it has the `velocity` [m/s] of the
    axle plus that of the rotation. Below `LEAST_SPEED_MPS` the direction is the heading.
    """
    forward = elementary.rotation(heading)
    lever = 1j * yaw_rate * from_axle
    speed = ((velocity - lever) * forward.conjugate()).real
    moves = speed * forward + lever
    slow = abs(speed) < LEAST_SPEED_MPS or abs(moves) < LEAST_SPEED_MPS
    return forward if slow else moves / abs(moves) * (1.0 if speed > 0.0 else -1.0)


def with_turn(motion: Motion, turn: Turn) -> Motion:
    """Return the motion with the transitions and the noise of a turn in its turning models."""
    transition, noise = motion.models.transition.copy(), motion.models.noise.copy()
    for m, name in enumerate(motion.names):
        if name in TURNING_MODELS:
            transition[m] = transition_of(name, turn, motion.dt)
            noise[m] += input_noise(name, turn, motion.dt)
    return replace(motion, models=Step(transition, noise))


def straight(yaw_rate: float, velocity: complex, jerk_std_mps3: float) -> bool:
    """Return True if the jerk of a turn is negligible beside that of constant acceleration."""
    return yaw_rate**2 * abs(velocity) < NEGLIGIBLE_FRACTION * jerk_std_mps3


def with_turning_acceleration(
    motion: Motion, yaw_rate: float, variance: float, velocity: complex, jerk_std_mps3: float
) -> Motion:
    """Return the motion with the acceleration of the model `ca` turning at a known yaw rate.

    In a turn the acceleration towards the centre changes by a jerk w^2 v. The transition is that of `ctra`, and the
    noise that of the jerk by the error of the yaw rate. Far below the jerk of the model the turn has no effect.

    Parameters
    ----------
    yaw_rate, variance
        [rad/s], [rad^2/s^2].
    velocity
        Velocity of the tracked corner [m/s].
    jerk_std_mps3
        Jerk of the model [m/s^3].
    """
    if "ca" not in motion.names or straight(yaw_rate, velocity, jerk_std_mps3):
        return motion
    m, dt = motion.names.index("ca"), motion.dt
    transition, noise = motion.models.transition.copy(), motion.models.noise.copy()
    transition[m] = accelerated_turn(yaw_rate, dt)
    by_rate = 2.0 * yaw_rate * velocity * np.array([dt * dt * dt / 6, dt * dt / 2, dt], dtype=np.complex128)
    noise[m] += variance * outer(by_rate)
    return Motion(dt, motion.names, Step(transition, noise), motion.heading)


def transition_of(name: str, turn: Turn, dt: float) -> Floats:
    """(6, 6) transition matrix of a turning model."""
    if name == "ctrv":
        rate, (first, _) = 1j * turn.yaw_rate, turned_integrals(turn.yaw_rate, dt)
        end = elementary.rotation(turn.yaw_rate * dt)
        return real(np.array([[1.0, first, 0.0], [0.0, end, 0.0], [0.0, rate * end, 0.0]]))
    moved = accelerated_turn(turn.yaw_rate, dt)
    return elementwise.product(moved, along(turn.direction, turn.yaw_rate)) if name == "two-axle" else moved


def accelerated_turn(yaw_rate: float, dt: float) -> Floats:
    """(6, 6) transition matrix of a turn [rad/s] with a constant change of speed, the model `ctra`."""
    rate, (first, second) = 1j * yaw_rate, turned_integrals(yaw_rate, dt)
    end = elementary.rotation(yaw_rate * dt)
    by_speed = np.array(
        [
            [1.0, first - rate * second, second],
            [0.0, end * (1.0 - rate * dt), end * dt],
            [0.0, -(rate * rate) * dt * end, end * (1.0 + rate * dt)],
        ]
    )
    return real(by_speed)


def along(direction: complex, yaw_rate: float) -> Floats:
    """(6, 6) projection of velocity and change of speed on a direction of motion; the turn remains."""
    axis = np.array([direction.real, direction.imag])
    projection = np.kron(np.diag([0.0, 1.0, 1.0]), np.outer(axis, axis)) + np.kron(np.diag([1.0, 0.0, 0.0]), np.eye(2))
    centripetal = np.zeros((3, 3), dtype=np.complex128)
    centripetal[2, 1] = 1j * yaw_rate
    to_total = np.eye(6) + real(centripetal)
    return elementwise.product(elementwise.product(to_total, projection), 2.0 * np.eye(6) - to_total)


def input_noise(name: str, turn: Turn, dt: float) -> Floats:
    """(6, 6) noise by the errors of the known inputs: of the yaw rate, and for `two-axle` of the heading, too."""
    turned = 1j * turn.velocity
    by_rate = np.array([0.5 * dt**2 * turned, dt * turned, turned if name == "ctrv" else 0.0])
    noise = turn.yaw_rate_variance * outer(by_rate)
    if name == "two-axle":
        noise += turn.heading_variance * outer(np.array([dt * turned, turned, 0.0]))
    return noise


def real(matrix: Complexes) -> Floats:
    """(2n, 2n) real matrix of a complex one (n, n), for vectors x, y, ..."""
    rows, columns = matrix.shape
    pairs = np.empty((rows, 2, columns, 2))
    pairs[:, 0, :, 0] = pairs[:, 1, :, 1] = matrix.real
    pairs[:, 1, :, 0] = matrix.imag
    pairs[:, 0, :, 1] = -matrix.imag
    return pairs.reshape(2 * rows, 2 * columns)


def outer(vector: Complexes) -> Floats:
    """(2n, 2n) outer product of a complex vector (n,) with itself, as a real vector x, y, ..."""
    flat = vector.view(np.float64)
    return np.asarray(flat[:, None] * flat)
