"""Sweeps and poses of ROS messages, and of a recording of their topics, whichever container holds them."""

import re
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from luxloop.scenarios.errors import InputError
from luxloop.scenarios.recordings.formats.point_files import sweep_of_table
from luxloop.scenarios.recordings.sweep import PoseList, Sweep

CLOUD, LASER = "sensor_msgs/PointCloud2", "sensor_msgs/LaserScan"
SWEEPS = (CLOUD, LASER)
ODOMETRY, POSE = "nav_msgs/Odometry", "geometry_msgs/PoseStamped"
POSE_COVARIANCE, TRANSFORM = "geometry_msgs/PoseWithCovarianceStamped", "geometry_msgs/TransformStamped"
TRANSFORMS = "tf2_msgs/TFMessage"
POSES = (ODOMETRY, POSE, POSE_COVARIANCE, TRANSFORM, TRANSFORMS)

FIELD_TYPES = {1: "i1", 2: "u1", 3: "<i2", 4: "<u2", 5: "<i4", 6: "<u4", 7: "<f4", 8: "<f8"}
"""Types of `sensor_msgs/PointField` by their `datatype`."""
NANOSECONDS = 1e-9


def short_type(name: str) -> str:
    """Return `package/Name` of `package/msg/Name`, `package__msg__Name` or `package/Name`."""
    return re.sub(r"(/msg/|__msg__)", "/", name)


def seconds(stamp: Any) -> float:
    """Return the time of a stamp [s]: `sec` and `nanosec` (rosbags and ROS 2), or `secs` and `nsecs`."""
    whole = getattr(stamp, "sec", None)
    if whole is None:
        return float(stamp.secs + NANOSECONDS * stamp.nsecs)
    return float(whole + NANOSECONDS * stamp.nanosec)


def stamp_of(message: Any, logged_s: float) -> float:
    """Return the time of a message's header [s]; drivers without a clock leave it 0, then the time of logging."""
    return seconds(message.header.stamp) or logged_s


def pose_rows(kind: str, message: Any, logged_s: float) -> Iterator[tuple[str, str, tuple[float, float, float, float]]]:
    """Yield frame, body (empty if not named) and time, x, y, yaw of each pose of a message."""
    parts = message.transforms if kind == TRANSFORMS else [message]
    for part in parts:
        if kind in (TRANSFORMS, TRANSFORM):
            place, turn, body = part.transform.translation, part.transform.rotation, part.child_frame_id
        else:
            pose = part.pose if kind == POSE else part.pose.pose
            place, turn, body = pose.position, pose.orientation, getattr(part, "child_frame_id", "")
        row = (stamp_of(part, logged_s), float(place.x), float(place.y), _yaw(turn))
        yield part.header.frame_id.lstrip("/"), body.lstrip("/"), row


def sweep_of(kind: str, message: Any, logged_s: float, unit: int) -> Sweep:
    """Return the points of a `LaserScan` or a `PointCloud2`.

    Raises
    ------
    InputError
        The message contradicts itself, or has no coordinates.
    """
    time = stamp_of(message, logged_s)
    return _laser(message, time, unit) if kind == LASER else sweep_of_table(_table(message), time, unit)


def _laser(message: Any, time: float, unit: int) -> Sweep:
    """Points of a planar scan: range r at angle_min + i angle_increment, i time_increment after the stamp."""
    with np.errstate(invalid="ignore"):  # damaged bytes may be signalling NaNs
        ranges = np.asarray(message.ranges, dtype=np.float64)
    index = np.flatnonzero(np.isfinite(ranges) & (ranges >= message.range_min) & (ranges <= message.range_max))
    angle = message.angle_min + index * message.angle_increment
    points = np.column_stack([ranges[index] * np.cos(angle), ranges[index] * np.sin(angle), np.zeros(len(index))])
    return Sweep(time, unit, points, index.astype(np.float64) * float(message.time_increment))


def _table(message: Any) -> npt.NDArray[np.void]:
    """Return the points (N,) of a PointCloud2 as a structured array."""
    order = ">" if message.is_bigendian else "<"
    fields = [field for field in message.fields if field.count == 1 and field.datatype in FIELD_TYPES]
    layout = np.dtype(
        {
            "names": [field.name for field in fields],
            "formats": [FIELD_TYPES[field.datatype].replace("<", order) for field in fields],
            "offsets": [field.offset for field in fields],
            "itemsize": message.point_step,
        }
    )
    data = np.frombuffer(bytes(message.data), dtype=np.uint8)
    if len(data) != message.row_step * message.height or message.row_step < message.width * message.point_step:
        raise InputError(
            f"a PointCloud2 of {message.width} x {message.height} points holds {len(data)} bytes in rows of "
            f"{message.row_step}; the recording is damaged"
        )
    rows = data.reshape(message.height, -1)[:, : message.width * message.point_step]
    return np.ascontiguousarray(rows).reshape(-1).view(layout)


def _yaw(turn: Any) -> float:
    """Return the yaw of a unit quaternion [rad]."""
    x, y, z, w = turn.x, turn.y, turn.z, turn.w
    return float(np.arctan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z)))


Messages = Callable[[list[str]], Iterable[tuple[str, float, Any]]]
"""Yields topic, time of logging [s] and message of the given topics, in the order of the recording."""


@dataclass(frozen=True, slots=True)
class RosTopics:
    """A recording of ROS topics, as a `RecordingSource`."""

    name: str
    """Name of the recording, for error messages."""
    types: dict[str, str]
    """Message type by topic, `package/Name`."""
    counts: dict[str, int]
    """Number of messages by topic."""
    topics: list[str]
    """Topics of the sweeps; the position of a topic is the number of its LIDAR."""
    messages: Messages

    @classmethod
    def of(
        cls, name: str, types: dict[str, str], counts: dict[str, int], wanted: list[str], messages: Messages
    ) -> "RosTopics":
        """Choose the topics of the sweeps: the wanted ones, or the only one.

        Raises
        ------
        InputError
            A topic does not exist or has no points, or the choice is not clear.
        """
        types = {topic: short_type(kind) for topic, kind in types.items()}
        known = sorted(topic for topic, kind in types.items() if kind in SWEEPS)
        for topic in wanted:
            if topic not in known:
                raise InputError(f"{name}: --topic {topic}: no PointCloud2 or LaserScan there; {_listed(known)}")
        if not wanted and len(known) != 1:
            raise InputError(f"{name}: name a topic of LIDAR points with --topic; {_listed(known)}")
        return cls(name, types, counts, wanted or known, messages)

    @property
    def count(self) -> int | None:
        """Number of messages with points."""
        return sum(self.counts[topic] for topic in self.topics)

    def sweeps(self) -> Iterator[Sweep]:
        """Yield the sweeps of all topics in the order of the recording."""
        for topic, logged_s, message in self.messages(self.topics):
            yield sweep_of(self.types[topic], message, logged_s, self.topics.index(topic))

    def poses(self, name: str) -> PoseList:
        """Return the poses of `TOPIC`, or of the transform `TOPIC:PARENT:CHILD`.

        Raises
        ------
        InputError
            There are no such poses.
        """
        topic, _, frames = name.partition(":")
        parent, _, child = frames.partition(":")
        kind = self.types.get(topic)
        known = sorted(name for name, kind in self.types.items() if kind in POSES)
        if kind not in POSES:
            raise InputError(f"{self.name}: {topic}: no poses there; {_listed(known)}")
        if kind == TRANSFORMS and not child:
            raise InputError(f"{self.name}: {topic}: holds transforms; name one as {topic}:PARENT:CHILD")
        found = PoseList()
        for _, logged_s, message in self.messages([topic]):
            for frame, body, row in pose_rows(kind, message, logged_s):
                if not child or (frame, body) == (parent.lstrip("/"), child.lstrip("/")):
                    found.frame = frame
                    found.rows.append(row)
        if not found.rows:
            raise InputError(f"{self.name}: {name}: has no poses")
        return found


def _listed(topics: list[str]) -> str:
    return f"the recording has {', '.join(topics)}" if topics else "the recording has none"
