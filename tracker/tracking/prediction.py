"""Prediction of the tracked corner by each motion model.

Every model is extrapolated by its own physics: a stationary vehicle stays, and a braking one stops and does not move
backwards. Vectors are complex numbers x + iy.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from tracker.arrays import Floats
from tracker.records import PREDICTION_S
from tracker.tracking.turning import LEAST_SPEED_MPS, Complexes, turned_integrals

CURVATURE_MAX_PER_M = 0.25
"""Curvature of the tightest path of a corner [1/m]: a radius of 4 m, inside the turning circle of a small car."""


@dataclass(frozen=True, slots=True, eq=False)
class Start:
    """States of K vehicles at the time of the scan; arrays (K, 1)."""

    position: Complexes
    """[m]."""
    velocity: Complexes
    """[m/s]."""
    acceleration: Complexes
    """[m/s^2]."""
    yaw_rate: Floats
    """[rad/s]."""
    direction: Complexes
    """Unit vectors, see `tracker.tracking.turning.Turn`."""

    @classmethod
    def of(cls, mean: Floats, yaw_rate: Floats, direction: Complexes) -> "Start":
        """Return the states of filters with means (K, 6), and known inputs (K,)."""
        position, velocity, acceleration = (mean[:, k, None] + 1j * mean[:, k + 1, None] for k in (0, 2, 4))
        return cls(position, velocity, acceleration, yaw_rate[:, None], direction[:, None])


def predict(name: str, start: Start) -> Floats:
    """(K, len(PREDICTION_S), 2) positions of K vehicles by one model [m]."""
    moved = start.position + PREDICTORS[name](start, np.broadcast_to(PREDICTION_S, (len(start.position), 3)))
    return np.stack([moved.real, moved.imag], axis=-1)


def _stationary(start: Start, ahead: Floats) -> Complexes:
    return np.zeros(ahead.shape, dtype=np.complex128) + 0.0 * start.position


def _constant_velocity(start: Start, ahead: Floats) -> Complexes:
    return np.asarray(start.velocity * ahead)


def _constant_acceleration(start: Start, ahead: Floats) -> Complexes:
    speed, direction = _polar(start.velocity)
    until = _until_stop(speed, (start.acceleration * direction.conj()).real, ahead)
    return np.asarray(start.velocity * until + 0.5 * start.acceleration * until**2)


def _constant_turn(start: Start, ahead: Floats) -> Complexes:
    first, _ = turned_integrals(start.yaw_rate + 0.0 * ahead, ahead)
    return np.asarray(start.velocity * first)


def _accelerated_turn(start: Start, ahead: Floats) -> Complexes:
    speed, direction = _polar(start.velocity)
    change = (start.acceleration * direction.conj()).real
    until = _until_stop(speed, change, ahead)
    first, second = turned_integrals(start.yaw_rate + 0.0 * until, until)
    return np.asarray(direction * (speed * first + change * second))


def _two_axle(start: Start, ahead: Floats) -> Complexes:
    """Move along a circle: with the speed, the yaw rate changes, too."""
    speed = (start.velocity * start.direction.conj()).real
    change = (start.acceleration * start.direction.conj()).real
    until = _until_stop(np.abs(speed), change * np.sign(speed), ahead)
    way = speed * until + 0.5 * change * until**2
    fast = np.abs(speed) > LEAST_SPEED_MPS
    curvature = np.where(fast, start.yaw_rate / np.where(fast, speed, 1.0), 0.0)
    curvature = np.clip(curvature, -CURVATURE_MAX_PER_M, CURVATURE_MAX_PER_M)
    chord, _ = turned_integrals(curvature + 0.0 * way, way)
    return np.asarray(start.direction * chord)


PREDICTORS: dict[str, Callable[[Start, Floats], Complexes]] = {
    "stationary": _stationary,
    "cv": _constant_velocity,
    "ca": _constant_acceleration,
    "ctrv": _constant_turn,
    "ctra": _accelerated_turn,
    "two-axle": _two_axle,
}
"""Displacement (K, H) by each model after the times (K, H) ahead [s]."""


def _polar(velocity: Complexes) -> tuple[Floats, Complexes]:
    """Return speeds (K, 1) [m/s] and unit vectors (K, 1)."""
    speed = np.abs(velocity)
    return speed, np.where(speed > 0.0, velocity / np.maximum(speed, np.finfo(np.float64).tiny), 1.0 + 0.0j)


def _until_stop(speed: Floats, change: Floats, ahead: Floats) -> Floats:
    """(K, H) times ahead, at most until the vehicle stops [s]."""
    stop = np.where(change < 0.0, speed / np.maximum(-change, np.finfo(np.float64).tiny), np.inf)
    return np.minimum(ahead, stop)
