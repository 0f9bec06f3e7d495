"""Prediction of the tracked corner by each motion model.

Every model is extrapolated by its own physics: a stationary vehicle stays, and a braking one stops and does not move
backwards. In a bank whose vehicles change their mode, an acceleration lasts for an exponentially distributed time. Its
mean effect is used. Vectors are complex numbers x + iy.
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
    """States of K vehicles at the time of the scan; arrays (K, 1) unless stated."""

    position: Complexes
    """[m]."""
    velocity: Complexes
    """[m/s]."""
    acceleration: Complexes
    """(K, H) constant acceleration with the same effect after each of the H times of `PREDICTION_S` [m/s^2]."""
    yaw_rate: Floats
    """[rad/s]."""
    direction: Complexes
    """Unit vectors, see `tracker.tracking.turning.Turn`."""

    @classmethod
    def of(cls, mean: Floats, yaw_rate: Floats, direction: Complexes, share: Floats) -> "Start":
        """Return the states of filters with means (K, 6), known inputs (K,), and `lasting` shares (K, H)."""
        position, velocity, acceleration = (mean[:, k, None] + 1j * mean[:, k + 1, None] for k in (0, 2, 4))
        lasts = np.asarray(acceleration * share, dtype=np.complex128)
        return cls(position, velocity, lasts, yaw_rate[:, None], direction[:, None])


def lasting(mode_time_s: Floats) -> Floats:
    """(K, H) mean displacement by an acceleration that ends at a random time, relative to one that lasts.

    With the mean time T in the mode (K,) [s], infinite for a model that never ends, the acceleration has the mean
    a exp(-t / T), whose double integral over the time h is a T^2 (exp(-h / T) + h / T - 1).
    """
    share = np.array(PREDICTION_S) / mode_time_s[:, None]
    some = share > 1e-3
    safe = np.where(some, share, 1.0)
    return np.where(some, 2.0 * (np.expm1(-safe) + safe) / safe**2, 1.0 - share / 3.0)


def predict(name: str, start: Start) -> Floats:
    """(K, len(PREDICTION_S), 2) positions of K vehicles by one model [m]."""
    moved = start.position + PREDICTORS[name](start, np.broadcast_to(PREDICTION_S, start.acceleration.shape))
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
    """Return speeds [m/s] and unit vectors, of the shape of the velocities."""
    speed = np.abs(velocity)
    moves = speed > 0.0
    return speed, np.where(moves, velocity / np.where(moves, speed, 1.0), 1.0 + 0.0j)


def _until_stop(speed: Floats, change: Floats, ahead: Floats) -> Floats:
    """(K, H) times ahead, at most until the vehicle stops [s]."""
    brakes = change * ahead < -speed
    return np.where(brakes, speed / np.where(brakes, -change, 1.0), ahead)
