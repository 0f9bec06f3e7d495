"""Sweeps and poses of ROS messages, and of a recording of their topics, whichever container holds them."""

import re
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from luxloop.scenarios.errors import InputError
from luxloop.scenarios.recordings.formats.format_choice import readable
from luxloop.scenarios.recordings.formats.point_files import sweep_of_table
from luxloop.scenarios.recordings.sweep import PoseList, Sweep

if TYPE_CHECKING:
    from luxloop.scenarios.recordings.formats.format_choice import ReadOptions

CLOUD, LASER = "sensor_msgs/PointCloud2", "sensor_msgs/LaserScan"
LIVOX = ("livox_ros_driver/CustomMsg", "livox_ros_driver2/CustomMsg")
SWEEPS = (CLOUD, LASER, *LIVOX)
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


def sweep_of(kind: str, message: Any, logged_s: float, unit: int, time_unit_s: float | None = None) -> Sweep:
    """Return the points of a `LaserScan`, a `PointCloud2` with times in a unit, or a `CustomMsg` of Livox.

    Raises
    ------
    InputError
        The message contradicts itself, or has no coordinates.
    """
    time = stamp_of(message, logged_s)
    if kind == LASER:
        return _laser(message, time, unit)
    if kind in LIVOX:
        return sweep_of_table(_livox_table(message), time, unit)
    return sweep_of_table(_table(message), time, unit, time_unit_s)


def _laser(message: Any, time: float, unit: int) -> Sweep:
    """Points of a planar scan: range r at angle_min + i angle_increment, i time_increment after the stamp."""
    with np.errstate(invalid="ignore"):  # damaged bytes may be signalling NaNs
        ranges = np.asarray(message.ranges, dtype=np.float64)
    index = np.flatnonzero(np.isfinite(ranges) & (ranges >= message.range_min) & (ranges <= message.range_max))
    if not np.isfinite([message.angle_min, message.angle_increment, message.time_increment]).all():
        raise InputError("a LaserScan has angles or times that are no numbers; the recording is damaged")
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
    if not message.width * message.height and not len(data):
        return np.zeros(0, layout)  # a driver that lost its sensor writes clouds of height 0
    if len(data) != message.row_step * message.height or message.row_step < message.width * message.point_step:
        raise InputError(
            f"a PointCloud2 of {message.width} x {message.height} points holds {len(data)} bytes in rows of "
            f"{message.row_step}; the recording is damaged"
        )
    rows = data.reshape(message.height, -1)[:, : message.width * message.point_step]
    return np.ascontiguousarray(rows).reshape(-1).view(layout)


LIVOX_POINT = np.dtype([("offset_time", "<u4"), ("x", "<f4"), ("y", "<f4"), ("z", "<f4"), ("line", "u1")])
"""Fields of a point of Livox: nanoseconds after `timebase`, coordinates [m], and the number of the laser."""


def _livox_table(message: Any) -> npt.NDArray[np.void]:
    """Return the points (N,) of a Livox CustomMsg as a structured array."""
    names = LIVOX_POINT.names or ()
    return np.array([tuple(getattr(point, name) for name in names) for point in message.points], LIVOX_POINT)


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
    options: "ReadOptions"
    """Clock of the messages, and unit of the times of points."""

    @classmethod
    def of(
        cls,
        name: str,
        types: dict[str, str],
        counts: dict[str, int],
        options: "ReadOptions",
        messages: Messages,
    ) -> "RosTopics":
        """Choose the topics of the sweeps: the wanted ones, or the only one.

        Raises
        ------
        InputError
            A topic does not exist or has no points, or the choice is not clear.
        """
        wanted = list(options.topics)
        types = {topic: short_type(kind) for topic, kind in types.items()}
        known = sorted(topic for topic, kind in types.items() if kind in SWEEPS)
        for topic in wanted:
            if topic not in known:
                raise InputError(f"{name}: --topic {topic}: no {_readable()} there; {_listed(known, types)}")
        if not wanted and not known:
            raise InputError(f"{name}: no topic with {_readable()}; {_listed(known, types)}")
        if not wanted and len(known) != 1:
            raise InputError(f"{name}: name a topic of LIDAR points with --topic; {_listed(known, types)}")
        return cls(name, types, counts, wanted or known, messages, options)

    @property
    def count(self) -> int | None:
        """Number of messages with points."""
        return sum(self.counts[topic] for topic in self.topics)

    def sweeps(self) -> Iterator[Sweep]:
        """Yield the sweeps of all topics in the order of the recording."""
        for topic, logged_s, message in self.messages(self.topics):
            kind, unit = self.types[topic], self.topics.index(topic)
            with readable(Path(self.name), f"{kind} on {topic}"):
                sweep = sweep_of(kind, message, logged_s, unit, self.options.time_unit_s)
            yield replace(sweep, time=logged_s) if self.options.by_log else sweep

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
            raise InputError(f"{self.name}: {topic}: no poses there; {_listed(known, self.types)}")
        if kind == TRANSFORMS and not child:
            raise InputError(f"{self.name}: {topic}: holds transforms; name one as {topic}:PARENT:CHILD")
        found = PoseList()
        for _, logged_s, message in self.messages([topic]):
            with readable(Path(self.name), f"{kind} on {topic}"):
                rows = list(pose_rows(kind, message, logged_s))
            for frame, body, row in rows:
                if not child or (frame, body) == (parent.lstrip("/"), child.lstrip("/")):
                    found.frame = frame
                    found.rows.append((logged_s, *row[1:]) if self.options.by_log else row)
        if not found.rows:
            raise InputError(f"{self.name}: {name}: has no poses")
        return found


def _readable() -> str:
    return "PointCloud2, LaserScan or Livox CustomMsg"


def _listed(topics: list[str], types: dict[str, str]) -> str:
    """Name the topics that fit, or else all topics with their types: packets of a driver need its conversion."""
    if topics:
        return f"the recording has {', '.join(topics)}"
    known = ", ".join(f"{topic} ({kind})" for topic, kind in sorted(types.items()))
    return f"the recording has {known}; convert packets with the sensor's driver" if known else "it has no topics"
