"""Motion of bodies from frame to frame: jumps, acceleration, jerk and yaw rate."""

from typing import NamedTuple

import numpy as np

from luxloop.scenarios.arrays import Bools, Floats
from luxloop.scenarios.grading.truth_events.bodies import Bodies, common_rows
from luxloop.scenarios.grading.truth_events.event_limits import JUMP_M, ON_WHEELS


class Motion(NamedTuple):
    """Motion of the M bodies of a frame."""

    jump_m: Floats
    """(M,) distance from the place that the mean of both velocities leads to [m]; 0 for new bodies."""
    quantities: Floats
    """(M, 3) values of `event_limits.LIMITS`: acceleration, jerk and yaw rate. The acceleration is the larger of the
    delivered one and that of three poses, the jerk the difference of delivered accelerations."""


class MotionHistory:
    """Compares each frame with the ones before it."""

    def __init__(self) -> None:
        self._before: Bodies | None = None
        self._mean_velocity = np.empty((0, 2))

    def add(self, now: Bodies) -> Motion:
        """Return the motion of a frame's bodies since the last frame."""
        before, count = self._before, len(now.id)
        jump, from_poses, jerk = np.zeros((3, count))
        mean_velocity = np.full((count, 2), np.nan)
        if before is not None and (dt := now.time - before.time) > 0:
            old, new = common_rows(before.id, now.id)
            moved = (now.pose_world[new, :2] - before.pose_world[old, :2]) / dt
            off = moved - 0.5 * (now.velocity_world[new] + before.velocity_world[old])
            change = now.acceleration_world[new] - before.acceleration_world[old]
            bend = moved - self._mean_velocity[old]
            jump[new] = dt * _norm(off)
            steady = jump[new] <= JUMP_M
            jerk[new] = np.where(steady, _norm(change) / dt, 0.0)
            from_poses[new] = np.where(steady, np.nan_to_num(_norm(bend)) / dt, 0.0)
            mean_velocity[new] = np.where(steady[:, None], moved, np.nan)
        self._before, self._mean_velocity = now, mean_velocity
        quantities = np.empty((count, 3))
        quantities[:, 0] = np.maximum(_norm(now.acceleration_world), from_poses)
        quantities[:, 1] = jerk
        quantities[:, 2] = np.where(ON_WHEELS[now.kind], np.abs(now.yaw_rate), 0.0)
        return Motion(jump, quantities)


def is_jump(motion: Motion) -> Bools:
    """(M,) mask of bodies that moved discontinuously."""
    return motion.jump_m > JUMP_M


def _norm(vectors: Floats) -> Floats:
    """Return the norms (K,) of vectors (K, 2)."""
    norm: Floats = np.hypot(vectors[:, 0], vectors[:, 1])
    return norm
