"""Motion of the ego and the actors of one frame in one table."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from luxloop.arrays import Bools, Floats, Ints
from luxloop.scenarios.grading.articulated import parts
from luxloop.scenarios.grading.truth_events.truth_event import JUMP_M, ON_WHEELS, OVERLAP_M2
from luxloop.sensor_model.truth import NO_ACTOR
from luxloop.sim.world import JOINTS, Kind, WorldFrame

EGO_ROW, EGO_NAME = 0, "ego"
EGO = NO_ACTOR
"""Id of the ego in the table `events`, which no actor has."""


@dataclass(frozen=True, slots=True, eq=False)
class Bodies:
    """M bodies of one frame: the ego, then the actors in their order."""

    time: float
    id: Ints
    """(M,) ids in ascending order; the ego's is `EGO`."""
    kind: npt.NDArray[np.uint8]
    """(M,) `Kind`; the ego counts as a car."""
    pose_world: Floats
    """(M, 3) box centre [m], yaw [rad]."""
    velocity_world: Floats
    """(M, 2) [m/s]."""
    acceleration_world: Floats
    """(M, 2) [m/s^2]."""
    yaw_rate: Floats
    """(M,) [rad/s]."""
    joint_angles: Floats
    """(M, JOINTS) [rad] see `luxloop.sim.world.Actors`."""
    size: Floats
    """(M, 2) length and width [m]."""

    @classmethod
    def of(cls, frame: WorldFrame) -> "Bodies":
        """Return the bodies of a frame."""
        ego, actors = frame.ego, frame.actors
        return cls(
            time=frame.time,
            id=np.append(EGO, actors.id),
            kind=np.append(np.uint8(Kind.CAR), actors.kind),
            pose_world=np.concatenate([ego.pose_world[None], actors.pose_world]),
            velocity_world=np.concatenate([ego.velocity_world[None], actors.velocity_world]),
            acceleration_world=np.concatenate([ego.acceleration_world[None], actors.acceleration_world]),
            yaw_rate=np.append(ego.yaw_rate, actors.yaw_rate),
            joint_angles=np.vstack([np.zeros(JOINTS), actors.joint_angles]),
            size=np.concatenate([ego.size[None, :2], actors.size[:, :2]]),
        )


def common_rows(before: Ints, now: Ints) -> tuple[Ints, Ints]:
    """Return the rows in two ascending arrays of ids of those that are in both."""
    if len(before) == len(now) and (before == now).all():
        rows = np.arange(len(now))
        return rows, rows
    _, old, new = np.intersect1d(before, now, assume_unique=True, return_indices=True)
    return old, new


def body_name(frame: WorldFrame, row: int) -> str:
    """Return the name of a row of `Bodies`."""
    return EGO_NAME if row == EGO_ROW else str(frame.actors.name[row - 1])


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


class Overlaps(NamedTuple):
    """K overlapping pairs of bodies."""

    first: Ints
    """(K,) row in `Bodies`; smaller than the other."""
    second: Ints
    """(K,) row of the other body."""
    area: Floats
    """(K,) [m^2]."""


def overlaps(bodies: Bodies) -> Overlaps:
    """Return the pairs whose overlap is larger than `OVERLAP_M2`."""
    row = np.arange(len(bodies.id))
    pose, size = bodies.pose_world, bodies.size
    if bodies.joint_angles.any():
        row, pose, size = parts(pose, size, bodies.joint_angles, bodies.kind)
    boxes = np.concatenate([pose, size], axis=1)
    first, second = _near_pairs(boxes, row)
    if not len(first):
        return Overlaps(first, second, np.empty(0))
    from luxloop.scenarios.grading.kernels.clipping import shared_areas  # numba takes half a second to import

    area = shared_areas(boxes[first], boxes[second])
    if not (area > 0.0).any():
        return Overlaps(first[:0], second[:0], area[:0])
    count = len(bodies.id)
    low, high = np.minimum(row[first], row[second]), np.maximum(row[first], row[second])
    pair, at = np.unique(low * count + high, return_inverse=True)
    total: Floats = np.bincount(at, weights=area, minlength=len(pair)).astype(np.float64)
    over = total > OVERLAP_M2
    return Overlaps(pair[over] // count, pair[over] % count, total[over])


def _near_pairs(boxes: Floats, row: Ints) -> tuple[Ints, Ints]:
    """Return the pairs of boxes (B, 5) of different bodies whose circumscribed circles overlap."""
    x, y = boxes[:, 0], boxes[:, 1]
    half = 0.5 * np.hypot(boxes[:, 3], boxes[:, 4])
    near = (x[:, None] - x) ** 2 + (y[:, None] - y) ** 2 < (half[:, None] + half) ** 2
    first, second = np.nonzero(near)
    kept = (first < second) & (row[first] != row[second])
    return first[kept], second[kept]
