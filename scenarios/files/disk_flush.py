"""Flush of files and folders to the disk, so that a rename after it survives a power failure."""

import os
from contextlib import suppress
from pathlib import Path


def flush_file(path: Path) -> None:
    """Flush a file to the disk.

    Raises
    ------
    OSError
        The file cannot be written, e.g. because the disk is full.
    """
    descriptor = os.open(path, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)


def flush_folder(folder: Path) -> None:
    """Flush the entries of a folder, where the file system can."""
    with suppress(OSError):  # Windows opens no folders, and some network file systems flush none
        flush_file(folder)


def flush_tree(folder: Path) -> None:
    """Flush all files and folders below `folder`, and itself.

    Raises
    ------
    OSError
        As for `flush_file`.
    """
    for path in folder.rglob("*"):
        if path.is_dir():
            flush_folder(path)
        elif path.is_file():
            flush_file(path)
    flush_folder(folder)
