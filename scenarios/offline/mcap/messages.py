"""Messages of ROS 2 and Foxglove as dictionaries for encoding, and their definitions, which the MCAP file stores.

Readers decode messages by the definition in the file, and tools recognise a message by its name, so all fields are
listed in their order.
"""

import re
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from luxloop.arrays import Floats
from luxloop.scenarios.grading.plane_geometry import turned

Message = dict[str, Any]
Color = tuple[float, float, float, float]

MAP, ODOM, EGO, BASE_LINK = "map", "odom", "ego", "base_link"
"""Frames of reference: world, odometry (drifts in the world), ego (box centre on the ground), and its rear axle on the
ground."""

_NANOSECONDS = 1_000_000_000
_DATATYPE = {"int8": 1, "uint8": 2, "int16": 3, "uint16": 4, "int32": 5, "uint32": 6, "float32": 7, "float64": 8}
"""Codes of `sensor_msgs/PointField`."""
_DELETE_ALL = 1
"""Value of `SceneEntityDeletion.type`."""
_FONT_M = 0.8


class Box(NamedTuple):
    """A labelled box of a scene."""

    id: str
    pose_ego: Floats
    """(3,) x [m], y [m], yaw [rad] of its centre."""
    size: Floats
    """(3,) length, width, height [m]."""
    color: Color
    label: str
    metadata: Mapping[str, object]
    """Further properties, shown by viewers."""


def nanoseconds(time_s: float) -> int:
    """Return a time [s] in integer nanoseconds."""
    return round(time_s * _NANOSECONDS)


def stamp(time_ns: int) -> Message:
    """Return a `builtin_interfaces/Time`."""
    return {"sec": time_ns // _NANOSECONDS, "nanosec": time_ns % _NANOSECONDS}


def header(time_ns: int, frame: str) -> Message:
    """Return a `std_msgs/Header`."""
    return {"stamp": stamp(time_ns), "frame_id": frame}


def cloud(time_ns: int, columns: Mapping[str, npt.NDArray[Any]]) -> Message:
    """Return a `sensor_msgs/PointCloud2` in the ego frame; columns (N,) keep their dtype, without padding."""
    dtype = np.dtype([(name, values.dtype.newbyteorder("<")) for name, values in columns.items()])
    points = np.empty(len(next(iter(columns.values()))), dtype)
    for name, values in columns.items():
        points[name] = values
    return packed_cloud(time_ns, EGO, points)


def packed_cloud(time_ns: int, frame: str, points: npt.NDArray[Any]) -> Message:
    """Return a `sensor_msgs/PointCloud2` of a structured array (N,) with x, y and z, whose layout it keeps."""
    dtype, count = points.dtype, len(points)
    assert dtype.fields is not None
    fields = [
        {"name": name, "offset": offset, "datatype": _DATATYPE[kind.name], "count": 1}
        for name, (kind, offset, *_) in dtype.fields.items()
    ]
    return {
        "header": header(time_ns, frame),
        "height": 1,
        "width": count,
        "fields": fields,
        "is_bigendian": False,
        "point_step": dtype.itemsize,
        "row_step": dtype.itemsize * count,
        "data": points.tobytes(),
        "is_dense": all(bool(np.isfinite(points[axis]).all()) for axis in "xyz"),
    }


def clock(time_ns: int) -> Message:
    """Return a `rosgraph_msgs/Clock`."""
    return {"clock": stamp(time_ns)}


def transforms(time_ns: int, ego_pose_odom: Floats, ego_pose_world: Floats) -> Message:
    """Return a `tf2_msgs/TFMessage`: the ego in the odometry frame, and that frame in the world, by which it drifts."""
    turn = float(ego_pose_world[2] - ego_pose_odom[2])
    origin = ego_pose_world[:2] - turned(ego_pose_odom[:2], turn)
    poses = [(ODOM, EGO, *ego_pose_odom.tolist()), (MAP, ODOM, *origin.tolist(), turn)]
    return {
        "transforms": [
            {
                "header": header(time_ns, parent),
                "child_frame_id": child,
                "transform": {"translation": vector(x, y, 0.0), "rotation": _rotation(yaw)},
            }
            for parent, child, x, y, yaw in poses
        ]
    }


def scene(time_ns: int, boxes: list[Box]) -> Message:
    """Return a `foxglove_msgs/SceneUpdate` that replaces all earlier boxes by these."""
    return {
        "deletions": [{"timestamp": stamp(time_ns), "type": _DELETE_ALL, "id": ""}],
        "entities": [_entity(time_ns, box) for box in boxes],
    }


def _entity(time_ns: int, box: Box) -> Message:
    x, y, yaw = box.pose_ego.tolist()
    length, width, height = box.size.tolist()
    color = dict(zip("rgba", box.color, strict=True))
    return {
        "timestamp": stamp(time_ns),
        "frame_id": EGO,
        "id": box.id,
        "lifetime": {"sec": 0, "nanosec": 0},
        "frame_locked": False,
        "metadata": [{"key": key, "value": str(value)} for key, value in box.metadata.items()],
        "cubes": [
            {"pose": planar_pose(x, y, 0.5 * height, yaw), "size": vector(length, width, height), "color": color}
        ],
        "texts": [
            {
                "pose": planar_pose(x, y, height + _FONT_M, 0.0),
                "billboard": True,
                "font_size": _FONT_M,
                "scale_invariant": False,
                "color": {**color, "a": 1.0},
                "text": box.label,
            }
        ],
        **{name: [] for name in ("arrows", "spheres", "cylinders", "lines", "triangles", "models")},
    }


def planar_pose(x: float, y: float, z: float, yaw: float) -> Message:
    """Return a `geometry_msgs/Pose` turned about z [m, rad]."""
    return {"position": vector(x, y, z), "orientation": _rotation(yaw)}


def vector(x: float, y: float, z: float) -> Message:
    """Return a `geometry_msgs/Vector3` or `Point`."""
    return {"x": x, "y": y, "z": z}


def _rotation(yaw: float) -> Message:
    """Return a quaternion about the z axis."""
    return {"x": 0.0, "y": 0.0, "z": float(np.sin(0.5 * yaw)), "w": float(np.cos(0.5 * yaw))}


OBJECT_FIELDS = {
    "geometry_msgs/PoseWithCovariance": "geometry_msgs/Pose pose, float64[36] covariance",
    "geometry_msgs/Twist": "geometry_msgs/Vector3 linear, geometry_msgs/Vector3 angular",
    "geometry_msgs/TwistWithCovariance": "geometry_msgs/Twist twist, float64[36] covariance",
    "geometry_msgs/Accel": "geometry_msgs/Vector3 linear, geometry_msgs/Vector3 angular",
    "geometry_msgs/AccelWithCovariance": "geometry_msgs/Accel accel, float64[36] covariance",
    "geometry_msgs/Point32": "float32 x, float32 y, float32 z",
    "geometry_msgs/Polygon": "geometry_msgs/Point32[] points",
    "unique_identifier_msgs/UUID": "uint8[16] uuid",
    "vision_msgs/ObjectHypothesis": "string class_id, float64 score",
    "vision_msgs/ObjectHypothesisWithPose": (
        "vision_msgs/ObjectHypothesis hypothesis, geometry_msgs/PoseWithCovariance pose"
    ),
    "vision_msgs/BoundingBox3D": "geometry_msgs/Pose center, geometry_msgs/Vector3 size",
    "vision_msgs/Detection3D": (
        "std_msgs/Header header, vision_msgs/ObjectHypothesisWithPose[] results, vision_msgs/BoundingBox3D bbox, "
        "string id"
    ),
    "vision_msgs/Detection3DArray": "std_msgs/Header header, vision_msgs/Detection3D[] detections",
    "autoware_perception_msgs/ObjectClassification": "uint8 label, float32 probability",
    "autoware_perception_msgs/Shape": ("uint8 type, geometry_msgs/Polygon footprint, geometry_msgs/Vector3 dimensions"),
    "autoware_perception_msgs/TrackedObjectKinematics": (
        "geometry_msgs/PoseWithCovariance pose_with_covariance, "
        "geometry_msgs/TwistWithCovariance twist_with_covariance, "
        "geometry_msgs/AccelWithCovariance acceleration_with_covariance, uint8 orientation_availability, "
        "bool is_stationary"
    ),
    "autoware_perception_msgs/TrackedObject": (
        "unique_identifier_msgs/UUID object_id, float32 existence_probability, "
        "autoware_perception_msgs/ObjectClassification[] classification, "
        "autoware_perception_msgs/TrackedObjectKinematics kinematics, autoware_perception_msgs/Shape shape"
    ),
    "autoware_perception_msgs/TrackedObjects": (
        "std_msgs/Header header, autoware_perception_msgs/TrackedObject[] objects"
    ),
}


_FIELDS = {
    **OBJECT_FIELDS,
    "rosgraph_msgs/Clock": "builtin_interfaces/Time clock",
    "builtin_interfaces/Time": "int32 sec, uint32 nanosec",
    "builtin_interfaces/Duration": "int32 sec, uint32 nanosec",
    "std_msgs/Header": "builtin_interfaces/Time stamp, string frame_id",
    "geometry_msgs/Point": "float64 x, float64 y, float64 z",
    "geometry_msgs/Vector3": "float64 x, float64 y, float64 z",
    "geometry_msgs/Quaternion": "float64 x, float64 y, float64 z, float64 w",
    "geometry_msgs/Pose": "geometry_msgs/Point position, geometry_msgs/Quaternion orientation",
    "geometry_msgs/Transform": "geometry_msgs/Vector3 translation, geometry_msgs/Quaternion rotation",
    "geometry_msgs/TransformStamped": (
        "std_msgs/Header header, string child_frame_id, geometry_msgs/Transform transform"
    ),
    "tf2_msgs/TFMessage": "geometry_msgs/TransformStamped[] transforms",
    "sensor_msgs/PointField": "string name, uint32 offset, uint8 datatype, uint32 count",
    "sensor_msgs/PointCloud2": (
        "std_msgs/Header header, uint32 height, uint32 width, sensor_msgs/PointField[] fields, bool is_bigendian, "
        "uint32 point_step, uint32 row_step, uint8[] data, bool is_dense"
    ),
    "foxglove_msgs/Color": "float64 r, float64 g, float64 b, float64 a",
    "foxglove_msgs/KeyValuePair": "string key, string value",
    "foxglove_msgs/ArrowPrimitive": (
        "geometry_msgs/Pose pose, float64 shaft_length, float64 shaft_diameter, float64 head_length, "
        "float64 head_diameter, foxglove_msgs/Color color"
    ),
    "foxglove_msgs/CubePrimitive": "geometry_msgs/Pose pose, geometry_msgs/Vector3 size, foxglove_msgs/Color color",
    "foxglove_msgs/SpherePrimitive": "geometry_msgs/Pose pose, geometry_msgs/Vector3 size, foxglove_msgs/Color color",
    "foxglove_msgs/CylinderPrimitive": (
        "geometry_msgs/Pose pose, geometry_msgs/Vector3 size, float64 bottom_scale, float64 top_scale, "
        "foxglove_msgs/Color color"
    ),
    "foxglove_msgs/LinePrimitive": (
        "uint8 type, geometry_msgs/Pose pose, float64 thickness, bool scale_invariant, geometry_msgs/Point[] points, "
        "foxglove_msgs/Color color, foxglove_msgs/Color[] colors, uint32[] indices"
    ),
    "foxglove_msgs/TriangleListPrimitive": (
        "geometry_msgs/Pose pose, geometry_msgs/Point[] points, foxglove_msgs/Color color, "
        "foxglove_msgs/Color[] colors, uint32[] indices"
    ),
    "foxglove_msgs/TextPrimitive": (
        "geometry_msgs/Pose pose, bool billboard, float64 font_size, bool scale_invariant, foxglove_msgs/Color color, "
        "string text"
    ),
    "foxglove_msgs/ModelPrimitive": (
        "geometry_msgs/Pose pose, geometry_msgs/Vector3 scale, foxglove_msgs/Color color, bool override_color, "
        "string url, string media_type, uint8[] data"
    ),
    "foxglove_msgs/SceneEntityDeletion": "builtin_interfaces/Time timestamp, uint8 type, string id",
    "foxglove_msgs/SceneEntity": (
        "builtin_interfaces/Time timestamp, string frame_id, string id, builtin_interfaces/Duration lifetime, "
        "bool frame_locked, foxglove_msgs/KeyValuePair[] metadata, foxglove_msgs/ArrowPrimitive[] arrows, "
        "foxglove_msgs/CubePrimitive[] cubes, foxglove_msgs/SpherePrimitive[] spheres, "
        "foxglove_msgs/CylinderPrimitive[] cylinders, foxglove_msgs/LinePrimitive[] lines, "
        "foxglove_msgs/TriangleListPrimitive[] triangles, foxglove_msgs/TextPrimitive[] texts, "
        "foxglove_msgs/ModelPrimitive[] models"
    ),
    "foxglove_msgs/SceneUpdate": (
        "foxglove_msgs/SceneEntityDeletion[] deletions, foxglove_msgs/SceneEntity[] entities"
    ),
}

_SEPARATOR = "=" * 80


def full_name(name: str) -> str:
    """Return `package/msg/Name` for `package/Name`."""
    package, _, message = name.partition("/")
    return f"{package}/msg/{message}"


def definition(name: str) -> str:
    """Return the definition of a message, `package/Name`, followed by those of its parts, in the MCAP format."""
    parts = [_lines(name)]
    needed = _parts_of(name)
    for part in needed:  # the list grows during the iteration
        needed += [further for further in _parts_of(part) if further not in needed]
        parts.append(f"{_SEPARATOR}\nMSG: {part}\n{_lines(part)}")
    return "\n".join(parts)


def _lines(name: str) -> str:
    return _FIELDS[name].replace(", ", "\n")


def _parts_of(name: str) -> list[str]:
    return list(dict.fromkeys(re.findall(r"\w+/\w+", _FIELDS[name])))
