"""Atomic file write, flushed to the disk so that the rename survives a power failure; and the list of whole results."""

import os
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, suppress
from contextvars import ContextVar
from pathlib import Path

from luxloop.scenarios.errors import OutputError
from luxloop.scenarios.files import owner_lock

_announced: list[tuple[Path, int]] = []
"""Final paths, with the inode of the temporary file or folder that is renamed to each."""


def announce(path: Path, temporary: Path) -> None:
    """Note that `temporary` is whole and about to be renamed to `path`."""
    _announced.append((path, temporary.stat().st_ino))


def forget() -> None:
    """Forget the results of an earlier command of this process."""
    _announced.clear()


def listed() -> list[Path]:
    """Return the paths whose rename took place, in its order."""
    return [path for path, inode in _announced if _inode(path) == inode]


def _inode(path: Path) -> int | None:
    try:
        return path.stat().st_ino
    except OSError:
        return None


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


_group: ContextVar[ExitStack | None] = ContextVar("_group", default=None)


@contextmanager
def together() -> Iterator[None]:
    """Rename the files of all `create` in the body at its end; if the body fails, none of them appears.

    Raises
    ------
    OSError
        A file cannot be renamed.
    """
    with ExitStack() as group:
        token = _group.set(group)
        try:
            yield
        finally:
            _group.reset(token)


@contextmanager
def create(path: Path) -> Iterator[Path]:
    """Yield the path of a temporary file beside `path`; rename it to `path` at the end, or delete it on any error.

    The end is that of `together`, if it is in use. The file is flushed to the disk before the rename. Temporary files
    of killed processes are removed.

    Raises
    ------
    OSError
        The file cannot be written.
    """
    group = _group.get()
    if group is None:
        with _created(path) as temporary:
            yield temporary
        return
    temporary = group.enter_context(_created(path))
    yield temporary
    flush_file(temporary)  # a disk that is full is noticed here, before the first rename


@contextmanager
def _created(path: Path) -> Iterator[Path]:
    for left, _ in owner_lock.abandoned(path, "partial"):
        left.unlink(missing_ok=True)
    named: list[Path] = []
    lock = None
    try:
        temporary, lock = owner_lock.made(path, named, lambda name: name.touch(exist_ok=False))
        yield temporary
        flush_file(temporary)
        announce(path, temporary)
        temporary.replace(path)
        flush_folder(path.parent)
    finally:
        for name in named:
            name.unlink(missing_ok=True)
        owner_lock.release(lock)


@contextmanager
def writing(path: Path, option: str = "--out") -> Iterator[None]:
    """Raise errors of the system as an OutputError of the path that `option` chose.

    Raises
    ------
    OutputError
        The path cannot be written.
    """
    try:
        yield
    except OSError as error:
        raise cannot_write(path, option, error) from error


def cannot_write(path: Path, option: str, error: OSError | ValueError) -> OutputError:
    """Return the error for a path that cannot be written, with its reason and remedy."""
    reason = getattr(error, "strerror", None) or error
    return OutputError(f"{path}: cannot write there ({reason}); choose another path with {option}")


def save_text(path: Path, text: str, option: str = "--out") -> None:
    """Write a text file atomically, and make its folder; errors as for `writing`."""
    with writing(path, option):
        path.parent.mkdir(parents=True, exist_ok=True)
        with create(path) as temporary:
            temporary.write_text(text, encoding="utf-8")
