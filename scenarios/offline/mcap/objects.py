"""Actors and tracks of a frame: boxes of a Foxglove scene, and objects in the world frame as ROS messages.

The metadata of a box of a scene has its exact numbers as text, since a quaternion rounds the heading: `heading_rad` in
the true ego frame, and the pose and velocity over ground in the world frame. `luxloop.scenarios.offline.mcap.boxes`
reads them.

Objects are `vision_msgs/Detection3DArray` and `autoware_perception_msgs/TrackedObjects`. Autoware's twist and
acceleration are over ground, on the axes of the object. Covariances are zero, as unknown ones are in ROS: the tables of
a run have none. Names of classes are those of Autoware in lower case.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import pandas as pd

from luxloop.arrays import Floats
from luxloop.scenarios.grading.frame_truth import points_of_actors
from luxloop.scenarios.grading.plane_geometry import into_frame, turned
from luxloop.scenarios.offline.mcap.messages import MAP, Box, Color, Message, header, planar_pose, vector
from luxloop.scenarios.offline.recorded_scans import TRACK_HEIGHT_M
from luxloop.sensor_model.truth import ScanTruth
from luxloop.sim.world import Kind, Mode, WorldFrame

LABELS = ("unknown", "car", "truck", "bus", "trailer", "motorcycle", "bicycle", "pedestrian")
"""Classes in the order of the codes of `autoware_perception_msgs/ObjectClassification`."""
CLASSES = {
    Kind.CAR: "car", Kind.SUV: "car", Kind.VAN: "car", Kind.TRUCK: "truck", Kind.TRAILER_TRUCK: "trailer",
    Kind.BUS: "bus", Kind.MOTORCYCLE: "motorcycle", Kind.BICYCLE: "bicycle", Kind.PEDESTRIAN: "pedestrian",
    Kind.OBSTACLE: "unknown",
}  # fmt: skip
_BOUNDING_BOX, _ORIENTATION_AVAILABLE = 0, 2
_NO_COVARIANCE = [0.0] * 36


class WorldObject(NamedTuple):
    """An actor or a track."""

    id: int
    label: str
    """Class, of `LABELS`."""
    pose_world: Floats
    """(3,) x [m], y [m], yaw [rad] of the box centre."""
    size: Floats
    """(3,) length, width, height [m]."""
    velocity_world: Floats
    """(2,) over ground [m/s]; NaN where it is unknown."""
    acceleration_world: Floats
    """(2,) [m/s^2]; NaN where it is unknown."""
    yaw_rate: float
    """[rad/s]; 0 where it is unknown."""
    stationary: bool


def detections(time_ns: int, objects: Sequence[WorldObject]) -> Message:
    """Return a `vision_msgs/Detection3DArray`."""
    at = header(time_ns, MAP)
    return {"header": at, "detections": [_detection(at, found) for found in objects]}


def tracked_objects(time_ns: int, objects: Sequence[WorldObject]) -> Message:
    """Return an `autoware_perception_msgs/TrackedObjects`."""
    return {"header": header(time_ns, MAP), "objects": [_tracked(found) for found in objects]}


def _detection(at: Message, found: WorldObject) -> Message:
    pose = _pose(found)
    hypothesis = {"class_id": found.label, "score": 1.0}
    result = {"hypothesis": hypothesis, "pose": {"pose": pose, "covariance": _NO_COVARIANCE}}
    return {"header": at, "results": [result], "bbox": {"center": pose, "size": _size(found)}, "id": str(found.id)}


def _tracked(found: WorldObject) -> Message:
    kinematics = {
        "pose_with_covariance": {"pose": _pose(found), "covariance": _NO_COVARIANCE},
        "twist_with_covariance": {
            "twist": {"linear": _own_axes(found, found.velocity_world), "angular": vector(0.0, 0.0, found.yaw_rate)},
            "covariance": _NO_COVARIANCE,
        },
        "acceleration_with_covariance": {
            "accel": {"linear": _own_axes(found, found.acceleration_world), "angular": vector(0.0, 0.0, 0.0)},
            "covariance": _NO_COVARIANCE,
        },
        "orientation_availability": _ORIENTATION_AVAILABLE,
        "is_stationary": found.stationary,
    }
    return {
        "object_id": {"uuid": list(found.id.to_bytes(16, "big"))},
        "existence_probability": 1.0,
        "classification": [{"label": LABELS.index(found.label), "probability": 1.0}],
        "kinematics": kinematics,
        "shape": {"type": _BOUNDING_BOX, "footprint": {"points": []}, "dimensions": _size(found)},
    }


def _pose(found: WorldObject) -> Message:
    x, y, yaw = found.pose_world.tolist()
    return planar_pose(x, y, 0.5 * float(found.size[2]), yaw)


def _size(found: WorldObject) -> Message:
    length, width, height = found.size.tolist()
    return vector(length, width, height)


def _own_axes(found: WorldObject, values: Floats) -> Message:
    ahead, left = turned(np.nan_to_num(values), -float(found.pose_world[2])).tolist()
    return vector(ahead, left, 0.0)


TRUTH: Color = (1.0, 1.0, 1.0, 0.3)
COLORS: dict[str, Color] = {
    "tentative": (0.6, 0.6, 0.6, 0.3),
    "confirmed": (0.2, 0.8, 0.4, 0.5),
    "coasting": (0.3, 0.5, 1.0, 0.4),
}
"""Colour of tracks by status; dead tracks are not exported."""
POINTS = "points"
"""Key of the number of points on an actor."""
HEADING = "heading_rad"
WORLD = ("x_world_m", "y_world_m", "heading_world_rad", "vx_world_mps", "vy_world_mps")
"""Keys of the exact numbers."""
POSE, VELOCITY = ["x_world_m", "y_world_m", "yaw_world_rad"], ["vx_world_mps", "vy_world_mps"]
"""Columns of the table of tracks."""


def actor_boxes(frame: WorldFrame, truth: ScanTruth) -> list[Box]:
    """Return the boxes of all actors."""
    actors, fraction = frame.actors, truth.visible_fraction
    points = points_of_actors(truth.actor_id, actors.id)
    pose_ego = into_frame(actors.pose_world, frame.ego.pose_world)
    return [
        Box(
            id=f"actor {actors.id[a]}",
            pose_ego=pose_ego[a],
            size=actors.size[a],
            color=TRUTH,
            label=str(actors.name[a]),
            metadata={
                "name": actors.name[a],
                "kind": Kind(actors.kind[a]).name.lower(),
                "visible_fraction": f"{fraction[a]:.3f}",
                POINTS: str(points[a]),
                **_exact(pose_ego[a], actors.pose_world[a], actors.velocity_world[a]),
            },
        )
        for a in range(len(actors))
    ]


def track_boxes(frame: WorldFrame, tracks: pd.DataFrame) -> list[Box]:
    """Return boxes in the true ego frame: the tables hold track poses without the odometry drift."""
    shown = tracks[tracks["status"].isin(list(COLORS))]
    pose_world, velocity = (shown[columns].to_numpy(np.float64) for columns in (POSE, VELOCITY))
    pose_ego = into_frame(pose_world, frame.ego.pose_world)
    return [
        Box(
            id=f"track {row.track_id}",
            pose_ego=pose_ego[t],
            size=np.array([row.length_m, row.width_m, TRACK_HEIGHT_M]),
            color=COLORS[row.status],
            label=f"{row.track_id}",
            metadata={
                "status": row.status,
                "verdict": row.verdict,
                "actor_id": row.actor_id,
                **_exact(pose_ego[t], pose_world[t], velocity[t]),
            },
        )
        for t, row in enumerate(shown.itertuples())
    ]


def _exact(pose_ego: Floats, pose_world: Floats, velocity_world: Floats) -> dict[str, str]:
    """Return numbers as the shortest texts that give the same float64."""
    values = zip(WORLD, [*pose_world.tolist(), *velocity_world.tolist()], strict=True)
    return {HEADING: repr(float(pose_ego[2])), **{key: repr(value) for key, value in values}}


CONFIRMED, STATIONARY = "confirmed", "stationary"
ACCELERATION = ["ax_world_mps2", "ay_world_mps2"]


def actor_objects(frame: WorldFrame) -> list[WorldObject]:
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


def track_objects(table: pd.DataFrame) -> list[WorldObject]:
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
