"""Atomic write of a folder of results."""

import os
import platform
import re
import secrets
import shutil
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from scenarios.errors import OutputError


@contextmanager
def create(out: Path, option: str, refuse: Callable[[Path], None]) -> Iterator[Path]:
    """Yield a temporary folder beside `out`; rename it to `out` at the end, or delete it on any error.

    An earlier folder at `out` is replaced unless `refuse` raises. Missing parent folders are made.

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
    out = Path(os.path.realpath(out))
    temporary = _beside(out, "partial")
    missing: list[Path] = []
    try:
        refuse(out)
        _remove_leftovers(out)
        missing = [folder for folder in out.parents if not folder.exists()]
        temporary.mkdir(parents=True)
    except OSError as error:
        _remove_empty(missing)
        raise cannot_write(out, option, error) from error
    try:
        yield temporary
        refuse(out)  # again: another process may have written there meanwhile
        _move_into_place(temporary, out)
    except BaseException:
        shutil.rmtree(temporary, ignore_errors=True)
        _remove_empty(missing)
        raise


def is_unfinished(folder: Path) -> bool:
    """Return True for a temporary folder of `create`: its process was killed, or is still writing."""
    return bool(re.fullmatch(r"\..*-\d{1,9}-[0-9a-f]{8}\.partial", Path(os.path.realpath(folder)).name))


def cannot_write(folder: Path, option: str, error: OSError) -> OutputError:
    """Return the error for a folder that cannot be written, with its reason and remedy."""
    return OutputError(f"{folder}: cannot write there ({error.strerror}); choose another folder with {option}")


def _move_into_place(temporary: Path, out: Path) -> None:
    """Replace `out` by two renames, and restore the earlier folder if the second one fails."""
    if not out.exists():
        temporary.rename(out)
        return
    earlier = _beside(out, "earlier")
    out.rename(earlier)
    try:
        temporary.rename(out)
    except OSError:
        earlier.rename(out)
        raise
    shutil.rmtree(earlier)


def _beside(out: Path, purpose: str) -> Path:
    """Return an unused path beside `out` that names the host and process that own it."""
    return out.with_name(f".{out.name}.{platform.node()}-{os.getpid()}-{secrets.token_hex(4)}.{purpose}")


def _remove_leftovers(out: Path) -> None:
    """Remove folders of killed processes, and restore an earlier folder that was renamed and not yet replaced."""
    pattern = re.compile(rf"\.{re.escape(out.name)}\.(.*)-(\d{{1,9}})-[0-9a-f]{{8}}\.(partial|earlier)")
    for path in list(out.parent.iterdir()) if out.parent.is_dir() else ():
        if (match := pattern.fullmatch(path.name)) and _is_dead(host=match[1], pid=int(match[2])):
            if match[3] == "earlier" and not out.exists():
                path.rename(out)
            else:
                shutil.rmtree(path, ignore_errors=True)


def _is_dead(host: str, pid: int) -> bool:
    """Return True if a process has ended.

    A process of another host may be alive, as may any on Windows, where `os.kill` would end it.
    """
    if host != platform.node() or os.name != "posix":
        return False
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return True
    except PermissionError:
        return False  # alive, of another user
    return False


def _remove_empty(folders: list[Path]) -> None:
    """Remove the parent folders that `create` made, innermost first."""
    for folder in folders:
        with suppress(OSError):
            folder.rmdir()
