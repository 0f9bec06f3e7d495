"""Actors and confirmed tracks of a frame as objects in the world frame."""

import numpy as np
import pandas as pd

from luxloop.scenarios.offline.mcap.box_scenes import POSE, TRACK_HEIGHT_M, VELOCITY
from luxloop.scenarios.offline.mcap.tracked_objects import CLASSES, WorldObject
from luxloop.sim.world import Kind, Mode, WorldFrame

CONFIRMED, STATIONARY = "confirmed", "stationary"
ACCELERATION = ["ax_world_mps2", "ay_world_mps2"]


def actors(frame: WorldFrame) -> list[WorldObject]:
    """Return all actors."""
    found = frame.actors
    return [
        WorldObject(
            id=int(found.id[a]),
            label=CLASSES[Kind(found.kind[a])],
            pose_world=found.pose_world[a],
            size=found.size[a],
            velocity_world=found.velocity_world[a],
            acceleration_world=found.acceleration_world[a],
            yaw_rate=float(found.yaw_rate[a]),
            stationary=bool(found.mode[a] == Mode.STATIONARY),
        )
        for a in range(len(found))
    ]


def tracks(table: pd.DataFrame) -> list[WorldObject]:
    """Return the confirmed tracks of the rows of a frame; they have no class and no yaw rate."""
    shown = table[table["status"] == CONFIRMED]
    columns = (shown[names].to_numpy(np.float64) for names in (POSE, VELOCITY, ACCELERATION))
    return [
        WorldObject(
            id=int(row.track_id),
            label="unknown",
            pose_world=pose,
            size=np.array([row.length_m, row.width_m, TRACK_HEIGHT_M]),
            velocity_world=velocity,
            acceleration_world=acceleration,
            yaw_rate=0.0,
            stationary=row.model == STATIONARY,
        )
        for row, pose, velocity, acceleration in zip(shown.itertuples(), *columns, strict=True)
    ]
