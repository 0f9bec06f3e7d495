"""Input files that end: devices and pipes are refused, and Parquet files that expand to many times their size."""

import stat
from pathlib import Path
from typing import Any

from luxloop.scenarios.errors import InputError

CELL_BYTES = 8
"""[bytes] Memory of a cell."""
ALWAYS_BYTES = 2**30
"""[bytes] Tables up to this size are always accepted: constant columns of long runs take hardly any place."""


def require_plain(path: Path) -> None:
    """Raise an InputError for a device, a pipe or a socket, which may be read for ever; a missing file passes."""
    try:
        mode = path.stat().st_mode
    except (OSError, ValueError):
        return
    if not (stat.S_ISREG(mode) or stat.S_ISDIR(mode)):
        raise InputError(f"{path}: is a device or a pipe; give a file")


def open_parquet(path: Path) -> Any:
    """Return the `pyarrow.parquet.ParquetFile` of a path. Equal rows take no place in it: few bytes may be billions.

    Raises
    ------
    InputError
        The path is no file, or expands too much.
    ValueError, OSError
        It is no Parquet file.
    """
    import pyarrow.parquet as pq

    from luxloop.sim.compressed import FACTOR

    require_plain(path)
    file = pq.ParquetFile(path)
    rows, columns = file.metadata.num_rows, file.metadata.num_columns
    if rows * columns * CELL_BYTES > max(ALWAYS_BYTES, FACTOR * path.stat().st_size):
        raise InputError(f"{path}: its {rows} rows expand to more than {FACTOR} times its size; it is damaged")
    return file


def read_parquet(path: Path, columns: list[str] | None = None) -> Any:
    """Return the `pyarrow.Table` of a Parquet file; errors as `open_parquet`."""
    with open_parquet(path) as file:
        return file.read(columns)
