"""Rows of a study on disk, written so that no row is lost if the process is killed.

- `runs.jsonl`: append log of new rows, one per line
- `runs.parquet`: one row per completed run, in the order of the study; written at the end of a sweep
- `earlier.parquet`: rows of runs that are not part of the study (any more): other values, seeds or trackers
- `.lock`: lock file, held by the process that writes to the folder
"""

import fcntl
import json
import os
from collections.abc import Collection, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, BinaryIO, Self

import pandas as pd
import pyarrow as pa
import pyarrow.json
import pyarrow.parquet as pq

from scenarios.errors import OutputError
from scenarios.files import atomic_file
from scenarios.grading.metric_names import METRICS
from scenarios.grading.own_metric import PREFIX
from scenarios.study import append_log
from scenarios.study.worker import FIXED_COLUMNS, RunRow

RUNS, EARLIER, LOG, LOCK = "runs.parquet", "earlier.parquet", "runs.jsonl", ".lock"
TYPES = {"index": pa.int64(), "seed": pa.int64(), "frames": pa.int64(), "wall_s": pa.float64()}
"""Types of the fixed columns that hold numbers."""


class RowStore:
    """Rows of one study in one folder, including those of earlier starts; their metrics are not held in memory.

    Parameters
    ----------
    folder
        The folder.
    parameters
        All values of each parameter, by key; each parameter is a column.
    own
        Names of the metrics of the study file, which are columns, too.

    Raises
    ------
    OutputError
        The folder holds rows of a study with other parameters, or files that cannot be read.
    """

    def __init__(self, folder: Path, parameters: dict[str, list[Any]], own: Collection[str] = ()) -> None:
        self._folder = folder
        texts = {key for key, values in parameters.items() if any(isinstance(value, bool | str) for value in values)}
        columns = (*FIXED_COLUMNS[:4], *parameters, *FIXED_COLUMNS[4:], *METRICS, *own)
        self._schema = pa.schema([(name, _type(name, name in texts, name in parameters)) for name in columns])
        append_log.truncate_partial_line(self._folder / LOG)
        earlier = self._read().select(["key", "status", "inputs", "seed", "tracker", *parameters]).to_pylist()
        self.earlier = {row["key"]: row for row in earlier}
        """Rows of earlier starts by key, without their metrics."""
        self.keys: set[str] = set(self.earlier)
        """Keys of the runs that have a row."""

    @classmethod
    @contextmanager
    def opened(cls, folder: Path, parameters: dict[str, list[Any]], own: Collection[str] = ()) -> Iterator[Self]:
        """Yield the rows of a folder, locked against other writers; the folder is created if missing.

        Raises
        ------
        OutputError
            Another process writes to the folder, it cannot be created, or as for the class.
        """
        with _locked(folder):
            yield cls(folder, parameters, own)

    def add(self, rows: list[RunRow]) -> None:
        """Append rows to the log and flush them to disk.

        Raises
        ------
        OutputError
            The log cannot be written.
        """
        lines = [{field.name: _plain(row.get(field.name), field.type) for field in self._schema} for row in rows]
        text = "".join(json.dumps(_without_nulls(line), allow_nan=False) + "\n" for line in lines)
        try:
            append_log.append(self._folder / LOG, text)
        except OSError as error:
            raise _cannot_write(self._folder, error) from error
        self.keys.update(row["key"] for row in rows)

    def merge(self, wanted: list[str], taken_over: Collection[str] = (), why: str = "") -> pd.DataFrame:
        """Merge the log into `runs.parquet`; return the rows of the runs `wanted` (keys), in that order.

        The rows `taken_over` (keys) get `why` as their reason. If a run has several rows, the last one counts. Rows of
        other runs, e.g. of additional seeds of an earlier start, go to `earlier.parquet`.

        Raises
        ------
        OutputError
            A file cannot be read or written.
        """
        append_log.truncate_partial_line(self._folder / LOG)
        table = self._read().to_pandas().drop_duplicates("key", keep="last").set_index("key", drop=False)
        self.keys = set(table.index)  # an interrupt between append and update in `add` leaves keys out
        place = {key: index for index, key in enumerate(wanted) if key in table.index}
        others = table.drop(index=list(place))
        if len(others) or (self._folder / EARLIER).exists():
            self._write(others, EARLIER)
        done = table.loc[list(place)].assign(index=list(place.values()))
        done["why"] = done["why"].mask(done.index.isin(list(taken_over)), why)
        self._write(done, RUNS)
        (self._folder / LOG).unlink(missing_ok=True)  # if killed before this, the next merge drops the duplicates
        return done.reset_index(drop=True)

    def _read(self) -> pa.Table:
        tables = [self._schema.empty_table()]
        for path in (self._folder / RUNS, self._folder / EARLIER, self._folder / LOG):
            if path.is_file() and path.stat().st_size:
                tables.append(self._table(path))
        return pa.concat_tables(tables)

    def _table(self, path: Path) -> pa.Table:
        try:
            if path.suffix == ".jsonl":
                strict = pa.json.ParseOptions(explicit_schema=self._schema, unexpected_field_behavior="error")
                return pa.json.read_json(path, parse_options=strict)
            table = pq.read_table(path)
            if unexpected := sorted(set(table.schema.names) ^ set(self._schema.names)):
                raise OutputError(
                    f"{path}: holds rows of another study or version ({', '.join(unexpected[:3])}); choose a new --out"
                )
            return table.select(self._schema.names).cast(self._schema)
        except pa.ArrowInvalid as error:
            reason = str(error).splitlines()[0]
            raise OutputError(f"{path}: cannot be read as rows of this study ({reason}); choose a new --out") from error

    def _write(self, frame: pd.DataFrame, name: str) -> None:
        """Write a Parquet file atomically."""
        table = pa.Table.from_pandas(frame, self._schema, preserve_index=False)
        try:
            with atomic_file.create(self._folder / name) as partial, partial.open("wb") as file:
                pq.write_table(table, file, compression="zstd")
                file.flush()
                os.fsync(file.fileno())
        except OSError as error:
            raise _cannot_write(self._folder, error) from error


def _locked(folder: Path) -> BinaryIO:
    """Create a folder and return its lock file; the kernel releases the lock when the process ends."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        lock = (folder / LOCK).open("wb")
    except OSError as error:
        raise _cannot_write(folder, error) from error
    try:
        fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError as error:
        lock.close()
        raise OutputError(
            f"{folder}: another sweep is writing to it; wait until it ends, or choose another --out"
        ) from error
    return lock


def _type(name: str, is_text: bool, is_parameter: bool) -> pa.DataType:
    if name in METRICS or (name.startswith(PREFIX) and not is_parameter):
        return pa.float64()
    if is_parameter:
        return pa.string() if is_text else pa.float64()
    return TYPES.get(name, pa.string())


def _plain(value: Any, kind: pa.DataType) -> Any:
    """Return a value as JSON holds it; booleans and numbers of a text column become text."""
    return str(value) if value is not None and pa.types.is_string(kind) else value


def _without_nulls(line: RunRow) -> RunRow:
    return {name: value for name, value in line.items() if value is not None}


def _cannot_write(folder: Path, error: OSError) -> OutputError:
    return OutputError(
        f"{folder}: cannot write there ({error.strerror or error}); free some space, or choose another --out"
    )
