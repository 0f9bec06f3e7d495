"""The scans and labels of a run as a data set that others can read: Parquet, and a README.md that tells every column.

- `scans.parquet`: a row per frame
- `points.parquet`: a row per point, with its truth
- `labels.parquet`: a row per actor and frame
- `hits.parquet`: a row per actor, frame and unit
- `losses.parquet`: a row per beam without an echo
- `summary.json`: where it comes from, and the paper's table I of it
- `README.md`: what every column means

Frames are written as they come, some at a time: a data set may be larger than memory.
"""

import json
import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from scenarios.dataset.dataset_columns import FILES, Column, Values, readme
from scenarios.dataset.dataset_rows import rows_of
from scenarios.errors import OutputError
from scenarios.files import atomic_folder
from scenarios.grading.frame_grade import FrameGrade
from scenarios.result import Result
from sensor_model.truth import ScanTruth
from sim.world import WorldFrame
from tracker.scan import Scan

OPTION = "--dataset"
"""Of the command line, for complaints."""

FRAMES_AT_ONCE = 64
"""Frames that are gathered before they are written, as a row group of each file."""


class DatasetWriter:
    """Writes a data set into a folder, frame by frame; `option` of the command line chose it, for complaints."""

    def __init__(self, folder: Path, option: str = OPTION) -> None:
        self._folder = folder
        self._option = option
        self._tables = {name: _Table(folder / f"{name}.parquet", columns) for name, columns in FILES.items()}

    def add(self, frame: WorldFrame, scan: Scan, truth: ScanTruth, grade: FrameGrade) -> None:
        """Take in one frame.

        Raises
        ------
        OutputError
            The disk is full, or the like.
        """
        try:
            for name, rows in rows_of(frame, scan, truth, grade).items():
                self._tables[name].add(rows)
        except OSError as error:
            raise atomic_folder.cannot_write(self._folder, self._option, error) from error

    def finish(self, result: Result) -> None:
        """Write what is left of the frames, and the summary of the run.

        Raises
        ------
        OutputError
            As `add`.
        """
        try:
            self.close()
            (self._folder / "README.md").write_text(readme(result), encoding="utf-8")
            text = json.dumps(summary(result), indent=2, ensure_ascii=False, allow_nan=False)
            (self._folder / "summary.json").write_text(text + "\n", encoding="utf-8")
        except OSError as error:
            raise atomic_folder.cannot_write(self._folder, self._option, error) from error

    def close(self) -> None:
        """Close all files; twice is not once too often."""
        for table in self._tables.values():
            table.close()


class _Table:
    """One file, and the frames that are not in it yet."""

    def __init__(self, path: Path, columns: tuple[Column, ...]) -> None:
        self._columns = columns
        self._waiting: list[Values] = []
        self._writer = pq.ParquetWriter(path, pa.schema([column.field for column in columns]), compression="zstd")

    def add(self, values: Values) -> None:
        self._waiting.append(values)
        if len(self._waiting) == FRAMES_AT_ONCE:
            self._flush()

    def close(self) -> None:
        if self._writer.is_open:
            self._flush()
            self._writer.close()

    def _flush(self) -> None:
        frames, self._waiting = self._waiting, []
        if frames:
            arrays = [
                column.array(np.concatenate([frame[column.name] for frame in frames])) for column in self._columns
            ]
            self._writer.write_table(pa.Table.from_arrays(arrays, schema=self._writer.schema))


def summary(result: Result) -> dict[str, Any]:
    """Where a data set comes from and what is in it; `observations` and the like count graded labels."""
    prefix = "dataset."
    return {
        "scenario": result.scenario,
        "description": result.config["description"],
        "seed": result.seed,
        "trace_hash": result.trace_hash,
        "ended_early": result.ended_early,
        "table": {
            name.removeprefix(prefix): metric.value
            for name, metric in result.metrics.items()
            if name.startswith(prefix)
        },
        "grading": result.config["grading"],
        "versions": result.versions,
    }


@contextmanager
def create(out: Path, run: Path) -> Iterator[DatasetWriter]:
    """Give a writer of a data set that appears at `out` as a whole, if nothing fails until its `finish`.

    Raises
    ------
    OutputError
        There is something at `out`, it cannot be written, or it and the folder `run` of the results lie in each other.
    """
    places = [Path(os.path.realpath(folder)) for folder in (out, run)]
    if places[0].is_relative_to(places[1]) or places[1].is_relative_to(places[0]):
        raise OutputError(f"{out}: is in the folder of the run, {run}, or around it; choose another with {OPTION}")
    with atomic_folder.create(out, OPTION, _refuse_what_exists) as folder, write_into(folder, OPTION) as writer:
        yield writer


@contextmanager
def write_into(folder: Path, option: str) -> Iterator[DatasetWriter]:
    """Give a writer into an empty folder, which is somebody else's to keep or to throw away.

    Raises
    ------
    OutputError
        As `DatasetWriter.add`.
    """
    writer = DatasetWriter(folder, option)
    try:
        yield writer
    finally:
        with suppress(OSError):  # files that are still open are thrown away: something failed before `finish`
            writer.close()


def _refuse_what_exists(out: Path) -> None:
    if out.exists():
        raise OutputError(f"{out}: is there already; choose a new folder with {OPTION}")
