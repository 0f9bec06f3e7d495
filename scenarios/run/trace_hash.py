"""Hash over all records of a run (frames, scans, ground truth, tracks), to compare two runs bit by bit."""

import hashlib
import struct
from dataclasses import fields, is_dataclass
from typing import Any

import numpy as np

from luxloop.sim.world import RARE


class TraceHash:
    """Incremental hash of records; equal hashes mean bit-identical records in the same order."""

    def __init__(self) -> None:
        self._hash = hashlib.blake2b(digest_size=16)

    def add(self, *records: Any) -> None:
        """Hash dataclasses of arrays, numbers, names, tuples of names, None and further dataclasses, field by field.

        An empty field marked `RARE` is left out: a run without such values keeps the hash it had before the field.

        Raises
        ------
        TypeError
            A field is of another type.
        """
        for record in records:
            for field in fields(record):
                value = getattr(record, field.name)
                if not field.metadata.get(RARE) or value:
                    self._add_value(field.name, value)

    def hexdigest(self) -> str:
        """Return the hash as 32 hexadecimal digits."""
        return self._hash.hexdigest()

    def _add_value(self, name: str, value: Any) -> None:
        if is_dataclass(value):
            self.add(value)
        elif isinstance(value, np.ndarray):
            # Name, type and shape separate the fields: bytes that move from one field to the next change the hash.
            self._hash.update(f"{name}{value.dtype.str}{value.shape}".encode())
            self._hash.update(np.ascontiguousarray(value).tobytes())
        elif isinstance(value, int | float):
            self._hash.update(f"{name}{type(value).__name__}".encode() + struct.pack("<d", value))
        elif isinstance(value, tuple) and all(isinstance(entry, str) for entry in value):
            self._hash.update(f"{name}{value}".encode())
        elif isinstance(value, tuple) and all(is_dataclass(entry) for entry in value):
            self.add(*value)
        elif isinstance(value, str):
            self._hash.update(f"{name}{value!r}".encode())
        elif value is None:
            self._hash.update(f"{name}None".encode())
        else:
            raise TypeError(
                f"{name}: cannot hash a {type(value).__name__}; records hold arrays, numbers, names and None"
            )
