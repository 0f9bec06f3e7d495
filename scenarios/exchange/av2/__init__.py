"""Format `av2`: logs of Argoverse 2."""

from pathlib import Path
from typing import TYPE_CHECKING

from luxloop.scenarios.exchange.file_formats import Role

if TYPE_CHECKING:
    from luxloop.scenarios.exchange.box_table import BoxTable
    from luxloop.scenarios.recordings.formats.format_choice import ReadOptions
    from luxloop.scenarios.recordings.sweep import DataSet

BOX_SUFFIXES = (".feather",)
RECORDING_SUFFIXES = ()


def shows_boxes(path: Path, head: bytes) -> bool:
    """Return True for a log with annotations, and for a file that begins with Feather's magic number."""
    from luxloop.scenarios.exchange.av2 import av2_log

    return (path / av2_log.ANNOTATIONS).is_file() if path.is_dir() else head.startswith(b"ARROW1")


def read_boxes(path: Path, _role: Role) -> "list[BoxTable]":
    """Return the annotations of a log. See `BoxFormat`."""
    from luxloop.scenarios.exchange.av2 import av2_log

    return [av2_log.read_boxes(path / av2_log.ANNOTATIONS if path.is_dir() else path)]


def open_recording(paths: list[Path], options: "ReadOptions") -> "DataSet":
    """Open a log. See `RecordingFormat`."""
    from luxloop.scenarios.exchange.av2 import av2_log
    from luxloop.scenarios.recordings.formats.format_choice import only_folder

    return av2_log.open_recording(only_folder(paths), options.scene)
