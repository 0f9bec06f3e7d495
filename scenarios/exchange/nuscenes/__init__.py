"""Format `nuscenes`: tables and tracking results of nuScenes."""

from pathlib import Path
from typing import TYPE_CHECKING

from luxloop.scenarios.exchange.file_formats import Role, is_json

if TYPE_CHECKING:
    from luxloop.scenarios.exchange.box_table import BoxTable
    from luxloop.scenarios.offline.recorded_scans import RecordedRun
    from luxloop.scenarios.recordings.formats.format_choice import ReadOptions
    from luxloop.scenarios.recordings.sweep import DataSet

BOX_SUFFIXES = (".json",)
RECORDING_SUFFIXES = ()


def shows_boxes(path: Path, head: bytes) -> bool:
    """Return True for a folder of tables, and for JSON."""
    from luxloop.scenarios.exchange.nuscenes import nuscenes_reader

    return nuscenes_reader.folder_of_tables(path) is not None if path.is_dir() else is_json(head)


def read_boxes(path: Path, _role: Role) -> "list[BoxTable]":
    """Return the annotations of a folder, or the results of a file. See `BoxFormat`."""
    from luxloop.scenarios.exchange.nuscenes import nuscenes_reader

    return [nuscenes_reader.read_tables(path) if path.is_dir() else nuscenes_reader.read_results(path)]


def open_recording(paths: list[Path], options: "ReadOptions") -> "DataSet":
    """Open a scene with its sweeps. See `RecordingFormat`."""
    from luxloop.scenarios.exchange.nuscenes import nuscenes_sweeps
    from luxloop.scenarios.recordings.formats.format_choice import only_folder

    return nuscenes_sweeps.open_recording(only_folder(paths), options.scene)


def export(run: "RecordedRun", folder: Path) -> None:
    """Write a run as one scene. See `RunFormat`."""
    from luxloop.scenarios.exchange.nuscenes import nuscenes_export

    nuscenes_export.export(run, folder)
