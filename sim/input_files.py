"""Input files of traffic: compression with a limit on the expansion, root elements of XML, rows of CSV, missing files.

A few kilobytes may expand to gigabytes of equal bytes. Text of recordings and nets shrinks by gzip to a tenth, and
hardly ever to a fiftieth.
"""

import gzip
import io
import os
import xml.etree.ElementTree as ET
import zlib
from pathlib import Path
from typing import Any, BinaryIO, cast

from luxloop.sim.source import TrafficInputError


def missing_file(path: Path) -> str:
    """Return why a path that is no file cannot be read, with the remedy. It does not name the path."""
    if os.path.isdir(path):  # noqa: PTH112  Path.is_dir raises for a name that is too long
        return "is a folder; name a file in it"
    return f"no such file in {path.parent}; paths are relative to the scenario file"


FACTOR = 100
"""Largest expansion."""
ALWAYS_BYTES = 16 * 2**20
"""[bytes] Expansion to this size is always accepted."""
DAMAGED = (OSError, EOFError, zlib.error)
"""Errors of a file that is damaged or is not compressed by gzip."""


class _Capped(io.RawIOBase):
    """Raw stream that compares the expanded bytes with those read from the file."""

    def __init__(self, path: Path) -> None:
        super().__init__()
        self._file = path.open("rb")
        self._stream = gzip.GzipFile(fileobj=self._file)
        self._expanded = 0

    def readable(self) -> bool:
        return True

    def readinto(self, buffer: Any, /) -> int:
        part = self._stream.read(len(buffer))
        buffer[: len(part)] = part
        self._expanded += len(part)
        if self._expanded > max(ALWAYS_BYTES, FACTOR * self._file.tell()):
            raise TrafficInputError(f"expands to more than {FACTOR} times its size; give the file without compression")
        return len(part)

    def close(self) -> None:
        self._stream.close()
        self._file.close()
        super().close()


def open_gz(path: Path) -> BinaryIO:
    """Open a file compressed by gzip for reading.

    Raises
    ------
    OSError
        The file cannot be opened.
    TrafficInputError
        By reading: the file expands to more than `FACTOR` times its size. Errors of damaged files are `DAMAGED`.
    """
    return cast(BinaryIO, io.BufferedReader(_Capped(path)))


def open_detected(path: Path) -> BinaryIO:
    """Open a file that may be compressed, detected by its first bytes, as SUMO does.

    Raises
    ------
    OSError
        It cannot be opened.
    """
    with path.open("rb") as stream:
        compressed = stream.read(2) == b"\x1f\x8b"
    return open_gz(path) if compressed else path.open("rb")


NOT_XML = (ET.ParseError, LookupError, ValueError, *DAMAGED)
"""Errors of files that are not XML. Unknown encodings raise LookupError, multi-byte ones ValueError."""


def root_element(path: Path) -> ET.Element:
    """Return the root element of an XML file, without its children.

    Raises
    ------
    TrafficInputError
        It is not XML. The message does not name the file.
    """
    try:
        with open_detected(path) as stream:
            root: ET.Element = next(ET.iterparse(stream, events=("start",)))[1]
    except NOT_XML as error:
        raise TrafficInputError(f"not valid XML: {error}") from error
    return root


def surplus(table: Any) -> str | None:
    """Return the fault and its remedy if the first row has more cells than the header; None if it has not.

    pandas takes the first columns of such a file for the index, which shifts all others, and `index_col=False` would
    drop the last cells. Longer rows further down are errors of pandas itself.

    Parameters
    ----------
    table
        Table as `pandas.read_csv` returns it without an argument on the index.
    """
    import pandas as pd

    if isinstance(table.index, pd.RangeIndex):
        return None
    header = len(table.columns)
    return (
        f"row 1: {table.index.nlevels + header} cells, but the header has {header}; "
        "give each row as many cells as the header, without a comma at the end"
    )
