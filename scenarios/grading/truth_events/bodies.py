"""Motion of the ego and the actors of one frame in one table."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from luxloop.scenarios.arrays import Floats, Ints
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
