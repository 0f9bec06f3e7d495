"""A file that appears as a whole or not at all."""

import os
import secrets
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path


@contextmanager
def create(path: Path) -> Iterator[Path]:
    """Give a temporary file beside `path` to write; it becomes `path` at the end, and vanishes on any error.

    Raises
    ------
    OSError
        It cannot be written there.
    """
    temporary = path.with_name(f".{path.name}.{os.getpid()}-{secrets.token_hex(4)}.partial")
    try:
        yield temporary
        temporary.replace(path)
    finally:
        temporary.unlink(missing_ok=True)
