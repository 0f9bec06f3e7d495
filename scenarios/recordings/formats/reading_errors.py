"""Errors of damaged files as one line."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from luxloop.scenarios.errors import InputError


@contextmanager
def readable(path: Path, what: str) -> Iterator[None]:
    """Turn any error of a parser into an InputError of one line that names file and format.

    Parsers of binary files meet arbitrary bytes, and raise the errors of their libraries: struct.error, KeyError,
    AssertionError, decompression errors.

    Raises
    ------
    InputError
        The file cannot be read as `what`.
    """
    try:
        yield
    except (InputError, MemoryError):
        raise
    except Exception as error:
        reason = " ".join(str(error).split()).removeprefix(f"{path}: ") or type(error).__name__
        raise InputError(
            f"{path}: not readable as {what} ({reason}); it is damaged, truncated or of another format, see --format"
        ) from error


def require_bytes(paths: list[Path]) -> None:
    """Raise an InputError for a path that does not exist, and for an empty file."""
    for path in paths:
        if not path.exists():
            raise InputError(f"{path}: no such file; give the path of a recording")
        if path.is_file() and path.stat().st_size == 0:
            raise InputError(f"{path}: is empty; give a complete recording")
