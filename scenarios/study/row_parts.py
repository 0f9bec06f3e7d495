"""Rows as Parquet parts, which workers write to a folder or fsspec URL instead of sending them to the scheduler.

A part has the columns `key` and `row`, the line of the append log: opening a Parquet file of a thousand columns takes
longer than parsing a few such lines.
"""

import hashlib
import io
from collections.abc import Collection, Iterator, Sequence
from typing import Any

import pyarrow as pa
import pyarrow.parquet as pq

from luxloop.scenarios.errors import OutputError
from luxloop.scenarios.study import row_reader
from luxloop.scenarios.study.row_format import RowFormat, RunRow

_SCHEMA = pa.schema([("key", pa.string()), ("row", pa.string())])
SUFFIX = ".parquet"
PARTIAL = ".partial"
"""Suffix of a part until it is complete."""


def write(url: str, form: RowFormat, rows: Sequence[RunRow]) -> None:
    """Write the rows of one task as a part; a second attempt of the same task replaces it.

    Raises
    ------
    OutputError
        The part cannot be written.
    """
    try:
        filesystem, folder = _filesystem(url)
        name = hashlib.blake2b("".join(row["key"] for row in rows).encode(), digest_size=12).hexdigest()
        filesystem.makedirs(folder, exist_ok=True)
        with filesystem.open(f"{folder}/{name}{PARTIAL}", "wb") as file:
            part = {"key": [row["key"] for row in rows], "row": [form.line(row) for row in rows]}
            pq.write_table(pa.table(part, _SCHEMA), file, compression="zstd")
        filesystem.mv(f"{folder}/{name}{PARTIAL}", f"{folder}/{name}{SUFFIX}")
    except (OSError, ValueError, ImportError) as error:
        raise OutputError(
            f"--parts {url}: cannot write there ({error}); free some space, or give another URL"
        ) from error


def paths(url: str | None) -> list[tuple[str, str]]:
    """Return the URL and the path of each complete part, sorted.

    Raises
    ------
    OutputError
        The folder cannot be read.
    """
    if url is None:
        return []
    try:
        filesystem, folder = _filesystem(url)
        found = filesystem.glob(f"{folder}/*{SUFFIX}") if filesystem.exists(folder) else []
    except (OSError, ValueError, ImportError) as error:
        raise OutputError(f"--parts {url}: cannot be read ({error}); give another URL") from error
    return [(url, str(path)) for path in sorted(found)]


def batches(url: str | None, schema: pa.Schema, columns: Sequence[str] | None) -> Iterator[pa.Table]:
    """Yield the rows of all parts in batches, for which parts are joined.

    Raises
    ------
    OutputError
        A part cannot be read, or holds rows of another study.
    """
    for block in _joined(_column(url, "row")):
        yield from row_reader.batches_of(io.BytesIO(block), f"--parts {url}", schema, columns, is_log=True)


def keys(url: str | None) -> Iterator[list[str]]:
    """Yield the keys of the rows of each part, in the order of `batches`.

    Raises
    ------
    OutputError
        A part cannot be read.
    """
    return _column(url, "key")


def _column(url: str | None, name: str) -> Iterator[list[str]]:
    """Yield a column of each part."""
    for of, path in paths(url):
        try:
            with _filesystem(of)[0].open(path, "rb") as file:
                part = pq.read_table(file)
        except pa.ArrowInvalid as error:
            raise OutputError(f"{path}: is not a part ({error}); give another URL") from error
        if part.schema != _SCHEMA:
            raise OutputError(f"{path}: is a part of another version of luxloop; give another URL")
        yield part[name].to_pylist()


def _joined(parts: Iterator[list[str]]) -> Iterator[bytes]:
    """Yield the lines of several parts at once: blocks of some MB are parsed faster than small ones."""
    block = bytearray()
    for lines in parts:
        block += "".join(lines).encode()
        if len(block) >= row_reader.BLOCK_BYTES:
            yield bytes(block)
            block.clear()
    if block:
        yield bytes(block)


def remove(parts: Collection[tuple[str, str]]) -> None:
    """Remove parts whose rows are merged."""
    for url, path in parts:
        _filesystem(url)[0].rm_file(path)


def _filesystem(url: str) -> tuple[Any, str]:
    import fsspec

    filesystem, folder = fsspec.core.url_to_fs(url)
    return filesystem, str(folder).rstrip("/")
