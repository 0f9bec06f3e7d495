"""Append-only log file: each appended line is flushed to disk before the call returns."""

import os
from pathlib import Path


def append(path: Path, lines: str) -> None:
    """Append complete lines and flush them to disk.

    Raises
    ------
    OSError
        The file cannot be written.
    """
    with path.open("ab") as log:
        log.write(lines.encode())
        log.flush()
        os.fsync(log.fileno())


def truncate_partial_line(path: Path) -> None:
    """Remove an incomplete last line, left by a killed process or a full disk."""
    if path.is_file():
        with path.open("rb") as log:
            complete = sum(len(line) for line in log if line.endswith(b"\n"))
        os.truncate(path, complete)
