"""Format `mcap`: MCAP files of ROS 2, read by the packages mcap and mcap-ros2-support."""

from collections.abc import Iterator
from contextlib import redirect_stderr, redirect_stdout
from io import StringIO
from pathlib import Path
from typing import TYPE_CHECKING, Any

from luxloop.scenarios.errors import InputError
from luxloop.scenarios.exchange.file_formats import Role
from luxloop.scenarios.offline.mcap.chunks import require_chunks
from luxloop.scenarios.recordings.formats.format_choice import readable
from luxloop.scenarios.recordings.formats.ros_topics import NANOSECONDS, RosTopics

if TYPE_CHECKING:
    from luxloop.scenarios.exchange.box_table import BoxTable
    from luxloop.scenarios.recordings.formats.format_choice import ReadOptions

RECORDING_SUFFIXES = BOX_SUFFIXES = (".mcap",)
EXTRA = "mcap"
"""Extra of luxloop that installs the packages of this format."""
WHAT = "MCAP"
MAGIC = b"\x89MCAP0\r\n"
"""First and last bytes of a file (specification of MCAP, version 0)."""


def open_recording(paths: list[Path], options: "ReadOptions") -> RosTopics:
    """Open one file, or the parts of one recording.

    Raises
    ------
    InputError
        A file is no complete MCAP of ROS 2, or `options.topics` are not in it.
    """
    summaries = {path: _summary(path) for path in paths}
    types, counts = {}, dict[str, int]()
    for summary in summaries.values():
        numbers = summary.statistics.channel_message_counts if summary.statistics else {}
        for number, channel in summary.channels.items():
            schema = summary.schemas.get(channel.schema_id)
            if schema and schema.encoding == "ros2msg":
                types[channel.topic] = schema.name
            counts[channel.topic] = counts.get(channel.topic, 0) + numbers.get(number, 0)

    def messages(topics: list[str]) -> Iterator[tuple[str, float, Any]]:
        for path in sorted(summaries, key=lambda path: _begin_ns(summaries[path])):
            yield from _messages(path, topics)

    return RosTopics.of(str(paths[0]), types, counts, options, messages)


def _summary(path: Path) -> Any:
    from mcap.reader import make_reader

    with readable(path, WHAT), path.open("rb") as file:
        file.seek(max(path.stat().st_size - len(MAGIC), 0))
        whole = file.read() == MAGIC
        file.seek(0)
        if file.read(len(MAGIC)) == MAGIC and not whole:
            raise InputError(f"{path}: ends within the recording; recover it with `mcap recover`")
        file.seek(0)
        summary = make_reader(file, validate_crcs=True).get_summary()
        if summary is None:
            raise InputError(f"{path}: has no summary at its end; make one with `mcap recover`")
        require_chunks(path)
    return summary


def _begin_ns(summary: Any) -> int:
    return int(summary.statistics.message_start_time) if summary.statistics else 0


def _messages(path: Path, topics: list[str]) -> Iterator[tuple[str, float, Any]]:
    from mcap.reader import make_reader
    from mcap_ros2.decoder import DecoderFactory

    with readable(path, WHAT), path.open("rb") as file:
        found = make_reader(file, decoder_factories=[DecoderFactory()]).iter_decoded_messages(topics=topics)
        while (entry := _quietly_next(found)) is not None:
            _, channel, message, decoded = entry
            yield channel.topic, NANOSECONDS * message.log_time, decoded


def shows_boxes(_path: Path, head: bytes) -> bool:
    """Return True for MCAP other than a trace of OSI."""
    from luxloop.scenarios.exchange import osi

    return head.startswith(MAGIC[:5]) and not osi.shows_boxes(_path, head)


def read_boxes(path: Path, role: Role) -> "list[BoxTable]":
    """Return the boxes of one topic. See `BoxFormat`."""
    from luxloop.scenarios.exchange import mcap_boxes

    return mcap_boxes.read(path, role)


def _quietly_next(found: Iterator[Any]) -> Any:
    """Return the next message, None at the end; the parser prints damaged definitions, and raises an error as well."""
    with redirect_stderr(StringIO()), redirect_stdout(StringIO()):
        return next(found, None)
