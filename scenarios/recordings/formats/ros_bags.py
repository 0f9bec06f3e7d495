"""Format `rosbag`: bags of ROS 1 (`.bag`) and of ROS 2 (`.db3`, or their folder), read by the package rosbags."""

import bz2
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any, BinaryIO

from luxloop.scenarios.errors import InputError
from luxloop.scenarios.files.input_file import require_plain
from luxloop.scenarios.offline.mcap.chunks import require_chunks
from luxloop.scenarios.recordings.formats.format_choice import readable
from luxloop.scenarios.recordings.formats.ros_topics import NANOSECONDS, RosTopics
from luxloop.sim.input_files import ALWAYS_BYTES, FACTOR

if TYPE_CHECKING:
    from luxloop.scenarios.recordings.formats.format_choice import ReadOptions

RECORDING_SUFFIXES = (".bag", ".db3", "folder")
EXTRA = "recordings"
"""Extra of luxloop that installs the packages of this format."""
WHAT = "a ROS bag"
ZSTANDARD = b"\x28\xb5\x2f\xfd"
"""First bytes of a file of Zstandard (RFC 8878)."""
PART_BYTES = 1 << 20
TOO_LARGE = f"a chunk is cut off, or expands to more than {FACTOR} times its size; the bag is damaged"


def open_recording(paths: list[Path], options: "ReadOptions") -> RosTopics:
    """Open one ROS 2 bag, or one or several ROS 1 bags as one recording.

    Raises
    ------
    InputError
        A file is no complete bag, or `options.topics` are not in it.
    """
    with readable(paths[0], WHAT):
        for path in paths:
            _require_files(path)
    with readable(paths[0], WHAT), _reader(paths) as reader:
        types, counts = {}, dict[str, int]()
        for connection in reader.connections:
            types[connection.topic] = connection.msgtype
            counts[connection.topic] = counts.get(connection.topic, 0) + connection.msgcount

    def messages(topics: list[str]) -> Iterator[tuple[str, float, Any]]:
        with readable(paths[0], WHAT), _reader(paths) as reader:
            expand = _limit_expansion(reader)
            chosen = [connection for connection in reader.connections if connection.topic in topics]
            for connection, logged_ns, raw in reader.messages(chosen):
                message = reader.deserialize(expand(raw), connection.msgtype)
                yield connection.topic, NANOSECONDS * logged_ns, message

    return RosTopics.of(str(paths[0]), types, counts, options, messages)


def _require_files(bag: Path) -> None:
    """Check the files of a folder that rosbags expands as a whole: those of Zstandard, and the chunks of MCAP."""
    for path in sorted(bag.iterdir()) if bag.is_dir() else ():
        require_plain(path)
        if path.suffix == ".mcap":
            require_chunks(path)
        elif path.is_file():
            with path.open("rb") as file:
                if file.read(len(ZSTANDARD)) != ZSTANDARD:
                    continue
                file.seek(0)
                _require_expansion(file, path.stat().st_size)


def _require_expansion(file: BinaryIO, packed: int) -> None:
    """Expand a file of Zstandard once, in parts; raise an InputError if it has more than `FACTOR` times its size."""
    import zstandard

    most, expanded = max(ALWAYS_BYTES, FACTOR * packed), 0
    with zstandard.ZstdDecompressor().stream_reader(file, read_across_frames=True) as stream:
        while part := stream.read(PART_BYTES):
            expanded += len(part)
            if expanded > most:
                raise InputError(TOO_LARGE)


def _limit_expansion(reader: Any) -> Callable[[bytes], bytes]:
    """Limit what chunks of ROS 1 and messages of ROS 2 expand to; return the function that expands each message.

    LZ4 expands to 255 times its size at most.
    """
    expand: Callable[[bytes], bytes] = bytes
    for bag in reader.readers:
        for at, chunk in getattr(bag, "chunks", {}).items():
            if chunk.decompressor is bz2.decompress:
                bag.chunks[at] = chunk._replace(decompressor=_expanded)
        metadata = getattr(getattr(bag, "storage", None), "metadata", None)
        if metadata and metadata.compression_mode == "message":
            bag.storage.metadata, expand = metadata._replace(compression_mode=None), _expanded_message
    return expand


def _expanded(packed: bytes) -> bytes:
    """Return the content of a chunk compressed by bzip2; raise an InputError if it is too large."""
    stream = bz2.BZ2Decompressor()
    content = stream.decompress(packed, max(ALWAYS_BYTES, FACTOR * len(packed)))
    if not stream.eof:
        raise InputError(TOO_LARGE)
    return content


def _expanded_message(packed: bytes) -> bytes:
    """Return a message compressed by Zstandard; raise an InputError if it is too large."""
    import zstandard

    most = max(ALWAYS_BYTES, FACTOR * len(packed))
    with zstandard.ZstdDecompressor().stream_reader(packed) as stream:
        content = stream.read(most + 1)
    if len(content) > most:
        raise InputError(TOO_LARGE)
    return content


def _reader(paths: list[Path]) -> Any:
    from rosbags.highlevel import AnyReader
    from rosbags.typesys import Stores, get_typestore

    # Bags of ROS 2 before Iron have no message definitions; the common ones have not changed since Humble.
    return AnyReader(paths, default_typestore=get_typestore(Stores.ROS2_HUMBLE))
