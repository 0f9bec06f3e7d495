"""Reading of rows in batches, so that the memory does not grow with the number of runs."""

import io
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import BinaryIO, Literal

import pyarrow as pa
import pyarrow.json
import pyarrow.parquet as pq

from luxloop.scenarios.errors import OutputError

ROWS_AT_ONCE = 2000
"""Rows of a batch: 13 MB with all metrics."""
BLOCK_BYTES = 16_000_000
"""Size of a block of complete lines of the append log."""
_KEY = pa.schema([("key", pa.string())])


def batches(path: Path, schema: pa.Schema, columns: Sequence[str] | None = None) -> Iterator[pa.Table]:
    """Yield the rows of a file in batches, in their order.

    Parameters
    ----------
    path
        Parquet file or append log (`.jsonl`); a missing or empty one has no rows.
    schema
        Columns of the study.
    columns
        Columns to read; default: all.

    Raises
    ------
    OutputError
        The file cannot be read, or holds rows of another study.
    """
    if not path.is_file() or not path.stat().st_size:
        return
    with path.open("rb") as file:
        yield from batches_of(file, str(path), schema, columns, is_log=path.suffix == ".jsonl")


def batches_of(
    file: BinaryIO, name: str, schema: pa.Schema, columns: Sequence[str] | None, *, is_log: bool = False
) -> Iterator[pa.Table]:
    """Yield the rows of an open file; `name` is for error messages, the other parameters are as for `batches`."""
    wanted = list(columns or schema.names)
    typed = pa.schema([schema.field(column) for column in wanted])
    with _as_rows(name):
        if is_log:
            for block in _blocks(file):
                yield _parsed(block, schema, "error").select(wanted)
        else:
            parquet = pq.ParquetFile(file)
            if unexpected := sorted(set(parquet.schema_arrow.names) ^ set(schema.names)):
                raise OutputError(
                    f"{name}: holds rows of another study or version ({', '.join(unexpected[:3])}); choose a new --out"
                )
            for batch in parquet.iter_batches(ROWS_AT_ONCE, columns=wanted):
                yield pa.Table.from_batches([batch]).select(wanted).cast(typed)


def keys(path: Path) -> Iterator[list[str]]:
    """Yield the keys of the rows of a file in batches; other columns are neither read nor checked, which is faster.

    Raises
    ------
    OutputError
        The file cannot be read.
    """
    if not path.is_file() or not path.stat().st_size:
        return
    with path.open("rb") as file, _as_rows(str(path)):
        if path.suffix == ".jsonl":
            yield from (_parsed(block, _KEY, "ignore")["key"].to_pylist() for block in _blocks(file))
        else:
            found = pq.ParquetFile(file).iter_batches(columns=["key"])
            yield from (batch["key"].to_pylist() for batch in found)


@contextmanager
def _as_rows(name: str) -> Iterator[None]:
    """Raise an OutputError for content that is not as expected."""
    try:
        yield
    except pa.ArrowInvalid as error:
        reason = str(error).splitlines()[0]
        raise OutputError(f"{name}: cannot be read as rows of this study ({reason}); choose a new --out") from error


def _parsed(block: bytes, schema: pa.Schema, unexpected: Literal["error", "ignore"]) -> pa.Table:
    """Return the rows of complete lines as one chunk; with many columns, small chunks take twice the time."""
    whole = pa.json.ReadOptions(block_size=len(block) + 1)
    options = pa.json.ParseOptions(explicit_schema=schema, unexpected_field_behavior=unexpected)
    return pa.json.read_json(io.BytesIO(block), whole, options)


def _blocks(file: BinaryIO) -> Iterator[bytes]:
    """Yield blocks of complete lines."""
    rest = b""
    while block := file.read(BLOCK_BYTES):
        lines, newline, rest_of_block = block.rpartition(b"\n")
        if newline:
            yield rest + lines + newline
            rest = rest_of_block
        else:
            rest += block
    if rest:
        yield rest
