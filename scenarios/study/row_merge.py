"""Merge of row files into one, in the order of the study, with bounded memory.

The rows go to files of `BUCKET` places each, which are then sorted one after the other.
"""

from collections.abc import Callable, Collection, Iterable, Mapping
from dataclasses import dataclass
from itertools import chain
from pathlib import Path

import numpy as np
import pyarrow as pa

from luxloop.scenarios.arrays import Ints
from luxloop.scenarios.study.row_writer import RowWriter

BUCKET = 4000
"""Rows that are sorted at once, and rows per group of the result: 26 MB with all metrics."""
COMPRESSION = "zstd"
_OPTIONS = pa.ipc.IpcWriteOptions(compression=COMPRESSION)
"""Temporary files are streams: a Parquet writer holds metadata of every column of every batch until its end."""

Keys = Callable[[], Iterable[list[str]]]
"""Yields the keys of all rows in batches; each call starts again."""
Batches = Callable[[], Iterable[pa.Table]]
"""Yields all rows in batches, in the order of their keys; each call starts again."""


@dataclass(frozen=True, slots=True)
class Merge:
    """Rows of the wanted runs in their order, and all other rows."""

    keys: Keys
    batches: Batches
    schema: pa.Schema
    place: Mapping[str, int]
    """Place of each wanted run in the study, by key."""
    taken_over: Collection[str]
    """Keys of the rows that get `why` as their reason."""
    why: str

    def write(self, wanted: Path, others: Path, folder: Path) -> int:
        """Write both files; return the number of other rows.

        If a run has several rows, the last one counts.

        Parameters
        ----------
        wanted, others
            Parquet files to write.
        folder
            Empty folder for temporary files.
        """
        last = self._last()
        row, count, buckets = 0, 0, dict[int, pa.RecordBatchStreamWriter]()
        with RowWriter(others, self.schema, compression=COMPRESSION) as rest:
            for batch in self.batches():
                keys = batch["key"].to_pylist()
                kept = [i for i, key in enumerate(keys) if last[key] == row + i]
                row += len(keys)
                place = np.array([self.place.get(keys[i], -1) for i in kept], dtype=np.int64)
                latest = batch.take(pa.array(kept, pa.int64()))
                if not (place >= 0).all():
                    rest.write_table(latest.filter(place < 0))
                    count += int((place < 0).sum())
                self._distribute(latest, place, buckets, folder)
        for writer in buckets.values():
            writer.close()
        with RowWriter(wanted, self.schema, compression=COMPRESSION) as merged:
            for number in sorted(buckets):
                with pa.ipc.open_stream(_file(folder, number)) as rows:
                    merged.write_table(self._sorted(rows.read_all()))
        return count

    def _last(self) -> dict[str, int]:
        """Return the number of the last row of each run."""
        return {key: number for number, key in enumerate(chain.from_iterable(self.keys()))}

    def _distribute(
        self, rows: pa.Table, place: Ints, buckets: dict[int, pa.RecordBatchStreamWriter], folder: Path
    ) -> None:
        """Append the rows with a place in the study to the files of their buckets."""
        at = rows.schema.get_field_index("index")
        rows = rows.set_column(at, "index", pa.array(place))
        for number in np.unique(place[place >= 0] // BUCKET).tolist():
            if number not in buckets:
                buckets[number] = pa.ipc.new_stream(_file(folder, number), self.schema, options=_OPTIONS)
            buckets[number].write_table(rows.filter(place // BUCKET == number))

    def _sorted(self, rows: pa.Table) -> pa.Table:
        """Return the rows of one bucket in the order of the study, with their reasons."""
        rows = rows.sort_by("index")
        reasons = zip(rows["key"].to_pylist(), rows["why"].to_pylist(), strict=True)
        why = [self.why if key in self.taken_over else reason for key, reason in reasons]
        return rows.set_column(rows.schema.get_field_index("why"), "why", pa.array(why, pa.string()))


def _file(folder: Path, number: int) -> Path:
    return folder / f"{number}.arrows"
