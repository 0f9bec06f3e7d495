"""Data set of a run for other programs: scans, labels and ground truth as Parquet, with a README.md.

- `scans.parquet`: a row per frame
- `points.parquet`: a row per point, with its truth
- `labels.parquet`: a row per actor and frame
- `hits.parquet`: a row per actor, frame and unit
- `losses.parquet`: a row per beam without an echo
- `obstacles.parquet`: a row per corner of a static obstacle
- `summary.json`: scenario, seed and versions, and the paper's table I for this run
- `README.md`: description of every column

Frames are written in batches during the run: a data set may be larger than memory.
"""

import json
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from luxloop.scenarios.dataset import dataset_rows
from luxloop.scenarios.dataset.dataset_columns import FILES, Column, Values, readme
from luxloop.scenarios.dataset.dataset_rows import rows_of
from luxloop.scenarios.errors import OutputError
from luxloop.scenarios.files import atomic_file, atomic_folder
from luxloop.scenarios.grading.frame_truth import FrameGrade
from luxloop.scenarios.metrics.definition import filtered
from luxloop.scenarios.metrics.definitions import DEFINITIONS, NO_VIEW, VIEWS
from luxloop.scenarios.result import Result
from luxloop.sensor_model.truth import ScanTruth
from luxloop.sim.world import Obstacles, WorldFrame
from luxloop.tracker.scan import Scan

OPTION = "--dataset"
"""Command-line option, for error messages."""

FRAMES_AT_ONCE = 64
"""Number of frames per row group of each file."""


class DatasetWriter:
    """Writes a data set into a folder, frame by frame.

    Parameters
    ----------
    folder
        Existing folder.
    option
        Command-line option that selects the folder, for error messages.
    """

    def __init__(self, folder: Path, option: str = OPTION) -> None:
        self._folder = folder
        self._option = option
        self._tables = open_tables(folder, FILES)

    def start(self, obstacles: Obstacles) -> None:
        """Write the static obstacles, before the first frame.

        Raises
        ------
        OutputError
            As for `add`.
        """
        with atomic_file.writing(self._folder, self._option):
            dataset_rows.write(self._folder, obstacles)

    def add(self, frame: WorldFrame, scan: Scan, truth: ScanTruth, grade: FrameGrade) -> None:
        """Add one frame.

        Raises
        ------
        OutputError
            A file cannot be written, e.g. because the disk is full.
        """
        with atomic_file.writing(self._folder, self._option):
            for name, rows in rows_of(frame, scan, truth, grade).items():
                self._tables[name].add(rows)

    def finish(self, result: Result) -> None:
        """Write the remaining frames, the README and the summary.

        Raises
        ------
        OutputError
            As for `add`.
        """
        with atomic_file.writing(self._folder, self._option):
            self.close()
            (self._folder / "README.md").write_text(readme(result), encoding="utf-8")
            text = json.dumps(summary(result), indent=2, ensure_ascii=False, allow_nan=False)
            (self._folder / "summary.json").write_text(text + "\n", encoding="utf-8")

    def close(self) -> None:
        """Close all files; further calls have no effect."""
        close_tables(self._tables)


class FrameTable:
    """A Parquet file of a data set, and the frames that are not written yet."""

    def __init__(self, path: Path, columns: tuple[Column, ...]) -> None:
        self._columns = columns
        self._waiting: list[Values] = []
        self._writer = pq.ParquetWriter(path, pa.schema([column.field for column in columns]), compression="zstd")

    def add(self, values: Values) -> None:
        """Add the rows of one frame."""
        self._waiting.append(values)
        if len(self._waiting) == FRAMES_AT_ONCE:
            self._flush()

    def close(self) -> None:
        """Write the remaining frames and close the file; a second call has no effect."""
        if self._writer.is_open:
            try:
                self._flush()
                self._writer.close()
            finally:
                self._writer.is_open = False  # after an error, pyarrow would close it again and print a traceback

    def _flush(self) -> None:
        frames, self._waiting = self._waiting, []
        if frames:
            arrays = [
                column.array(np.concatenate([frame[column.name] for frame in frames])) for column in self._columns
            ]
            self._writer.write_table(pa.Table.from_arrays(arrays, schema=self._writer.schema))


def open_tables(folder: Path, files: Mapping[str, tuple[Column, ...]]) -> dict[str, FrameTable]:
    """Open the files of a data set by name; if one cannot be opened, close the others.

    Raises
    ------
    OSError
        A file cannot be written; Parquet writes the first bytes of a file when it is opened.
    """
    tables: dict[str, FrameTable] = {}
    try:
        for name, columns in files.items():
            tables[name] = FrameTable(folder / f"{name}.parquet", columns)
    except OSError:
        with suppress(OSError):
            close_tables(tables)
        raise
    return tables


def close_tables(tables: Mapping[str, FrameTable]) -> None:
    """Close all files, also after an error of one.

    Raises
    ------
    OSError
        A file cannot be written; the first error.
    """
    errors = []
    for table in tables.values():
        try:
            table.close()
        except OSError as error:
            errors.append(error)
    if errors:
        raise errors[0]


OF_VIEWS = ("dataset.observations", "dataset.share")
TABLE_1 = (
    *(name for name, definition in DEFINITIONS.items() if definition.kind == "dataset" and name != "dataset.share"),
    *(filtered(name, view=view) for view in (*VIEWS.values(), NO_VIEW) for name in OF_VIEWS),
)
"""Metrics of a data set as in the paper's table I."""


def summary(result: Result) -> dict[str, Any]:
    """Return source, size and LIDARs of a data set; counts such as `observations` refer to graded labels."""
    return {
        "scenario": result.scenario,
        "description": result.config["description"],
        "seed": result.seed,
        "trace_hash": result.trace_hash,
        "ended_early": result.ended_early,
        "table": {name.removeprefix("dataset."): result.metrics[name].value for name in TABLE_1},
        "grading": result.config["grading"],
        "lidars": _lidars(result.config["rig"]),
        "versions": result.versions,
    }


def _lidars(rig: dict[str, Any]) -> list[dict[str, Any]]:
    """Return name and position of each LIDAR of a rig in the ego frame [m]; the file gives it from the rear axle."""
    axle_m = rig["rear_axle_x_m"]
    return [
        {"name": unit["name"], "x_ego_m": axle_m + unit["x_m"], "y_ego_m": unit["y_m"], "z_ego_m": unit["z_m"]}
        for unit in rig["mounts"]
    ]


@contextmanager
def create(out: Path, run: Path) -> Iterator[DatasetWriter]:
    """Yield a writer of a data set that is moved to `out` atomically, after its `finish`.

    Raises
    ------
    OutputError
        `out` exists, cannot be written, or contains or is contained in the folder `run` of the results.
    """
    if atomic_folder.overlap(out, run):
        raise OutputError(
            f"{out}: is inside the folder of the run, {run}, or contains it; choose another with {OPTION}"
        )
    refuse = partial(atomic_folder.refuse_existing, option=OPTION)
    with atomic_folder.create(out, OPTION, refuse) as folder, write_into(folder, OPTION) as writer:
        yield writer


@contextmanager
def write_into(folder: Path, option: str) -> Iterator[DatasetWriter]:
    """Yield a writer into an empty folder, which the caller keeps or deletes.

    Raises
    ------
    OutputError
        As for `DatasetWriter.add`.
    """
    with atomic_file.writing(folder, option):
        writer = DatasetWriter(folder, option)
    try:
        yield writer
    finally:
        with suppress(OSError):  # an open file means a failure before `finish`; the caller deletes the folder
            writer.close()
