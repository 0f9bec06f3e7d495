"""The rows of a study on disk: they are there as soon as they are written, whatever happens to the process after that.

- `runs.jsonl`: rows as they come in, a line each; only ever appended to
- `runs.parquet`: when a sweep ends, a row per run of the study that is done, in the order of the study
- `earlier.parquet`: rows of runs that the study does not have (any more): of other values, seeds or trackers
- `.lock`: held by the one process that writes here
"""

import fcntl
import json
import os
from collections.abc import Iterator
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
from scenarios.study import append_log
from scenarios.study.worker import FIXED_COLUMNS, Row

RUNS, EARLIER, JOURNAL, LOCK = "runs.parquet", "earlier.parquet", "runs.jsonl", ".lock"
TYPES = {"index": pa.int64(), "seed": pa.int64(), "frames": pa.int64(), "wall_s": pa.float64()}
"""Of the fixed columns that hold numbers."""


class Rows:
    """Rows of one study in one folder; those of an earlier start are taken up. Only their keys are held in memory.

    Parameters
    ----------
    folder
        Where.
    parameters
        The parameters, each a column, and all their values.

    Raises
    ------
    OutputError
        The folder holds rows of a study with other parameters, or files that cannot be read.
    """

    def __init__(self, folder: Path, parameters: dict[str, list[Any]]) -> None:
        self._folder = folder
        texts = {key for key, values in parameters.items() if any(isinstance(value, bool | str) for value in values)}
        columns = (*FIXED_COLUMNS[:4], *parameters, *FIXED_COLUMNS[4:], *METRICS)
        self._schema = pa.schema([(name, _type(name, name in texts, name in parameters)) for name in columns])
        append_log.forget_a_torn_line(self._folder / JOURNAL)
        self.keys: set[str] = set(self._read()["key"].to_pylist())
        """Runs that have a row."""

    @classmethod
    @contextmanager
    def opened(cls, folder: Path, parameters: dict[str, list[Any]]) -> Iterator[Self]:
        """Give the rows in a folder, which is made if it is not there; nobody else can write there meanwhile.

        Raises
        ------
        OutputError
            Somebody else writes there, the folder cannot be made, or as the class says.
        """
        with _locked(folder):
            yield cls(folder, parameters)

    def add(self, rows: list[Row]) -> None:
        """Take in rows, and have them on disk before returning."""
        lines = [{field.name: _plain(row.get(field.name), field.type) for field in self._schema} for row in rows]
        text = "".join(json.dumps(_without_nulls(line), allow_nan=False) + "\n" for line in lines)
        try:
            append_log.append(self._folder / JOURNAL, text)
        except OSError as error:
            raise _cannot_write(self._folder, error) from error
        self.keys.update(row["key"] for row in rows)

    def join(self, wanted: list[str]) -> pd.DataFrame:
        """Write `runs.parquet` anew, and empty the journal; return the rows of the runs `wanted` (keys), in that order.

        Rows of other runs, as of more seeds in an earlier start, go to `earlier.parquet`.
        """
        append_log.forget_a_torn_line(self._folder / JOURNAL)
        table = self._read().to_pandas().drop_duplicates("key").set_index("key", drop=False)
        self.keys = set(
            table.index
        )  # Ctrl-C may have come between the writing of rows and the taking down of their keys
        place = {key: index for index, key in enumerate(wanted) if key in table.index}
        others = table.drop(index=list(place))
        if len(others) or (self._folder / EARLIER).exists():
            self._write(others, EARLIER)
        done = table.loc[list(place)].assign(index=list(place.values()))
        self._write(done, RUNS)
        (self._folder / JOURNAL).unlink(missing_ok=True)  # whoever is killed before this drops the doubles next time
        return done.reset_index(drop=True)

    def _read(self) -> pa.Table:
        tables = [self._schema.empty_table()]
        for path in (self._folder / RUNS, self._folder / EARLIER, self._folder / JOURNAL):
            if path.is_file() and path.stat().st_size:
                tables.append(self._table(path))
        return pa.concat_tables(tables)

    def _table(self, path: Path) -> pa.Table:
        try:
            if path.suffix == ".jsonl":
                strict = pa.json.ParseOptions(explicit_schema=self._schema, unexpected_field_behavior="error")
                return pa.json.read_json(path, parse_options=strict)
            table = pq.read_table(path)
            if odd := sorted(set(table.schema.names) ^ set(self._schema.names)):
                raise OutputError(
                    f"{path}: holds rows of another study or version ({', '.join(odd[:3])}); choose a new --out"
                )
            return table.select(self._schema.names).cast(self._schema)
        except pa.ArrowInvalid as error:
            told = str(error).splitlines()[0]
            raise OutputError(f"{path}: cannot be read as rows of this study ({told}); choose a new --out") from error

    def _write(self, frame: pd.DataFrame, name: str) -> None:
        """Write beside, then rename."""
        table = pa.Table.from_pandas(frame, self._schema, preserve_index=False)
        try:
            with atomic_file.create(self._folder / name) as partial, partial.open("wb") as file:
                pq.write_table(table, file, compression="zstd")
                file.flush()
                os.fsync(file.fileno())
        except OSError as error:
            raise _cannot_write(self._folder, error) from error


def _locked(folder: Path) -> BinaryIO:
    """Make a folder and return its lock; the kernel lets go of it when the process ends, however it does."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        lock = (folder / LOCK).open("wb")
    except OSError as error:
        raise _cannot_write(folder, error) from error
    try:
        fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError as error:
        lock.close()
        raise OutputError(f"{folder}: another sweep writes there now; wait for it, or choose another --out") from error
    return lock


def _type(name: str, is_text: bool, is_parameter: bool) -> pa.DataType:
    if name in METRICS:
        return pa.float64()
    if is_parameter:
        return pa.string() if is_text else pa.float64()
    return TYPES.get(name, pa.string())


def _plain(value: Any, kind: pa.DataType) -> Any:
    """A text column takes a study's true and 3, too."""
    return str(value) if value is not None and pa.types.is_string(kind) else value


def _without_nulls(line: Row) -> Row:
    return {name: value for name, value in line.items() if value is not None}


def _cannot_write(folder: Path, error: OSError) -> OutputError:
    return OutputError(f"{folder}: cannot write there ({error.strerror or error}); make room, or choose another --out")
