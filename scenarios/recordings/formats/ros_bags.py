"""Format `rosbag`: bags of ROS 1 (`.bag`) and of ROS 2 (`.db3`, or their folder), read by the package rosbags."""

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

from luxloop.scenarios.recordings.formats.format_choice import readable
from luxloop.scenarios.recordings.formats.ros_topics import NANOSECONDS, RosTopics

if TYPE_CHECKING:
    from luxloop.scenarios.recordings.formats.format_choice import ReadOptions

RECORDING_SUFFIXES = (".bag", ".db3", "folder")
EXTRA = "recordings"
"""Extra of luxloop that installs the packages of this format."""
WHAT = "a ROS bag"


def open_recording(paths: list[Path], options: "ReadOptions") -> RosTopics:
    """Open one ROS 2 bag, or one or several ROS 1 bags as one recording.

    Raises
    ------
    InputError
        A file is no complete bag, or `options.topics` are not in it.
    """
    with readable(paths[0], WHAT), _reader(paths) as reader:
        types, counts = {}, dict[str, int]()
        for connection in reader.connections:
            types[connection.topic] = connection.msgtype
            counts[connection.topic] = counts.get(connection.topic, 0) + connection.msgcount

    def messages(topics: list[str]) -> Iterator[tuple[str, float, Any]]:
        with readable(paths[0], WHAT), _reader(paths) as reader:
            chosen = [connection for connection in reader.connections if connection.topic in topics]
            for connection, logged_ns, raw in reader.messages(chosen):
                message = reader.deserialize(raw, connection.msgtype)
                yield connection.topic, NANOSECONDS * logged_ns, message

    return RosTopics.of(str(paths[0]), types, counts, options, messages)


def _reader(paths: list[Path]) -> Any:
    from rosbags.highlevel import AnyReader
    from rosbags.typesys import Stores, get_typestore

    # Bags of ROS 2 before Iron have no message definitions; the common ones have not changed since Humble.
    return AnyReader(paths, default_typestore=get_typestore(Stores.ROS2_HUMBLE))
