"""Reader of the boxes of an MCAP file that `scenarios.offline.mcap.export` wrote."""

from contextlib import redirect_stderr, redirect_stdout
from io import StringIO
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from scenarios.errors import TracksError

NANOSECOND_S = 1e-9


class FoundBox(NamedTuple):
    """Box of an entity in a scene, in the true ego frame."""

    frame: int
    time_s: float
    id: str
    box: tuple[float, float, float, float, float]
    """x [m], y [m], heading [rad], length [m], width [m]."""
    height_m: float
    metadata: dict[str, str]


def read_boxes(path: Path, topic: str) -> list[FoundBox]:
    """Return all boxes of a topic of scenes, in the order of time.

    Raises
    ------
    TracksError
        The file is no MCAP, is damaged, or has no such topic.
    """
    from mcap.reader import make_reader
    from mcap_ros2.decoder import DecoderFactory

    try:  # the decoder prints about invalid definitions
        with path.open("rb") as stream, redirect_stdout(StringIO()), redirect_stderr(StringIO()):
            reader = make_reader(stream, decoder_factories=[DecoderFactory()])
            summary = reader.get_summary()
            topics = sorted({channel.topic for channel in summary.channels.values()}) if summary else []
            if topic not in topics:
                raise TracksError(f"{path}: no topic {topic}; found {', '.join(topics)[:300] or 'none'}")
            found = []
            for _, _, message, scene in reader.iter_decoded_messages(topics=[topic]):
                time_s = NANOSECOND_S * message.log_time
                found += [_box(message.sequence, time_s, entity) for entity in scene.entities]
    except (TracksError, MemoryError):
        raise
    except Exception as error:  # parsers of damaged files raise the errors of their libraries, such as struct.error
        reason = getattr(error, "strerror", None) or " ".join(str(error).split()) or type(error).__name__
        raise TracksError(f"{path}: cannot be read ({reason}); give an MCAP file of luxloop mcap") from error
    return found


def _box(frame: int, time_s: float, entity: Any) -> FoundBox:
    (cube,) = entity.cubes
    at, turn, size = cube.pose.position, cube.pose.orientation, cube.size
    yaw = float(np.arctan2(2.0 * (turn.w * turn.z + turn.x * turn.y), 1.0 - 2.0 * (turn.y**2 + turn.z**2)))
    metadata = {pair.key: pair.value for pair in entity.metadata}
    return FoundBox(frame, time_s, str(entity.id), (at.x, at.y, yaw, size.x, size.y), size.z, metadata)
