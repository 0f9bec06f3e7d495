"""Strict reader of rig and unit files: keys that are not read are errors."""

import tomllib
from collections.abc import Callable
from dataclasses import MISSING, Field, dataclass, field, fields
from pathlib import Path
from typing import Any, TypeVar

from luxloop.errors import Error

_Record = TypeVar("_Record")

LARGEST = 1e10
"""Absolute value of a number, in any unit."""
READERS: dict[Any, str] = {
    float: "number", int: "integer", str: "text", tuple[float, ...]: "numbers", tuple[int, ...]: "integers",
}  # fmt: skip
"""Methods of a table that read a field, by the type of the field."""


class RigError(Error):
    """Missing or invalid rig or unit file; the message is one line: file, key, value, remedy."""


def read_table(path: Path) -> "Table":
    """Read a TOML file; raise RigError if that fails."""
    if path.exists() and not (path.is_file() or path.is_dir()):
        raise RigError(f"{path}: is a device or a pipe; give a file")  # it may be read for ever
    try:
        return Table(path, tomllib.loads(path.read_text(encoding="utf-8")))
    except (ValueError, OSError) as error:  # a ValueError also for a number of more than 4300 digits
        raise RigError(f"{path}: not readable as TOML ({error}); correct the file") from error
    except RecursionError as error:
        raise RigError(f"{path}: tables or lists are nested too deeply; remove the innermost") from error


@dataclass(frozen=True, slots=True)
class Table:
    """Table of a file, with its path in the file and the keys read so far.

    The methods that read a key return its value, or the default for a missing key. They raise RigError without either.
    """

    file: Path
    values: dict[str, object]
    path: str = ""
    read: set[str] = field(default_factory=set)

    def record(self, kind: type[_Record], **given: object) -> _Record:
        """Make a record: fields that are not given are read by their types, and have the defaults of the dataclass.

        A key that was not read is an error.
        """
        found = {one.name: self._of_type(one) for one in fields(kind) if one.name not in given}  # type: ignore[arg-type]
        for key in self.values:
            if key not in self.read:
                raise self.error(key, f"unknown key; known here: {', '.join(sorted(self.read))}")
        try:
            return kind(**found, **given)
        except ValueError as error:
            raise RigError(f"{self.file}: {self.path}{error}") from error

    def number(self, key: str, default: float | None = None) -> float:
        """Read a finite number."""
        value = self._value(key, default)
        if not _is_number(value):
            raise self.error(key, f"give a number, at most {LARGEST:g} in size")
        return float(value)  # type: ignore[arg-type]

    def numbers(self, key: str, default: list[float] | None = None) -> tuple[float, ...]:
        """Read a list of finite numbers."""
        value = self._value(key, default)
        if not isinstance(value, list) or not all(map(_is_number, value)):
            raise self.error(key, f"give a list of numbers, at most {LARGEST:g} in size")
        return tuple(float(number) for number in value)

    def integer(self, key: str, default: int | None = None) -> int:
        """Read an integer."""
        value = self._value(key, default)
        if not isinstance(value, int) or not _is_number(value):
            raise self.error(key, "give a whole number")
        return value

    def integers(self, key: str) -> tuple[int, ...]:
        """Read a list of integers."""
        if not all(number.is_integer() for number in self.numbers(key)):
            raise self.error(key, "give a list of whole numbers")
        return tuple(int(number) for number in self.numbers(key))

    def text(self, key: str, default: str | None = None) -> str:
        """Read a string."""
        value = self._value(key, default)
        if not isinstance(value, str):
            raise self.error(key, "give a string in quotes")
        return value

    def table(self, key: str) -> "Table":
        """Read a sub-table."""
        value = self._value(key)
        if not isinstance(value, dict):
            raise self.error(key, f"give a [{key}] table")
        return Table(self.file, value, f"{self.path}{key}.")

    def tables(self, key: str) -> "list[Table]":
        """Read an array of at least one table."""
        value = self._value(key)
        if not isinstance(value, list) or not value or not all(isinstance(row, dict) for row in value):
            raise self.error(key, f"give at least one [[{key}]] table")
        return [Table(self.file, row, f"{self.path}{key}[{i}].") for i, row in enumerate(value)]

    def _of_type(self, one: Field[Any]) -> object:
        read: Callable[..., object] = getattr(self, READERS[one.type])
        return read(one.name) if one.default is MISSING else read(one.name, one.default)

    def error(self, key: str, remedy: str) -> RigError:
        """Return the error for a key, with its value and the remedy."""
        value = repr(self.values[key]) if key in self.values else "missing"
        return RigError(f"{self.file}: {self.path}{key} = {value}: {remedy}")

    def _value(self, key: str, default: object = None) -> object:
        self.read.add(key)
        return self.values.get(key, default)


def _is_number(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and abs(value) <= LARGEST
