"""Velocity, acceleration and yaw rate from poses alone, for simulators that do not tell them or tell them wrongly."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from sim.world import Floats, Ints

JUMP_SPEED = 10.0
"""[m/s] A pose that moves this much faster than its own speed did not drive there: it was teleported, or it
changed lanes in one step, which SUMO does without a lateral resolution."""


def wrap_angle(angle: Floats) -> Floats:
    """Bring angles [rad] into (-pi, pi]."""
    return np.pi - (np.pi - angle) % (2 * np.pi)


@dataclass(frozen=True, slots=True, eq=False)
class Rates:
    """Rates of N poses."""

    velocity_world: Floats
    """(N, 2) [m/s]."""
    acceleration_world: Floats
    """(N, 2) [m/s^2]."""
    yaw_rate: Floats
    """(N,) [rad/s], counter-clockwise positive."""


@dataclass(frozen=True, slots=True, eq=False)
class _Past:
    """What the last frame leaves for the next."""

    id: Ints
    pose_world: Floats
    velocity_world: Floats
    differenced: npt.NDArray[np.bool_]
    """(N,) the velocity came from two poses."""


class PoseDifferencer:
    """Backward differences over consecutive frames.

    A velocity or yaw rate takes two consecutive poses, an acceleration three. Until an actor has them, its velocity
    is the simulator's speed along its heading, the rest is zero. An actor that was away for a frame, or
    jumped, starts anew.

    Parameters
    ----------
    dt
        Time between frames [s].
    """

    def __init__(self, dt: float):
        self._dt = dt
        nobody = np.empty((0, 3))
        self._past = _Past(np.empty(0, np.int64), nobody, nobody[:, :2], np.empty(0, np.bool_))

    def add(self, id: Ints, pose_world: Floats, speed: Floats) -> Rates:
        """Take the next frame and return its rates.

        Parameters
        ----------
        id
            (N,) strictly ascending.
        pose_world
            (N, 3) x [m], y [m], yaw [rad].
        speed
            (N,) the simulator's own speed [m/s].
        """
        past, row = self._past, np.searchsorted(self._past.id, id)
        known = np.isin(id, past.id, assume_unique=True)
        row[~known] = 0  # any row will do, it is masked out below
        before = past.pose_world[row] if len(past.id) else pose_world
        step = (pose_world - before) / self._dt
        driven = known & (np.hypot(step[:, 0], step[:, 1]) <= np.abs(speed) + JUMP_SPEED)

        yaw = pose_world[:, 2]
        along_heading = speed[:, None] * np.column_stack([np.cos(yaw), np.sin(yaw)])
        velocity = np.where(driven[:, None], step[:, :2], along_heading)
        acceleration = np.zeros_like(velocity)
        if len(past.id):
            steady = driven & past.differenced[row]
            acceleration[steady] = ((velocity - past.velocity_world[row]) / self._dt)[steady]
        yaw_rate = np.where(driven, wrap_angle(yaw - before[:, 2]) / self._dt, 0.0)

        self._past = _Past(id, pose_world, velocity, driven)
        return Rates(velocity, acceleration, yaw_rate)
