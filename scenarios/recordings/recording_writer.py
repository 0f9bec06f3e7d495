"""Recorded scans on disk, in the layout of a data set.

- `scans.parquet`, `points.parquet`: as in a data set, without ground truth
- `labels.parquet`: the vehicles with recorded poses; only with these
- `rig.toml` or `rig.json`: the rig file, if the import had one
- `summary.json`, `README.md`
"""

import json
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from luxloop.scenarios.dataset import dataset_columns
from luxloop.scenarios.dataset.dataset_columns import Column, Values, column_tables
from luxloop.scenarios.dataset.dataset_rows import ODOMETRY, POINT, columns_of
from luxloop.scenarios.dataset.writer import close_tables, open_tables
from luxloop.scenarios.errors import InputError
from luxloop.scenarios.files import atomic_file, atomic_folder
from luxloop.scenarios.offline.recorded_scans import require_numbers
from luxloop.tracker.scan import Scan

SCAN_NAMES = ("frame", "time_s", "odom_x_m", "odom_y_m", "odom_yaw_rad", "points")
POINT_NAMES = (
    "frame", "x_ego_m", "y_ego_m", "z_ego_m", "time_offset_s", "unit", "layer", "echo", "echo_pulse_width_m", "flags",
)  # fmt: skip
LABEL_NAMES = (
    "frame", "actor_id", "name", "kind", "x_world_m", "y_world_m", "heading_world_rad", "length_m", "width_m",
    "height_m", "vx_world_mps", "vy_world_mps", "ax_world_mps2", "ay_world_mps2", "yaw_rate_radps", "mode",
)  # fmt: skip


def _chosen(columns: tuple[Column, ...], names: tuple[str, ...]) -> tuple[Column, ...]:
    by_name = {column.name: column for column in columns}
    return tuple(by_name[name] for name in names)


SCANS = _chosen(dataset_columns.SCANS, SCAN_NAMES)
POINTS = _chosen(dataset_columns.POINTS, POINT_NAMES)
LABELS = _chosen(dataset_columns.LABELS, LABEL_NAMES)
FILES = {"scans": SCANS, "points": POINTS, "labels": LABELS}
"""Columns of each file. `labels` exists only for recordings with true poses."""


def readme(text: str, files: dict[str, tuple[Column, ...]]) -> str:
    """Return the README.md of a recording.

    Parameters
    ----------
    text
        Origin of the recording.
    files
        Columns of the files it has.
    """
    parts = [
        "# Recording",
        text,
        "Recorded scans, imported by luxloop, in the layout of its data sets. `summary.json` holds the options of the "
        "import.",
        "Frames of reference: ego (x forward, y left, z up from the ground, at the origin of the odometry poses), and "
        "odometry (the ego frame of the first scan), which the labels call world. Angles are counter-clockwise. Points "
        "are as measured, each at its own time; labels are valid at the time of the frame.",
    ]
    return "\n\n".join([*parts, *column_tables(files)]) + "\n"


SUMMARY = "summary.json"
VERSION = 1
"""Version of the layout, in `summary.json` as `recording`."""
OPTION = "--out"
CONTENTS = {"scans.parquet", "points.parquet", "labels.parquet", "rig.json", SUMMARY, "README.md"}


class RecordingWriter:
    """Writes recorded scans into an existing folder.

    Parameters
    ----------
    folder
        The folder.
    labelled
        True for a recording with true poses, which has labels.
    """

    def __init__(self, folder: Path, *, labelled: bool) -> None:
        self._folder = folder
        self._files = {name: columns for name, columns in FILES.items() if labelled or name != "labels"}
        self._tables = open_tables(folder, self._files)
        self.frames = 0

    def add(self, scan: Scan) -> None:
        """Add the next scan.

        Raises
        ------
        InputError
            A number of it is not finite or not plausible.
        """
        row = {"frame": self.frames, "time_s": scan.time, **columns_of(scan, ODOMETRY), "points": len(scan)}
        self._add("scans", {name: np.array([value]) for name, value in row.items()})
        self._add("points", {"frame": np.full(len(scan), self.frames)} | columns_of(scan, POINT))
        self.frames += 1

    def label(self, labels: Values) -> None:
        """Add the labels of the vehicles of the next scan without labels (`RecordedLabels.rows`); errors as `add`."""
        self._add("labels", labels)

    def _add(self, file: str, values: Values) -> None:
        """Add rows by the rule of the reader, so that nothing is imported that `luxloop track` would refuse."""
        try:
            require_numbers(values)
        except ValueError as error:
            raise InputError(f"scan {self.frames}: {file}.parquet, {error}; the recording is damaged") from error
        self._tables[file].add(values)

    def finish(self, summary: dict[str, Any], text: str) -> None:
        """Write the remaining frames, the summary, and the README with a `text` on the origin."""
        self.close()
        (self._folder / "README.md").write_text(readme(text, self._files), encoding="utf-8")
        document = json.dumps({"recording": VERSION, **summary}, indent=2, ensure_ascii=False, allow_nan=False)
        (self._folder / SUMMARY).write_text(document + "\n", encoding="utf-8")

    def close(self) -> None:
        """Close all files; further calls have no effect."""
        close_tables(self._tables)


@contextmanager
def create(out: Path, *, labelled: bool) -> Iterator[tuple[Path, RecordingWriter]]:
    """Yield a temporary folder and its writer; the folder becomes `out` at the end, or is deleted on any error.

    Raises
    ------
    OutputError
        `out` cannot be written, or holds something else than a recording.
    """
    refuse = partial(atomic_folder.refuse_other_files, marks=[SUMMARY], contents=CONTENTS, what="a recording")
    with atomic_folder.create(out, OPTION, refuse) as folder, atomic_file.writing(out, OPTION):
        writer = RecordingWriter(folder, labelled=labelled)
        try:
            yield folder, writer
        finally:
            with suppress(OSError):  # an open file means an earlier failure; the folder is deleted
                writer.close()
