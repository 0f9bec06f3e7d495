"""Rows of a study on disk, written so that no row is lost if the process is killed.

- `runs.jsonl`: append log of new rows, one per line
- `runs.parquet`: one row per completed run, in the order of the study; written at the end of a sweep
- `earlier.parquet`: rows of runs that are not part of the study (any more): other values, seeds or trackers
- `.earlier.parquet`: the former `earlier.parquet` while both are replaced; a row may be in neither of the new ones then
- `.lock`: lock file, held by the process that writes to the folder
"""

import fcntl
import os
import shutil
from collections.abc import Collection, Iterator, Sequence
from contextlib import contextmanager
from itertools import chain
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, BinaryIO, Self

import pandas as pd
import pyarrow as pa

from luxloop.scenarios.errors import OutputError
from luxloop.scenarios.files import atomic_file
from luxloop.scenarios.study import append_log, row_parts, row_reader
from luxloop.scenarios.study.row_format import RowFormat, RunRow
from luxloop.scenarios.study.row_merge import Merge

RUNS, EARLIER, LOG, LOCK = "runs.parquet", "earlier.parquet", "runs.jsonl", ".lock"
FORMER = ".earlier.parquet"
KNOWN = ("key", "status", "inputs", "seed", "tracker")
"""Columns of earlier rows that are held in memory, with the parameters."""


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
    parts
        Folder or fsspec URL of the Parquet parts that workers wrote, see `row_parts`; default: none.

    Raises
    ------
    OutputError
        The folder holds rows of a study with other parameters, or files that cannot be read.
    """

    def __init__(
        self, folder: Path, parameters: dict[str, list[Any]], own: Collection[str] = (), parts: str | None = None
    ) -> None:
        self._folder = folder
        self._parts = parts
        self.format = RowFormat.of(parameters, own)
        """Columns of the rows."""
        append_log.truncate_partial_line(self._folder / LOG)
        known = (row for batch in self._batches([*KNOWN, *parameters]) for row in batch.to_pylist())
        self.earlier = {row["key"]: row for row in known}
        """Rows of earlier starts by key, without their metrics."""
        self.keys: set[str] = set(self.earlier)
        """Keys of the runs that have a row."""

    @classmethod
    @contextmanager
    def opened(
        cls, folder: Path, parameters: dict[str, list[Any]], own: Collection[str] = (), parts: str | None = None
    ) -> Iterator[Self]:
        """Yield the rows of a folder, locked against other writers; the folder is created if missing.

        Raises
        ------
        OutputError
            Another process writes to the folder, it cannot be created, or as for the class.
        """
        new = not folder.exists()
        with _locked(folder):
            rows = cls(folder, parameters, own, parts)
            try:
                yield rows
            except BaseException:
                if new and not rows.keys:  # nothing to resume
                    shutil.rmtree(folder, ignore_errors=True)
                raise

    def add(self, rows: list[RunRow]) -> None:
        """Append rows to the log and flush them to disk.

        Raises
        ------
        OutputError
            The log cannot be written.
        """
        self.add_lines([row["key"] for row in rows], [self.format.line(row) for row in rows])

    def add_lines(self, keys: Sequence[str], lines: Sequence[str]) -> None:
        """Append lines of `RowFormat.line` to the log and flush them to disk.

        A line is empty if a worker has written the row to a part.

        Raises
        ------
        OutputError
            The log cannot be written.
        """
        try:
            if text := "".join(lines):
                append_log.append(self._folder / LOG, text)
        except OSError as error:
            raise _cannot_write(self._folder, error) from error
        self.keys.update(keys)

    def merge(
        self,
        wanted: Sequence[str],
        taken_over: Collection[str] = (),
        why: str = "",
        columns: Sequence[str] | None = None,
    ) -> pd.DataFrame:
        """Merge log and parts into `runs.parquet`; return the rows of the runs `wanted` (keys), in that order.

        The rows `taken_over` (keys) get `why` as their reason. If a run has several rows, the last one counts. Rows of
        other runs, e.g. of additional seeds of an earlier start, go to `earlier.parquet`. Only these `columns` are
        returned (default: all), so that the memory does not grow with the number of metrics.

        Raises
        ------
        OutputError
            A file cannot be read or written.
        """
        append_log.truncate_partial_line(self._folder / LOG)
        merge = Merge(
            self._keys, self._batches, self.format.schema, {key: at for at, key in enumerate(wanted)},
            set(taken_over), why,
        )  # fmt: skip
        parts = row_parts.paths(self._parts)
        try:
            with (
                atomic_file.create(self._folder / RUNS) as runs,
                atomic_file.create(self._folder / EARLIER) as earlier,
                TemporaryDirectory(prefix=".merge-", dir=self._folder) as buckets,
            ):
                others = merge.write(runs, earlier, Path(buckets))
                for path in (runs, earlier):
                    _flush(path)
                self._keep_former()
            if not others and not (self._folder / FORMER).exists():
                (self._folder / EARLIER).unlink()
            (self._folder / FORMER).unlink(missing_ok=True)
        except OSError as error:
            raise _cannot_write(self._folder, error) from error
        (self._folder / LOG).unlink(missing_ok=True)  # if killed before this, the next merge drops the duplicates
        row_parts.remove(parts)
        found = pd.read_parquet(self._folder / RUNS, columns=None if columns is None else list(columns))
        self.keys = set(pd.read_parquet(self._folder / RUNS, columns=["key"])["key"]) | self._others()
        return found

    def _keep_former(self) -> None:
        """Keep the former `earlier.parquet` until both files are replaced, for the case of a kill in between."""
        if (self._folder / EARLIER).exists():
            (self._folder / FORMER).unlink(missing_ok=True)
            os.link(self._folder / EARLIER, self._folder / FORMER)

    def _others(self) -> set[str]:
        """Return the keys of rows that are not part of the study."""
        return set(chain.from_iterable(row_reader.keys(self._folder / EARLIER)))

    def _files(self) -> list[Path]:
        return [self._folder / name for name in (FORMER, RUNS, EARLIER, LOG)]

    def _batches(self, columns: Sequence[str] | None = None) -> Iterator[pa.Table]:
        """Yield all rows in batches: those of the files, then those of the parts; the last row of a run counts."""
        for path in self._files():
            yield from row_reader.batches(path, self.format.schema, columns)
        yield from row_parts.batches(self._parts, self.format.schema, columns)

    def _keys(self) -> Iterator[list[str]]:
        """Yield the keys of the same rows."""
        for path in self._files():
            yield from row_reader.keys(path)
        yield from row_parts.keys(self._parts)


def _flush(path: Path) -> None:
    with path.open("rb") as file:
        os.fsync(file.fileno())


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


def _cannot_write(folder: Path, error: OSError) -> OutputError:
    return OutputError(
        f"{folder}: cannot write there ({error.strerror or error}); free some space, or choose another --out"
    )
