"""Confirmed tracks as OSI messages.

| message | frame of reference | velocity |
|---|---|---|
| `osi3.SensorData` | virtual sensor at the ego's box centre on the ground | relative to it, as OSI defines it |
| `osi3.TrafficUpdate`, one per track | world | over ground, exactly as in the table of the run |
"""

import betterosi as osi
import numpy as np
import pandas as pd

from luxloop.scenarios.arrays import Floats
from luxloop.scenarios.exchange.exported_run import TRACK_HEIGHT_M
from luxloop.scenarios.exchange.osi.base_values import identifier, moving_base, orientation, timestamp, vector, version
from luxloop.scenarios.grading.plane_geometry import into_frame, turned
from luxloop.sim.world import Ego, WorldFrame

TRACKER = 0
"""Sensor id of the tracker."""


def sensor_data(frame: WorldFrame, tracks: pd.DataFrame, rear_axle_x_m: float) -> osi.SensorData:
    """Return all tracks of a frame as detected moving objects.

    Parameters
    ----------
    frame
        The frame.
    tracks
        Confirmed rows of the frame of the table of tracks.
    rear_axle_x_m
        Position of the rear axle of the ego, from its box centre [m].
    """
    time = timestamp(frame.time)
    header = osi.DetectedEntityHeader(
        measurement_time=time,
        cycle_counter=frame.index,
        data_qualifier=osi.DetectedEntityHeader.DataQualifier.AVAILABLE,
    )
    box_center = osi.MountingPosition(position=vector(-rear_axle_x_m, 0.0), orientation=orientation(0.0))
    return osi.SensorData(
        version=version(),
        timestamp=time,
        last_measurement_time=time,
        sensor_id=identifier(TRACKER),
        mounting_position=box_center,
        moving_object_header=header,
        moving_object=_detected(frame.ego, tracks),
    )


def traffic_updates(frame: WorldFrame, tracks: pd.DataFrame) -> list[osi.TrafficUpdate]:
    """Return a message for each track of a frame, in the world frame."""
    found = []
    for track in tracks.itertuples():
        pose = (track.x_world_m, track.y_world_m, track.yaw_world_rad)
        base = moving_base(pose, _size(track), np.array([track.vx_world_mps, track.vy_world_mps]))
        moving = osi.MovingObject(id=identifier(track.track_id), base=base)
        found.append(osi.TrafficUpdate(version=version(), timestamp=timestamp(frame.time), update=[moving]))
    return found


def relative_velocity(velocity_world: Floats, position_ego: Floats, ego: Ego) -> Floats:
    """(N, 2) velocity in the moving and turning ego frame of objects at (N, 2) [m/s]: R^T (v - v_ego) - w x p."""
    swept = ego.yaw_rate * np.column_stack([-position_ego[:, 1], position_ego[:, 0]])
    found: Floats = turned(velocity_world - ego.velocity_world, -ego.pose_world[2]) - swept
    return found


def _detected(ego: Ego, tracks: pd.DataFrame) -> list[osi.DetectedMovingObject]:
    pose_world = tracks[["x_world_m", "y_world_m", "yaw_world_rad"]].to_numpy(np.float64)
    pose_ego = into_frame(pose_world, ego.pose_world)
    velocity = relative_velocity(tracks[["vx_world_mps", "vy_world_mps"]].to_numpy(np.float64), pose_ego[:, :2], ego)
    return [
        osi.DetectedMovingObject(
            header=osi.DetectedItemHeader(tracking_id=identifier(track.track_id)),
            base=moving_base(pose_ego[t], _size(track), velocity[t]),
        )
        for t, track in enumerate(tracks.itertuples())
    ]


def _size(track: object) -> tuple[float, float, float]:
    return track.length_m, track.width_m, TRACK_HEIGHT_M  # type: ignore[attr-defined]
