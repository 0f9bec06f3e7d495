"""A file that only grows, a line at a time; each line is on disk, whole, before anybody relies on it."""

import os
from pathlib import Path


def append(path: Path, lines: str) -> None:
    """Write whole lines at the end, and have them on disk before returning.

    Raises
    ------
    OSError
        They cannot be written.
    """
    with path.open("ab") as journal:
        journal.write(lines.encode())
        journal.flush()
        os.fsync(journal.fileno())


def forget_a_torn_line(path: Path) -> None:
    """Cut off what a killed process, or a full disk, left of a last line."""
    if path.is_file():
        with path.open("rb") as journal:
            whole = sum(len(line) for line in journal if line.endswith(b"\n"))
        os.truncate(path, whole)
