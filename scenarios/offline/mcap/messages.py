"""Messages as dictionaries for encoding: point clouds, transforms, and scenes of boxes."""

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from scenarios.arrays import Floats

Message = dict[str, Any]
Color = tuple[float, float, float, float]

ODOM, EGO = "odom", "ego"
"""Frames of reference: odometry (fixed to the ground), and ego (box centre on the ground)."""

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
    count = len(next(iter(columns.values())))
    points = np.empty(count, dtype)
    for name, values in columns.items():
        points[name] = values
    fields = [
        {"name": name, "offset": dtype.fields[name][1], "datatype": _DATATYPE[values.dtype.name], "count": 1}  # type: ignore[index]
        for name, values in columns.items()
    ]
    return {
        "header": header(time_ns, EGO),
        "height": 1,
        "width": count,
        "fields": fields,
        "is_bigendian": False,
        "point_step": dtype.itemsize,
        "row_step": dtype.itemsize * count,
        "data": points.tobytes(),
        "is_dense": all(bool(np.isfinite(columns[axis]).all()) for axis in "xyz"),
    }


def transform(time_ns: int, ego_pose_odom: Floats) -> Message:
    """Return a `tf2_msgs/TFMessage` with the pose of the ego frame in the odometry frame."""
    x, y, yaw = ego_pose_odom.tolist()
    pose = {"translation": _vector(x, y, 0.0), "rotation": _rotation(yaw)}
    return {"transforms": [{"header": header(time_ns, ODOM), "child_frame_id": EGO, "transform": pose}]}


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
        "cubes": [{"pose": _pose(x, y, 0.5 * height, yaw), "size": _vector(length, width, height), "color": color}],
        "texts": [
            {
                "pose": _pose(x, y, height + _FONT_M, 0.0),
                "billboard": True,
                "font_size": _FONT_M,
                "scale_invariant": False,
                "color": {**color, "a": 1.0},
                "text": box.label,
            }
        ],
        **{name: [] for name in ("arrows", "spheres", "cylinders", "lines", "triangles", "models")},
    }


def _pose(x: float, y: float, z: float, yaw: float) -> Message:
    return {"position": _vector(x, y, z), "orientation": _rotation(yaw)}


def _vector(x: float, y: float, z: float) -> Message:
    return {"x": x, "y": y, "z": z}


def _rotation(yaw: float) -> Message:
    """Return a quaternion about the z axis."""
    return {"x": 0.0, "y": 0.0, "z": float(np.sin(0.5 * yaw)), "w": float(np.cos(0.5 * yaw))}
