"""Semitrailers: coupled at the kingpin, led by it, their own axles follow without slip."""

from dataclasses import dataclass

import numpy as np

from sim.articulation import Hitch
from sim.physical.rolling import Rolling
from sim.world import Floats, Ints


@dataclass(frozen=True, slots=True, eq=False)
class Trailing:
    """N trailers at one instant: of the whole vehicle's box, were it straight, laid along the trailer."""

    yaw: Floats
    """(N,) [rad], not wrapped."""
    yaw_rate: Floats
    """(N,) [rad/s]."""
    centre: tuple[Floats, Floats, Floats]
    """Place (N, 2) [m], velocity [m/s] and acceleration [m/s^2] of the box centre."""


class Trailers:
    """The trailers of one run.

    Parameters
    ----------
    dt
        Time between frames [s].
    """

    def __init__(self, dt: float):
        self._dt = dt
        self._id = np.empty(0, np.int64)
        self._trailing: Trailing

    def follow(self, id: Ints, tractor: Rolling, length: Floats, hitch: Hitch) -> Trailing:
        """Return the motion of N trailers a frame later; those that were not there before are in line.

        Parameters
        ----------
        id
            (N,) of the vehicles, ascending.
        tractor, length, hitch
            As for `trail`.
        """
        yaw = tractor.yaw.copy()
        _, new, old = np.intersect1d(id, self._id, assume_unique=True, return_indices=True)
        if len(new):
            # Heun's method: the mean of the rates at the start and, by a first guess, at the end
            before, rate = self._trailing.yaw[old], self._trailing.yaw_rate[old]
            yaw[new] = before + rate * self._dt
            yaw[new] = before + 0.5 * self._dt * (rate + trail(tractor, yaw, length, hitch).yaw_rate[new])
        self._id, self._trailing = id, trail(tractor, yaw, length, hitch)
        return self._trailing


def trail(tractor: Rolling, yaw: Floats, length: Floats, hitch: Hitch) -> Trailing:
    """Return the motion of trailers.

    The trailer's yaw rate is the kingpin's speed across the trailer over the distance from there to its axles
    (Rajamani 2012, as for the front of a bicycle model).

    Parameters
    ----------
    tractor
        N tractors.
    yaw
        (N,) of the trailers [rad].
    length
        (N,) of the whole vehicles [m].
    hitch
        Where they couple and roll.
    """
    place, velocity, acceleration = tractor.at(hitch.drive_axle - hitch.kingpin)
    u = np.column_stack([np.cos(yaw), np.sin(yaw)])
    n = np.column_stack([-u[:, 1], u[:, 0]])
    base = hitch.trailer_axles - hitch.kingpin
    rate = np.einsum("nc,nc->n", velocity, n) / base
    swing = (np.einsum("nc,nc->n", acceleration, n) - rate * np.einsum("nc,nc->n", velocity, u)) / base
    ahead = (hitch.kingpin - 0.5 * length)[:, None]  # of the centre, seen from the kingpin
    centre = (
        place + ahead * u,
        velocity + ahead * rate[:, None] * n,
        acceleration + ahead * (swing[:, None] * n - rate[:, None] ** 2 * u),
    )
    return Trailing(yaw, rate, centre)
