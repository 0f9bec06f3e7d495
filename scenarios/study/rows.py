"""The rows of a study on disk: they are there as soon as they are written, whatever happens to the process after that.

- `runs.parquet`: a row per run, in the order of the study
- `parts/*.parquet`: rows that have not been joined to it yet; each file appears as a whole
"""

import os
import secrets
from pathlib import Path
from typing import Any

import pandas as pd
import pyarrow as pa
import pyarrow.parquet as pq

from scenarios.errors import OutputError
from scenarios.grading.metrics import METRICS
from scenarios.study.task import FIXED_COLUMNS, Row

RUNS, PARTS = "runs.parquet", "parts"
TYPES = {"index": pa.int64(), "seed": pa.int64(), "frames": pa.int64(), "wall_s": pa.float64()}
"""Of the fixed columns that hold numbers."""


class Rows:
    """Rows of one study in one folder; those of an earlier start are taken up. Only their keys are held in memory.

    Parameters
    ----------
    folder
        Where; made if it is not there.
    parameters
        The parameters, each a column, and all their values.

    Raises
    ------
    OutputError
        The folder cannot be written, or holds rows of a study with other parameters.
    """

    def __init__(self, folder: Path, parameters: dict[str, list[Any]]) -> None:
        self._folder = folder
        texts = {key for key, values in parameters.items() if any(isinstance(value, bool | str) for value in values)}
        columns = (*FIXED_COLUMNS[:3], *parameters, *FIXED_COLUMNS[3:], *METRICS)
        self._schema = pa.schema([(name, _type(name, name in texts, name in parameters)) for name in columns])
        try:
            (folder / PARTS).mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise _cannot_write(folder, error) from error
        self.keys: set[str] = set(self._read()["key"].to_pylist())
        """Runs that have a row."""

    def add(self, rows: list[Row]) -> None:
        """Take in rows, and have them on disk before returning."""
        if rows:
            columns = {f.name: [_text(row.get(f.name), f.type) for row in rows] for f in self._schema}
            self._write(pa.table(columns, self._schema), self._folder / PARTS / f"{rows[0]['key']}.parquet")
            self.keys.update(row["key"] for row in rows)

    def join(self, wanted: list[str]) -> pd.DataFrame:
        """Write `runs.parquet` anew, and remove the parts; return the rows of the runs `wanted` (keys), in that order.

        Rows of other runs, as of more seeds in an earlier start, are kept behind them.
        """
        table = self._read().to_pandas().drop_duplicates("key").set_index("key", drop=False)
        done = [key for key in wanted if key in table.index]
        table.loc[done, "index"] = range(len(wanted)) if len(done) == len(wanted) else table.loc[done, "index"]
        ordered = pd.concat([table.loc[done], table.drop(index=done)])
        self._write(pa.Table.from_pandas(ordered, self._schema, preserve_index=False), self._folder / RUNS)
        for part in (self._folder / PARTS).glob("*.parquet"):
            part.unlink()
        return ordered.head(len(done)).reset_index(drop=True)

    def _read(self) -> pa.Table:
        tables = [pa.table({f.name: [] for f in self._schema}, self._schema)]
        for path in [self._folder / RUNS, *sorted((self._folder / PARTS).glob("*.parquet"))]:
            if path.is_file():
                table = pq.read_table(path)
                if table.schema.names != self._schema.names:
                    odd = sorted(set(table.schema.names) ^ set(self._schema.names))
                    raise OutputError(
                        f"{path}: holds rows of another study or version ({', '.join(odd[:3])}); choose a new --out"
                    )
                tables.append(table.cast(self._schema))
        return pa.concat_tables(tables)

    def _write(self, table: pa.Table, path: Path) -> None:
        """Write beside, then rename."""
        partial = path.with_name(f".{path.name}.{os.getpid()}-{secrets.token_hex(4)}")
        try:
            pq.write_table(table, partial, compression="zstd")
            partial.rename(path)
        except OSError as error:
            partial.unlink(missing_ok=True)
            raise _cannot_write(self._folder, error) from error


def _type(name: str, is_text: bool, is_parameter: bool) -> pa.DataType:
    if name in METRICS:
        return pa.float64()
    if is_parameter:
        return pa.string() if is_text else pa.float64()
    return TYPES.get(name, pa.string())


def _text(value: Any, kind: pa.DataType) -> Any:
    """A text column takes a study's true and 3, too."""
    return str(value) if value is not None and pa.types.is_string(kind) else value


def _cannot_write(folder: Path, error: OSError) -> OutputError:
    return OutputError(f"{folder}: cannot write there ({error.strerror}); what is done is kept: make room, start again")
