"""Pitch and roll of bodies on their suspension, and lean of riders, driven by the acceleration.

The sprung mass stands on springs and dampers over the axles, and pitch and roll are two linear oscillators. The
acceleration a acts at the height h of the centre of gravity above the axis of rotation. For pitch, with springs of the
ride frequency f at both ends of the wheelbase L, the balance of moments gives the gradient

    pitch / a = (1 - anti-dive) h / ((pi f L)^2),

see Gillespie 1992, "Fundamentals of Vehicle Dynamics", chapters 5 and 7. A car with h = 0.55 m, L = 2.7 m, f = 1.3 Hz
and 20 % anti-dive has 2.0 degrees per g. Roll gradients are measured: 3 degrees per g on sports cars to 8 on soft
family cars (Milliken and Milliken 1995, "Race Car Vehicle Dynamics", chapter 16).
"""

import math
from typing import NamedTuple

import numpy as np

from luxloop import elementary, elementwise
from luxloop.arrays import Bools, Floats, Ints
from luxloop.sim.world import Kind

GRAVITY = 9.81
"""[m/s^2]"""
LEAN_LAG_S = 0.25
"""[s] Time constant of a rider's lean; an estimate."""
_GRIP_MPS2 = GRAVITY  # tyres transmit no more; larger accelerations are artefacts of the source
_CLASSES, _PITCH, _ROLL = len(Kind), 0, 1


class Sprung(NamedTuple):
    """Pitch and roll of one class of vehicles."""

    pitch_deg_per_g: float
    """[deg/g] Settled pitch per longitudinal acceleration; 1 g is 9.81 m/s^2."""
    roll_deg_per_g: float
    """[deg/g] Settled roll per lateral acceleration."""
    frequency_hz: float
    """[Hz] Undamped natural frequency of both."""
    damping: float
    """Damping ratio of both."""


SPRUNG = {
    # h 0.55 m, L 2.7 m, 1.3 Hz, anti-dive 20 %; a middle-market sedan. Cars have 0.2 to 0.4 of the critical damping.
    Kind.CAR: Sprung(2.0, 5.0, 1.3, 0.3),
    # h 0.70 m, L 2.75 m, 1.25 Hz, anti-dive 20 %; higher and softer.
    Kind.SUV: Sprung(2.7, 6.5, 1.25, 0.3),
    # h 0.70 m, L 3.2 m, 1.4 Hz, no anti-dive.
    Kind.VAN: Sprung(2.0, 6.0, 1.4, 0.3),
    # h 1.1 m, L 4.8 m, 1.7 Hz, no anti-dive; roll is an estimate from rollover tests (Winkler and Ervin 1999).
    Kind.TRUCK: Sprung(0.9, 5.0, 1.7, 0.2),
    # The trailer, which defines the pose: h 1.8 m, 7.7 m from kingpin to axles, 1.6 Hz; roll as of the truck.
    Kind.TRAILER_TRUCK: Sprung(0.7, 5.5, 1.6, 0.2),
    # h 1.0 m, L 6.0 m, 1.2 Hz, air springs.
    Kind.BUS: Sprung(1.1, 5.0, 1.2, 0.25),
}
"""Constants of the classes of vehicles. The dimensions are typical ones; the products are estimates."""
RIDERS = (Kind.MOTORCYCLE, Kind.BICYCLE)
"""Classes that lean into a turn. Pedestrians and obstacles stay upright."""


class Suspension:
    """Attitudes of the bodies of one run, frame by frame.

    A vehicle's pitch and roll follow their settled values u by x'' = w^2 (u - x) - 2 z w x', with the natural angular
    frequency w and the damping ratio z. A rider's lean follows atan(a / g), at which gravity and inertia balance
    (Cossalter 2006, "Motorcycle Dynamics", chapter 4), with the lag T: x' = (u - x) / T. Between frames u is linear,
    for which the solution is exact, so that the attitude does not depend on the frame rate. A body that was absent
    from the previous frame starts settled.

    Parameters
    ----------
    dt
        Time between frames [s].
    """

    def __init__(self, dt: float):
        self._dt = dt
        self._lag, self._transition = _solution(dt)
        self._id = np.empty(0, dtype=np.int64)
        self._settled, self._angle, self._rate = np.zeros((3, 0, 2))

    def attitude(self, id: Ints, kind: Ints, yaw: Floats, acceleration_world: Floats) -> Floats:
        """Return pitch and roll (N, 2) of N bodies in the next frame, as in `sim.world.Actors`, on a level road [rad].

        Parameters
        ----------
        id
            (N,) ascending.
        kind
            (N,) `Kind`.
        yaw
            (N,) of the bodies [rad].
        acceleration_world
            (N, 2) [m/s^2].
        """
        settled = _settled(kind, yaw, acceleration_world)
        row, known = self._previous_rows(id)
        before = np.where(known[:, None], self._settled[row], settled)
        angle = np.where(known[:, None], self._angle[row], settled)
        rate = np.where(known[:, None], self._rate[row], 0.0)
        # Deviation from the steady response to the ramp of u, which lags behind it.
        slope = (settled - before) / self._dt
        behind = self._lag[kind] * slope
        angle, rate = angle - before + behind, rate - slope
        from_angle, from_rate, rate_from_angle, rate_from_rate = self._transition[:, kind]
        self._angle = settled - behind + from_angle * angle + from_rate * rate
        self._rate = slope + rate_from_angle * angle + rate_from_rate * rate
        self._id, self._settled = id, settled
        return self._angle

    def _previous_rows(self, id: Ints) -> tuple[Ints, Bools]:
        """Return the rows (N,) of the bodies in the previous frame, and a mask (N,) of those that were in it."""
        if not len(self._id):
            self._settled, self._angle, self._rate = np.zeros((3, 1, 2))
            return np.zeros(len(id), dtype=np.int64), np.zeros(len(id), dtype=np.bool_)
        row = np.minimum(np.searchsorted(self._id, id), len(self._id) - 1)
        return row, self._id[row] == id


def _settled(kind: Ints, yaw: Floats, acceleration_world: Floats) -> Floats:
    """Return the (N, 2) pitch and roll that bodies settle at under constant accelerations (N, 2) [rad]."""
    cos, sin = elementwise.cos(yaw), elementwise.sin(yaw)
    ax, ay = acceleration_world.T
    # Braking lowers the front; in a turn to the left, a vehicle's right side goes down, and a rider's left side.
    driving = np.stack([-(cos * ax + sin * ay), cos * ay - sin * ax], axis=1)
    settled: Floats = _GRADIENT[kind] * np.clip(driving, -_GRIP_MPS2, _GRIP_MPS2)
    leaning = np.flatnonzero(_LEANS[kind])
    settled[leaning, _ROLL] = -elementwise.atan2(driving[leaning, _ROLL], GRAVITY)
    return settled


def _solution(dt: float) -> tuple[Floats, Floats]:
    """Return by `Kind` and axis the lag behind a ramp (K, 2) [s], and the free motion over a frame (4, K, 2).

    The free motion is the matrix from angle and rate to angle and rate; 0 for bodies that do not move.
    """
    lag, transition = np.zeros((_CLASSES, 2)), np.zeros((4, _CLASSES, 2))
    for kind, (_, _, frequency_hz, damping) in SPRUNG.items():
        w = 2.0 * math.pi * frequency_hz
        decay, damped = damping * w, w * math.sqrt(1.0 - damping * damping)
        fades, cos, sin = elementary.exp(-decay * dt), elementary.cos(damped * dt), elementary.sin(damped * dt)
        free = (cos + decay / damped * sin, sin / damped, -w * w / damped * sin, cos - decay / damped * sin)
        lag[kind], transition[:, kind] = 2.0 * damping / w, fades * np.array(free)[:, None]
    for kind in RIDERS:
        lag[kind, _ROLL], transition[0, kind, _ROLL] = LEAN_LAG_S, elementary.exp(-dt / LEAN_LAG_S)
    return lag, transition


def _gradients() -> Floats:
    """Return by `Kind` the settled pitch and roll (K, 2) per acceleration [rad s^2/m]."""
    gradient = np.zeros((_CLASSES, 2))
    for kind, (pitch_deg, roll_deg, _, _) in SPRUNG.items():
        gradient[kind] = np.radians([pitch_deg, roll_deg]) / GRAVITY
    return gradient


_GRADIENT = _gradients()
_LEANS = np.isin(np.arange(_CLASSES), RIDERS)
