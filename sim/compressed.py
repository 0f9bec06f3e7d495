"""Files compressed by gzip, with a limit on their expansion.

A few kilobytes may expand to gigabytes of equal bytes. Text of recordings and nets shrinks by gzip to a tenth, and
hardly ever to a fiftieth.
"""

import gzip
import io
import zlib
from pathlib import Path
from typing import Any, BinaryIO, cast

from luxloop.sim.source import TrafficInputError

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
