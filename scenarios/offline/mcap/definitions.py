"""Message definitions of ROS 2 and Foxglove that are stored in the MCAP file.

Readers decode messages by the definition in the file, and tools recognise a message by its name, so all fields are
listed in their order.
"""

import re

from luxloop.scenarios.offline.mcap.object_definitions import OBJECT_FIELDS

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
