"""Atomic write of a folder of results."""

import os
import re
import shutil
import sys
from collections.abc import Callable, Collection, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from luxloop.printable import print_text
from luxloop.scenarios.errors import OutputError
from luxloop.scenarios.files import atomic_file, owner_lock
from luxloop.scenarios.files.atomic_file import flush_folder, flush_tree


@contextmanager
def create(out: Path, option: str, refuse: Callable[[Path], None]) -> Iterator[Path]:
    """Yield a temporary folder beside `out`; rename it to `out` at the end, or delete it on any error.

    An earlier folder at `out` is replaced unless `refuse` raises. Missing parent folders are made. All files are
    flushed to the disk before the rename.

    Parameters
    ----------
    out
        Final path of the folder; symbolic links are followed.
    option
        Command-line option that sets `out`, for error messages.
    refuse
        Raises an OutputError if the folder at `out` exists and must not be replaced.

    Raises
    ------
    OutputError
        `out` cannot be written, or must not be replaced.
    """
    missing: list[Path] = []
    named: list[Path] = []
    lock = None
    try:
        with _errors_of(out, option):
            out = Path(os.path.realpath(out))
            refuse(out)
            _remove_leftovers(out)
            missing = [folder for folder in out.parents if not folder.exists()]
            temporary, lock = owner_lock.made(out, named, lambda name: name.mkdir(parents=True))
        yield temporary
        refuse(out)  # again: another process may have written there meanwhile
        with _errors_of(out, option):
            flush_tree(temporary)
            atomic_file.announce(out, temporary)
            _move_into_place(temporary, out, named)
    except BaseException:
        for folder in named:
            if out.exists() or folder.suffix == ".partial":  # never the earlier folder before its successor is there
                _remove(folder)
        _remove_empty(missing)
        raise
    finally:
        owner_lock.release(lock)


def refuse_existing(out: Path, option: str = "--out") -> None:
    """Raise an OutputError if a folder exists, for `create`."""
    if out.exists():
        raise OutputError(f"{out}: already exists; choose another folder with {option}")


def refuse_other_files(
    out: Path, *, marks: Collection[str], contents: Collection[str], what: str, option: str = "--out"
) -> None:
    """Raise an OutputError if a folder holds other files than `contents`, or lacks the `marks`, for `create`."""
    if out.is_dir():
        names = {path.name for path in out.iterdir()}
        if names and not set(marks) <= names <= set(contents):
            raise OutputError(f"{out}: holds other files than those of {what}; choose another with {option}")
    elif out.exists():
        raise OutputError(f"{out}: is a file; choose another folder with {option}")


def overlap(one: Path, other: Path) -> bool:
    """Return True if two folders are the same, or one contains the other; symbolic links are followed."""
    here, there = (Path(os.path.realpath(folder)) for folder in (one, other))
    return there.is_relative_to(here) or here.is_relative_to(there)


def is_unfinished(folder: Path) -> bool:
    """Return True for a temporary folder of `create`: its process was killed, or is still writing or removing it."""
    return bool(re.fullmatch(r"\..*-\d{1,9}-[0-9a-f]{8}\.partial", Path(os.path.realpath(folder)).name))


@contextmanager
def _errors_of(out: Path, option: str) -> Iterator[None]:
    """Raise errors of the system as those of `out`; a ValueError is that of a NUL character in the path."""
    try:
        yield
    except (OSError, ValueError) as error:
        raise atomic_file.cannot_write(out, option, error) from error


def _move_into_place(temporary: Path, out: Path, named: list[Path]) -> None:
    """Replace `out` by two renames, and restore the earlier folder if the second one does not take place.

    The name of the earlier folder is in `named`, for the caller to remove if a signal interrupts this.
    """
    if not out.exists():
        temporary.rename(out)
        flush_folder(out.parent)
        return
    earlier = owner_lock.beside(out, "earlier")
    named.append(earlier)
    with owner_lock.held(out):
        try:
            out.rename(earlier)
            temporary.rename(out)
        except BaseException:
            if earlier.exists() and not out.exists():
                earlier.rename(out)
            raise
        flush_folder(out.parent)
        _remove(earlier)


def _remove_leftovers(out: Path) -> None:
    """Remove folders of killed processes, and restore an earlier folder that was renamed and not yet replaced."""
    for path, purpose in owner_lock.abandoned(out, "partial", "earlier"):
        if purpose == "earlier" and not out.exists():
            path.rename(out)
            done = "restored from"
        else:
            _remove(path)
            done = "removed"
        print_text(f"luxloop: {out}: {done} {path.name}, left by a command that was killed", file=sys.stderr)


def _remove(folder: Path) -> None:
    """Remove a temporary folder, under a name by which the rest is unfinished if the process is killed meanwhile.

    A second call continues one that was interrupted.
    """
    unfinished = folder.with_suffix(".partial")
    with suppress(OSError):
        folder.rename(unfinished)
    for left in (unfinished, folder):
        shutil.rmtree(left, ignore_errors=True)


def _remove_empty(folders: list[Path]) -> None:
    """Remove the parent folders that `create` made, innermost first."""
    for folder in folders:
        with suppress(OSError):
            folder.rmdir()
