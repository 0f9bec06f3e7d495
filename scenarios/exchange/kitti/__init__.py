"""Format `kitti`: labels, results and folders of the KITTI tracking benchmark."""

from pathlib import Path
from typing import TYPE_CHECKING

from luxloop.scenarios.exchange.file_formats import Role, first_line

if TYPE_CHECKING:
    from luxloop.scenarios.exchange.box_table import BoxTable
    from luxloop.scenarios.offline.recorded_scans import RecordedRun
    from luxloop.scenarios.recordings.formats.format_choice import ReadOptions
    from luxloop.scenarios.recordings.sweep import DataSet

BOX_SUFFIXES = (".txt",)
RECORDING_SUFFIXES = ()
FIELDS = 17
"""Fields of a line of labels; results have a score as well."""


def shows_boxes(path: Path, head: bytes) -> bool:
    """Return True for a folder of sequences, and for lines of labels without commas."""
    from luxloop.scenarios.exchange.kitti import kitti_labels

    if path.is_dir():
        return kitti_labels.is_kitti(path)
    line = first_line(head)
    words = line.split()
    return b"," not in line and len(words) >= FIELDS and words[0].lstrip(b"-").isdigit()


def read_boxes(path: Path, role: Role) -> "list[BoxTable]":
    """Return the boxes of a sequence. See `BoxFormat`."""
    from luxloop.scenarios.exchange.kitti import kitti_labels

    return kitti_labels.read_boxes(path, role)


def open_recording(paths: list[Path], options: "ReadOptions") -> "DataSet":
    """Open a sequence with its sweeps. See `RecordingFormat`."""
    from luxloop.scenarios.exchange.kitti import kitti_drive
    from luxloop.scenarios.recordings.formats.format_choice import only_folder

    return kitti_drive.open_recording(only_folder(paths), options.scene, options.rate_hz)


def export(run: "RecordedRun", folder: Path) -> None:
    """Write a run as one sequence. See `RunFormat`."""
    from luxloop.scenarios.exchange.kitti import kitti_export

    kitti_export.export(run, folder)
