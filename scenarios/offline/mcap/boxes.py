"""Reader of boxes in MCAP files of ROS 2 messages: those that `scenarios.offline.mcap.export` wrote, and others.

| message | boxes |
|---|---|
| `foxglove_msgs/SceneUpdate` of luxloop | exactly those of the run, by the numbers in their metadata |
| `autoware_perception_msgs/TrackedObjects` | with velocity, class and existence probability as score |
| `vision_msgs/Detection3DArray` | with the class and score of the first hypothesis |
"""

from collections.abc import Callable, Iterator
from contextlib import redirect_stderr, redirect_stdout
from io import StringIO
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from luxloop.arrays import Floats
from luxloop.scenarios.errors import InputError, TracksError
from luxloop.scenarios.grading.plane_geometry import turned
from luxloop.scenarios.offline.mcap.chunks import require_chunks
from luxloop.scenarios.offline.mcap.objects import HEADING, LABELS, WORLD

NANOSECOND_S = 1e-9
SCENE = "foxglove_msgs/msg/SceneUpdate"
OBJECTS, DETECTIONS = "autoware_perception_msgs/msg/TrackedObjects", "vision_msgs/msg/Detection3DArray"
UNKNOWN = np.full(2, np.nan)

Pose = tuple[float, float, float]


class FoundBox(NamedTuple):
    """Box of a message."""

    frame: int
    time_s: float
    id: str
    frame_id: str
    """Frame of reference of the message."""
    pose: Pose
    """x [m], y [m], heading [rad] in that frame."""
    size: Pose
    """Length, width, height [m]."""
    velocity: Floats
    """(2,) over ground, on the axes of that frame [m/s]; NaN where it is unknown."""
    metadata: dict[str, str]
    """Of boxes of luxloop; else empty."""
    pose_world: Pose | None = None
    """The same in the world frame; of boxes of luxloop."""
    velocity_world: Floats = UNKNOWN
    """(2,) over ground in the world frame [m/s]."""
    kind: str = ""
    score: float = np.nan


def topic_types(path: Path) -> dict[str, str]:
    """Return the message type of each topic.

    Raises
    ------
    TracksError
        The file is no MCAP, or is damaged.
    """

    def types(reader: Any) -> dict[str, str]:
        summary = reader.get_summary()
        channels = summary.channels.values() if summary else ()
        return {channel.topic: summary.schemas[channel.schema_id].name for channel in channels if channel.schema_id}

    found: dict[str, str] = _read(path, types)
    return found


def read_boxes(path: Path, topic: str) -> list[FoundBox]:
    """Return all boxes of a topic of one of the messages above, in the order of time.

    Raises
    ------
    TracksError
        The file is no MCAP, is damaged, or has no such topic.
    """
    types = topic_types(path)
    if topic not in types:
        raise TracksError(f"{path}: no topic {topic}; found {', '.join(sorted(types))[:300] or 'none'}")
    boxes_of = {SCENE: _scene, OBJECTS: _objects, DETECTIONS: _detections}.get(types[topic])
    if boxes_of is None:
        raise TracksError(f"{path}: topic {topic} has messages {types[topic]}, which have no boxes; give another file")

    def read(reader: Any) -> list[FoundBox]:
        decoded = reader.iter_decoded_messages(topics=[topic])
        return [box for _, _, record, message in decoded for box in boxes_of(record, message)]

    found: list[FoundBox] = _read(path, read)
    return found


def _read(path: Path, content: Callable[[Any], Any]) -> Any:
    """Return what `content` reads; an error of a library is one line."""
    from mcap.reader import make_reader
    from mcap_ros2.decoder import DecoderFactory

    try:  # the decoder prints about invalid definitions
        with path.open("rb") as stream, redirect_stdout(StringIO()), redirect_stderr(StringIO()):
            require_chunks(path)
            return content(make_reader(stream, decoder_factories=[DecoderFactory()]))
    except (InputError, MemoryError):
        raise
    except Exception as error:  # parsers of damaged files raise the errors of their libraries, such as struct.error
        reason = getattr(error, "strerror", None) or " ".join(str(error).split()) or type(error).__name__
        raise TracksError(f"{path}: cannot be read ({reason}); give an MCAP file of luxloop mcap") from error


def _scene(record: Any, scene: Any) -> Iterator[FoundBox]:
    for entity in scene.entities:
        (cube,) = entity.cubes
        metadata = {pair.key: pair.value for pair in entity.metadata}
        x, y, heading = _pose(cube.pose)
        pose = (x, y, float(metadata.get(HEADING, heading)))
        world = [float(metadata[key]) for key in WORLD if key in metadata]
        exact = len(world) == len(WORLD)
        velocity_world = np.array(world[3:]) if exact else UNKNOWN
        velocity = turned(velocity_world, pose[2] - world[2]) if exact else UNKNOWN
        yield FoundBox(
            record.sequence, NANOSECOND_S * record.log_time, str(entity.id), entity.frame_id, pose, _size(cube.size),
            velocity, metadata, (world[0], world[1], world[2]) if exact else None, velocity_world,
        )  # fmt: skip


def _objects(record: Any, message: Any) -> Iterator[FoundBox]:
    for found in message.objects:
        pose = _pose(found.kinematics.pose_with_covariance.pose)
        linear = found.kinematics.twist_with_covariance.twist.linear
        best = max(found.classification, key=lambda row: row.probability, default=None)
        label = best.label if best is not None else 0
        yield FoundBox(
            record.sequence, _stamp_s(message.header), bytes(found.object_id.uuid).hex(), message.header.frame_id, pose,
            _size(found.shape.dimensions), turned(np.array([linear.x, linear.y]), pose[2]), {},
            kind=LABELS[label] if label < len(LABELS) else "unknown", score=float(found.existence_probability),
        )  # fmt: skip


def _detections(record: Any, message: Any) -> Iterator[FoundBox]:
    for found in message.detections:
        first = found.results[0].hypothesis if found.results else None
        yield FoundBox(
            record.sequence, _stamp_s(message.header), str(found.id), message.header.frame_id, _pose(found.bbox.center),
            _size(found.bbox.size), UNKNOWN, {}, kind=first.class_id.lower() if first else "",
            score=float(first.score) if first else np.nan,
        )  # fmt: skip


def _stamp_s(header: Any) -> float:
    return float(header.stamp.sec + NANOSECOND_S * header.stamp.nanosec)


def _pose(pose: Any) -> Pose:
    at, turn = pose.position, pose.orientation
    yaw = np.arctan2(2.0 * (turn.w * turn.z + turn.x * turn.y), 1.0 - 2.0 * (turn.y**2 + turn.z**2))
    return at.x, at.y, float(yaw)


def _size(size: Any) -> Pose:
    return size.x, size.y, size.z
