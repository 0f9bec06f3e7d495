"""Format `mcap`: MCAP files of ROS 2, read by the packages mcap and mcap-ros2-support."""

from collections.abc import Iterator
from contextlib import redirect_stderr, redirect_stdout
from io import StringIO
from pathlib import Path
from typing import TYPE_CHECKING, Any

from luxloop.scenarios.errors import InputError
from luxloop.scenarios.exchange.file_formats import Role
from luxloop.scenarios.recordings.formats.format_choice import readable
from luxloop.scenarios.recordings.formats.ros_topics import NANOSECONDS, RosTopics

if TYPE_CHECKING:
    from luxloop.scenarios.exchange.box_table import BoxTable
    from luxloop.scenarios.recordings.formats.format_choice import ReadOptions

RECORDING_SUFFIXES = BOX_SUFFIXES = (".mcap",)
EXTRA = "mcap"
"""Extra of luxloop that installs the packages of this format."""
WHAT = "MCAP"


def open_recording(paths: list[Path], options: "ReadOptions") -> RosTopics:
    """Open one file.

    Raises
    ------
    InputError
        The file is no complete MCAP of ROS 2, or `options.topics` are not in it.
    """
    from mcap.reader import make_reader

    if len(paths) != 1:
        raise InputError(f"{paths[1]}: give one MCAP file at a time")
    path = paths[0]
    with readable(path, WHAT), path.open("rb") as file:
        summary = make_reader(file, validate_crcs=True).get_summary()
        if summary is None:
            raise InputError(f"{path}: has no summary at its end; it is truncated, recover it with `mcap recover`")
        schemas = {channel.topic: summary.schemas.get(channel.schema_id) for channel in summary.channels.values()}
        types = {topic: schema.name for topic, schema in schemas.items() if schema and schema.encoding == "ros2msg"}
        numbers = summary.statistics.channel_message_counts if summary.statistics else {}
        counts = {channel.topic: numbers.get(number, 0) for number, channel in summary.channels.items()}

    def messages(topics: list[str]) -> Iterator[tuple[str, float, Any]]:
        from mcap_ros2.decoder import DecoderFactory

        with readable(path, WHAT), path.open("rb") as file:
            reader = make_reader(file, decoder_factories=[DecoderFactory()])
            found = reader.iter_decoded_messages(topics=topics)
            while (entry := _quietly_next(found)) is not None:
                _, channel, message, decoded = entry
                yield channel.topic, NANOSECONDS * message.log_time, decoded

    return RosTopics.of(str(path), types, counts, list(options.topics), messages)


def shows_boxes(_path: Path, head: bytes) -> bool:
    """Return True for MCAP other than a trace of OSI."""
    from luxloop.scenarios.exchange import osi

    return head.startswith(b"\x89MCAP") and not osi.shows_boxes(_path, head)


def read_boxes(path: Path, role: Role) -> "list[BoxTable]":
    """Return the boxes of one topic. See `BoxFormat`."""
    from luxloop.scenarios.exchange import mcap_boxes

    return mcap_boxes.read(path, role)


def _quietly_next(found: Iterator[Any]) -> Any:
    """Return the next message, None at the end; the parser prints damaged definitions, and raises an error as well."""
    with redirect_stderr(StringIO()), redirect_stdout(StringIO()):
        return next(found, None)
