"""Rows as Parquet parts, which workers write to a folder or fsspec URL instead of sending them to the scheduler."""

import hashlib
from collections.abc import Collection, Iterator, Sequence
from typing import Any

import pyarrow as pa
import pyarrow.parquet as pq

from scenarios.errors import OutputError
from scenarios.study import row_reader
from scenarios.study.row_format import RowFormat, RunRow

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
            pq.write_table(form.table(rows), file, compression="zstd")
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


def batches(url: str | None, schema: pa.Schema, columns: Collection[str] | None) -> Iterator[pa.Table]:
    """Yield the rows of all parts in batches.

    Raises
    ------
    OutputError
        A part cannot be read, or holds rows of another study.
    """
    for of, path in paths(url):
        filesystem, _ = _filesystem(of)
        with filesystem.open(path, "rb") as file:
            yield from row_reader.batches_of(file, path, schema, None if columns is None else list(columns))


def remove(parts: Collection[tuple[str, str]]) -> None:
    """Remove parts whose rows are merged."""
    for url, path in parts:
        _filesystem(url)[0].rm_file(path)


def _filesystem(url: str) -> tuple[Any, str]:
    import fsspec

    filesystem, folder = fsspec.core.url_to_fs(url)
    return filesystem, str(folder).rstrip("/")
