"""Rows of runs: one SQLite file in the output folder while they come in, one Parquet file at the end.

A row is a key and two JSON objects, its facts and its metrics. Metrics stay text until the Parquet file is written: to
insert each of some hundred values as a row of its own takes eight times the processor time.

- `runs.sqlite`: all rows, also those of runs that are no longer part of the study
- `runs.parquet`: the rows of the study in its order, a column per metric
- `.lock`: lock file, held by the process that writes to the folder
"""

import fcntl
import io
import json
import os
import shutil
import sqlite3
from collections.abc import Collection, Iterator, Mapping, Sequence
from contextlib import closing, contextmanager
from pathlib import Path
from typing import Any, BinaryIO, Self

import pyarrow as pa
import pyarrow.json
import pyarrow.parquet as pq

from luxloop.scenarios.errors import OutputError, StudyError
from luxloop.scenarios.files import atomic_file
from luxloop.scenarios.metrics.definitions import DEFINITIONS, standard_names
from luxloop.scenarios.metrics.own_metric import PREFIX

RunRow = dict[str, Any]
"""`index`, `key`, `seed`, `tracker`, the parameters by their keys, `status`, `error`, `trace_hash`, `frames`, `wall_s`,
`why` the run was executed or its row taken over, the digests of its `inputs`, and the value of every metric by its
name; a metric without a value may be missing."""
RowText = tuple[str, str, str]
"""Key, facts and metrics of a row, the latter two as JSON: cheaper to send between processes than a dictionary."""

ROWS, TABLE, LOCK = "runs.sqlite", "runs.parquet", ".lock"
FORMER = ("runs.jsonl", "answers.jsonl", "rows", TABLE)
"""Rows of luxloop 0.1, which had no SQLite file."""
FIXED_COLUMNS = (
    *("index", "key", "seed", "tracker"),
    *("status", "error", "trace_hash", "frames", "wall_s", "why", "inputs"),
)
NUMBERS = {"index": pa.int64(), "seed": pa.int64(), "frames": pa.int64(), "wall_s": pa.float64()}
"""Types of the fixed columns that hold numbers."""
ROWS_AT_ONCE = 2000
"""Rows that are held in memory while the Parquet file is written: 28 MB of text, and as much in columns."""
PATIENCE_S = 60.0
"""[s] Longest wait for a program that reads the SQLite file."""
UNREADABLE = (sqlite3.SQLITE_ERROR, sqlite3.SQLITE_CORRUPT, sqlite3.SQLITE_NOTADB)
"""Codes of a file that is damaged, or of another program."""
LOCAL = frozenset({"bcachefs", "btrfs", "ext2", "ext3", "ext4", "f2fs", "jfs", "overlay", "tmpfs", "xfs", "zfs"})
"""File systems of one computer, on which a write-ahead log is safe: its index is shared memory."""


def as_text(row: RunRow) -> RowText:
    """Return a row as text; metrics without a value are left out."""
    metrics = {name: value for name, value in row.items() if _is_metric(name)}
    facts = {name: value for name, value in row.items() if name not in metrics}
    known = {name: value for name, value in metrics.items() if value is not None}
    return row["key"], json.dumps(facts, allow_nan=False), json.dumps(known, allow_nan=False)


def as_row(text: RowText) -> RunRow:
    """Return a row from its text."""
    row: RunRow = json.loads(text[1]) | json.loads(text[2])
    return row


METRICS = tuple(standard_names())
"""Metrics that every row holds."""


def schema_of(parameters: Mapping[str, Sequence[Any]], further: Collection[str] = ()) -> pa.Schema:
    """Return the columns of the Parquet file.

    Parameters
    ----------
    parameters
        All values of each parameter, by key; a column holds text if there is a text or boolean among them.
    further
        Metrics of the study file: its own ones, and those with filters.

    Raises
    ------
    StudyError
        A parameter has the name of another column.
    """
    if taken := sorted({*parameters} & {*FIXED_COLUMNS, *METRICS}):
        raise StudyError(f"{taken[0]}: rows have a column of this name; give the parameter another key")
    columns = {name: NUMBERS.get(name, pa.string()) for name in FIXED_COLUMNS[:4]}
    for key, values in parameters.items():
        columns[key] = pa.string() if any(isinstance(value, bool | str) for value in values) else pa.float64()
    columns |= {name: NUMBERS.get(name, pa.string()) for name in FIXED_COLUMNS[4:]}
    return pa.schema(columns | dict.fromkeys((*METRICS, *further), pa.float64()))


class RowStore:
    """Rows in one folder, including those of earlier starts; made by `opened`."""

    def __init__(self, folder: Path, database: sqlite3.Connection) -> None:
        self._folder, self._database = folder, database
        self.keys: set[str] = {key for (key,) in self._selected("SELECT key FROM runs")}
        """Keys of the runs that have a row."""

    @classmethod
    @contextmanager
    def opened(cls, folder: Path, columns: Collection[str] = ()) -> Iterator[Self]:
        """Yield the rows of a folder, locked against other writers; the folder is created if missing.

        Parameters
        ----------
        folder
            The folder.
        columns
            Names of the facts besides `FIXED_COLUMNS`: the parameters of a study.

        Raises
        ------
        OutputError
            Another process writes to the folder, it cannot be created, or it holds rows with other columns or of an
            earlier version.
        """
        new = not folder.exists()
        with _locked(folder):
            _refuse_former(folder)
            with _connected(folder) as database:
                rows = cls(folder, database)
                rows.check_columns(columns)
                try:
                    yield rows
                except BaseException:
                    if new and not rows.keys:  # nothing to resume
                        shutil.rmtree(folder, ignore_errors=True)
                    raise

    @property
    def path(self) -> Path:
        """Path of the SQLite file."""
        return self._folder / ROWS

    def check_columns(self, columns: Collection[str]) -> None:
        """Raise an OutputError if the rows have other columns."""
        for facts in self.facts():
            if unexpected := sorted(set(facts) - {*FIXED_COLUMNS} ^ {*columns}):
                raise OutputError(
                    f"{self.path}: holds rows of another study ({', '.join(unexpected[:3])}); choose a new --out"
                )
            return  # the rows of a folder have the same columns

    def facts(self) -> Iterator[RunRow]:
        """Yield the rows without their metrics, in the order in which they came in."""
        for (facts,) in self._selected("SELECT facts FROM runs ORDER BY rowid"):
            yield json.loads(facts)

    def rows(self) -> Iterator[RunRow]:
        """Yield the rows, in the order in which they came in."""
        yield from map(as_row, self._selected("SELECT key, facts, metrics FROM runs ORDER BY rowid"))

    def add(self, rows: Sequence[RowText]) -> None:
        """Store rows and flush them to disk; the last row of a run counts.

        Raises
        ------
        OutputError
            The file cannot be written.
        """
        with _as_output_error(self._folder), self._database:
            self._database.executemany("INSERT OR REPLACE INTO runs VALUES (?, ?, ?)", rows)
        self.keys.update(key for key, _, _ in rows)

    def write_table(
        self, schema: pa.Schema, wanted: Sequence[str], taken_over: Collection[str] = (), why: str = ""
    ) -> None:
        """Write the rows of the runs `wanted` (keys) to `runs.parquet`, in that order, in batches.

        Parameters
        ----------
        schema
            Columns, see `schema_of`.
        wanted
            Keys of the runs; those without a row are left out.
        taken_over
            Keys of the rows that get `why` as their reason.
        why
            The reason.

        Raises
        ------
        OutputError
            The file cannot be written.
        """
        places = {key: place for place, key in enumerate(wanted)}
        keys = sorted(places, key=places.__getitem__)
        with (
            _as_output_error(self._folder),
            atomic_file.create(self._folder / TABLE) as partial,
            pq.ParquetWriter(partial, schema, compression="zstd") as table,
        ):
            for first in range(0, len(keys), ROWS_AT_ONCE):
                found = self._texts(keys[first : first + ROWS_AT_ONCE])
                facts = [json.loads(text) | {"index": places[key]} for key, text, _ in found]
                facts = [row | {"why": why} if row["key"] in taken_over else row for row in facts]
                table.write_table(_columns(facts, [metrics for _, _, metrics in found], schema))

    def _texts(self, keys: Sequence[str]) -> list[RowText]:
        """Return the rows of some keys in that order; those without a row are left out."""
        query = "SELECT key, facts, metrics FROM runs WHERE key IN (SELECT value FROM json_each(?))"
        found = {row[0]: row for row in self._selected(query, json.dumps(keys))}
        return [found[key] for key in keys if key in found]

    def _selected(self, query: str, *values: str) -> Iterator[Any]:
        with _as_output_error(self._folder):
            yield from self._database.execute(query, values)


def journal_mode(folder: Path) -> str:
    """Return SQLite's journal for a folder: a write-ahead log on a local disk, else a rollback journal."""
    return "WAL" if file_system(folder) in LOCAL else "DELETE"


def file_system(folder: Path) -> str:
    """Return the type of the file system of a folder; empty if the mounts do not name its device."""
    device = folder.stat().st_dev
    number = f"{os.major(device)}:{os.minor(device)}"
    for line in Path("/proc/self/mountinfo").read_text(encoding="utf-8", errors="replace").splitlines():
        mount, _, source = line.partition(" - ")
        if mount.split()[2] == number:
            return source.split()[0]
    return ""


@contextmanager
def _connected(folder: Path) -> Iterator[sqlite3.Connection]:
    """Open the SQLite file of a folder, and close it, also one that is damaged."""
    with _as_output_error(folder):
        database = sqlite3.connect(folder / ROWS, timeout=PATIENCE_S)
    with closing(database):
        with _as_output_error(folder), database:
            database.execute(f"PRAGMA journal_mode = {journal_mode(folder)}")
            database.execute("PRAGMA synchronous = FULL")
            database.execute("CREATE TABLE IF NOT EXISTS runs (key TEXT PRIMARY KEY, facts TEXT, metrics TEXT)")
        yield database


def _columns(facts: Sequence[RunRow], metrics: Sequence[str], schema: pa.Schema) -> pa.Table:
    """Return rows as columns; metrics that are not in the schema are left out."""
    if not facts:
        return schema.empty_table()
    measured = pa.schema([field for field in schema if _is_metric(field.name)])
    text = "\n".join(metrics).encode()
    # One block: with many columns, small ones take twice the time.
    table = pa.json.read_json(
        io.BytesIO(text),
        pa.json.ReadOptions(block_size=len(text) + 1),
        pa.json.ParseOptions(explicit_schema=measured, unexpected_field_behavior="ignore"),
    )
    for field in schema:
        if not _is_metric(field.name):
            column = [_plain(row.get(field.name), field.type) for row in facts]
            table = table.append_column(field, pa.array(column, field.type))
    return table.select(schema.names)


def _is_metric(name: str) -> bool:
    return name.partition("{")[0] in DEFINITIONS or name.startswith(PREFIX)


def _plain(value: Any, kind: pa.DataType) -> Any:
    """Return a value for a column; booleans and numbers of a text column become text."""
    return str(value) if value is not None and kind == pa.string() else value


@contextmanager
def _locked(folder: Path) -> Iterator[BinaryIO]:
    """Create a folder and yield its lock file; the kernel releases the lock when the process ends."""
    with _as_output_error(folder):
        folder.mkdir(parents=True, exist_ok=True)
        lock = (folder / LOCK).open("wb")
    with lock:
        with _as_output_error(folder):
            _acquire(lock, folder)
        yield lock


def _acquire(lock: BinaryIO, folder: Path) -> None:
    try:
        fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError as error:
        raise OutputError(
            f"{folder}: another command is writing to it; wait until it ends, or choose another --out"
        ) from error


def _refuse_former(folder: Path) -> None:
    """Raise an OutputError if the folder holds rows, but not in SQLite."""
    former = [folder / name for name in FORMER if (folder / name).exists()]
    if former and not (folder / ROWS).exists():
        raise OutputError(
            f"{former[0]}: holds rows that are not in {ROWS}, as luxloop 0.1 wrote them; choose a new --out, or delete "
            "it to run all again"
        )


@contextmanager
def _as_output_error(folder: Path) -> Iterator[None]:
    """Raise an OutputError for errors of the disk and of SQLite."""
    try:
        yield
    except (OSError, sqlite3.DatabaseError) as error:
        if getattr(error, "sqlite_errorcode", None) in UNREADABLE:
            raise OutputError(f"{folder / ROWS}: cannot be read as rows ({error}); choose a new --out") from error
        reason = getattr(error, "strerror", None) or error
        raise OutputError(
            f"{folder}: cannot write there ({reason}); the disk may be full: free some space, or choose another --out"
        ) from error
