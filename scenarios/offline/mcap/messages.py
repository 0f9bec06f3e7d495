"""Messages as dictionaries for encoding: point clouds, transforms, and scenes of boxes."""

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from luxloop.scenarios.arrays import Floats
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
