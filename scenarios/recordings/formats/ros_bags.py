"""Format `rosbag`: bags of ROS 1 (`.bag`) and of ROS 2 (`.db3`, or their folder), read by the package rosbags."""

import bz2
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

from luxloop.scenarios.errors import InputError
from luxloop.scenarios.recordings.formats.format_choice import readable
from luxloop.scenarios.recordings.formats.ros_topics import NANOSECONDS, RosTopics
from luxloop.sim.compressed import ALWAYS_BYTES, FACTOR

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
            _limit_expansion(reader)
            chosen = [connection for connection in reader.connections if connection.topic in topics]
            for connection, logged_ns, raw in reader.messages(chosen):
                message = reader.deserialize(raw, connection.msgtype)
                yield connection.topic, NANOSECONDS * logged_ns, message

    return RosTopics.of(str(paths[0]), types, counts, options, messages)


def _limit_expansion(reader: Any) -> None:
    """Limit the chunks of bags of ROS 1 that are compressed by bzip2; LZ4 expands to 255 times its size at most."""
    for bag in reader.readers:
        for at, chunk in getattr(bag, "chunks", {}).items():
            if chunk.decompressor is bz2.decompress:
                bag.chunks[at] = chunk._replace(decompressor=_expanded)


def _expanded(packed: bytes) -> bytes:
    """Return the content of a chunk; raise an InputError if it has more than `FACTOR` times its size."""
    stream = bz2.BZ2Decompressor()
    content = stream.decompress(packed, max(ALWAYS_BYTES, FACTOR * len(packed)))
    if not stream.eof:
        raise InputError(f"a chunk is cut off, or expands to more than {FACTOR} times its size; the bag is damaged")
    return content


def _reader(paths: list[Path]) -> Any:
    from rosbags.highlevel import AnyReader
    from rosbags.typesys import Stores, get_typestore

    # Bags of ROS 2 before Iron have no message definitions; the common ones have not changed since Humble.
    return AnyReader(paths, default_typestore=get_typestore(Stores.ROS2_HUMBLE))
