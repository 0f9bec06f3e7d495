"""Recorded scans on disk, in the layout of a data set.

- `scans.parquet`, `points.parquet`: as in a data set, without ground truth
- `labels.parquet`: the vehicles with recorded poses; only with these
- `rig.toml` or `rig.json`: the rig file, if the import had one
- `summary.json`, `README.md`
"""

import json
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

import numpy as np

from luxloop.scenarios.dataset.dataset_columns import Values
from luxloop.scenarios.dataset.writer import close_tables, open_tables
from luxloop.scenarios.errors import OutputError
from luxloop.scenarios.files import atomic_folder
from luxloop.scenarios.recordings.recording_columns import FILES, readme
from luxloop.tracker.scan import Scan

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

    def add(self, scan: Scan, labels: Values | None) -> None:
        """Add the next scan and the labels of its vehicles (`RecordedLabels.rows`), None without labels."""
        pose = dict(zip(("odom_x_m", "odom_y_m", "odom_yaw_rad"), scan.ego_pose_odom, strict=True))
        row = {"frame": self.frames, "time_s": scan.time, **pose, "points": len(scan)}
        self._tables["scans"].add({name: np.array([value]) for name, value in row.items()})
        self._tables["points"].add(
            {
                "frame": np.full(len(scan), self.frames),
                **dict(zip(("x_ego_m", "y_ego_m", "z_ego_m"), scan.points_ego.T, strict=True)),
                "time_offset_s": scan.time_offset,
                "unit": scan.unit,
                "layer": scan.layer,
                "echo": scan.echo,
                "echo_pulse_width_m": scan.echo_pulse_width,
                "flags": scan.flags,
            }
        )
        if labels is not None:
            self._tables["labels"].add(labels)
        self.frames += 1

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
    with atomic_folder.create(out, OPTION, _refuse_other_files) as folder:
        try:
            writer = RecordingWriter(folder, labelled=labelled)
            try:
                yield folder, writer
            finally:
                with suppress(OSError):  # an open file means an earlier failure; the folder is deleted
                    writer.close()
        except OSError as error:
            raise atomic_folder.cannot_write(out, OPTION, error) from error


def _refuse_other_files(out: Path) -> None:
    if out.is_dir():
        names = {path.name for path in out.iterdir()}
        if names and not {SUMMARY} <= names <= CONTENTS:
            raise OutputError(f"{out}: holds other files than those of a recording; choose another with {OPTION}")
    elif out.exists():
        raise OutputError(f"{out}: is a file; choose another folder with {OPTION}")
