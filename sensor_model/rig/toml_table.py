"""Strict reading of rig and unit files: every key is asked for by name, and what was not asked for is an error."""

import tomllib
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import TypeVar

_Record = TypeVar("_Record")


class RigError(Exception):
    """A rig or unit file is missing or wrong; the message is one line: file, key, value, remedy."""


def read_table(path: Path) -> "Table":
    """Read a TOML file; RigError if it is none."""
    try:
        return Table(path, tomllib.loads(path.read_text(encoding="utf-8")))
    except (tomllib.TOMLDecodeError, UnicodeDecodeError, OSError) as error:
        raise RigError(f"{path}: not readable as TOML ({error}); correct the file") from error


@dataclass(frozen=True, slots=True)
class Table:
    """One table of a file. It knows where it stands and which of its keys were asked for.

    What asks for a key returns its value, or the default where the key is left out and there is one, else RigError.
    """

    file: Path
    values: dict[str, object]
    path: str = ""
    asked: set[str] = field(default_factory=set)

    def build(self, record: Callable[..., _Record], **fields: object) -> _Record:
        """Make the record, once it is sure that the table has no keys beyond those asked for."""
        for key in self.values:
            if key not in self.asked:
                raise self.error(key, f"unknown key; known here: {', '.join(sorted(self.asked))}")
        try:
            return record(**fields)
        except ValueError as error:
            raise RigError(f"{self.file}: {self.path}{error}") from error

    def number(self, key: str, default: float | None = None) -> float:
        """Ask for a finite number."""
        value = self._value(key, default)
        if not _is_number(value):
            raise self.error(key, "give a number")
        return float(value)  # type: ignore[arg-type]

    def numbers(self, key: str) -> tuple[float, ...]:
        """Ask for a list of finite numbers."""
        value = self._value(key)
        if not isinstance(value, list) or not all(map(_is_number, value)):
            raise self.error(key, "give a list of numbers")
        return tuple(float(number) for number in value)

    def integer(self, key: str, default: int | None = None) -> int:
        """Ask for a whole number."""
        value = self._value(key, default)
        if not isinstance(value, int) or isinstance(value, bool):
            raise self.error(key, "give a whole number")
        return value

    def integers(self, key: str) -> tuple[int, ...]:
        """Ask for a list of whole numbers."""
        if not all(number.is_integer() for number in self.numbers(key)):
            raise self.error(key, "give a list of whole numbers")
        return tuple(int(number) for number in self.numbers(key))

    def text(self, key: str, default: str | None = None) -> str:
        """Ask for a text."""
        value = self._value(key, default)
        if not isinstance(value, str):
            raise self.error(key, "give a text in quotes")
        return value

    def table(self, key: str) -> "Table":
        """Ask for a table of this table."""
        value = self._value(key)
        if not isinstance(value, dict):
            raise self.error(key, f"give a [{key}] table")
        return Table(self.file, value, f"{self.path}{key}.")

    def tables(self, key: str) -> "list[Table]":
        """Ask for an array of at least one table."""
        value = self._value(key)
        if not isinstance(value, list) or not value or not all(isinstance(row, dict) for row in value):
            raise self.error(key, f"give at least one [[{key}]] table")
        return [Table(self.file, row, f"{self.path}{key}[{i}].") for i, row in enumerate(value)]

    def error(self, key: str, remedy: str) -> RigError:
        """Say what is wrong with a key, and what to do."""
        value = repr(self.values[key]) if key in self.values else "missing"
        return RigError(f"{self.file}: {self.path}{key} = {value}: {remedy}")

    def _value(self, key: str, default: object = None) -> object:
        self.asked.add(key)
        return self.values.get(key, default)


def _is_number(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and abs(value) < float("inf")
