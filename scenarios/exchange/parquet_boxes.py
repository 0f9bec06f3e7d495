"""Format `parquet`: boxes in a Parquet file, and recorded scans with the columns of data sets."""

from pathlib import Path
from typing import TYPE_CHECKING

from luxloop.scenarios.exchange.file_formats import Role

if TYPE_CHECKING:
    from luxloop.scenarios.exchange.box_table import BoxTable
    from luxloop.scenarios.recordings.formats.format_choice import ReadOptions
    from luxloop.scenarios.recordings.sweep import DataSet

BOX_SUFFIXES = RECORDING_SUFFIXES = (".parquet",)


def shows_boxes(_path: Path, head: bytes) -> bool:
    """Return True for a file that begins with Parquet's magic number."""
    return head.startswith(b"PAR1")


def read_boxes(path: Path, _role: Role) -> "list[BoxTable]":
    """Return the boxes of a file. See `BoxFormat`."""
    from luxloop.scenarios.exchange import tabular_boxes

    return tabular_boxes.read(path, parquet=True)


def open_recording(paths: list[Path], _options: "ReadOptions") -> "DataSet":
    """Open a file of points. See `RecordingFormat`."""
    from luxloop.scenarios.recordings.formats import parquet_scans

    return parquet_scans.open_recording(paths)
