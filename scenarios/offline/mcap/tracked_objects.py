"""Objects in the world frame as `vision_msgs/Detection3DArray` and `autoware_perception_msgs/TrackedObjects`.

Autoware's twist and acceleration are over ground, on the axes of the object. Covariances are zero, as unknown ones are
in ROS: the tables of a run have none. Names of classes are those of Autoware in lower case.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from luxloop.scenarios.arrays import Floats
from luxloop.scenarios.grading.plane_geometry import turned
from luxloop.scenarios.offline.mcap.messages import MAP, Message, header, planar_pose, vector
from luxloop.sim.world import Kind

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
