"""A full disk while rows are written: one error, and nothing on standard error from the collection of the writer."""

import errno
import gc
import io
import os
import sys

import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from luxloop.scenarios.study.row_writer import RowWriter

ROWS = pa.table({"key": [f"{number:x}" for number in range(1000)]})


class Disk(io.RawIOBase):
    """A file on a disk that becomes full."""

    full = False

    def writable(self):
        return True

    def write(self, content):
        if self.full:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        return len(content)


def collected(kind) -> list[str]:
    """Return what is printed when a writer is collected whose last bytes the disk cannot take."""
    printed = []
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(sys, "unraisablehook", lambda found: printed.append(str(found.exc_value)))
        disk = Disk()
        writer = kind(disk, ROWS.schema)
        writer.write_table(ROWS)
        disk.full = True
        del writer
        gc.collect()
    return printed


def test_nothing_is_printed_for_a_file_that_is_open_when_the_disk_is_full():
    """The file of a bucket, when that of another bucket has already failed."""
    assert collected(pq.ParquetWriter) == ["[Errno 28] No space left on device"]
    assert collected(RowWriter) == []


def test_a_close_that_fails_is_an_error_and_the_last():
    disk = Disk()
    writer = RowWriter(disk, ROWS.schema)
    disk.full = True
    with pytest.raises(OSError, match="No space left"):
        writer.close()
    writer.close()


def test_rows_are_written(tmp_path):
    with RowWriter(tmp_path / "rows.parquet", ROWS.schema) as writer:
        writer.write_table(ROWS)
    assert pq.read_table(tmp_path / "rows.parquet").equals(ROWS)
