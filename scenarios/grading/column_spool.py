"""Columns of a growing table in a temporary file, so that the memory of a run does not grow with its duration."""

import tempfile
import weakref
from typing import IO, Any

import numpy as np
import numpy.typing as npt


class ColumnSpool:
    """Arrays by column name, in the order in which they were added; the file has no name and ends with this object."""

    def __init__(self) -> None:
        self._file: IO[bytes] | None = None
        self._arrays: dict[str, list[tuple[int, int, np.dtype[Any]]]] = {}

    def append(self, name: str, array: npt.NDArray[Any]) -> None:
        """Append an array (rows,) to a column.

        Raises
        ------
        OSError
            The file cannot be written, for instance because the disk is full.
        """
        if self._file is None:
            self._file = tempfile.TemporaryFile()  # noqa: SIM115
            weakref.finalize(self, self._file.close)
        self._arrays.setdefault(name, []).append((self._file.tell(), array.nbytes, array.dtype))
        self._file.write(array.tobytes())

    def column(self, name: str) -> list[npt.NDArray[Any]]:
        """Return the arrays of a column; nothing for a column without any."""
        found = []
        for place, length, dtype in self._arrays.get(name, []):
            assert self._file is not None
            self._file.seek(place)
            found.append(np.frombuffer(self._file.read(length), dtype))
        return found
