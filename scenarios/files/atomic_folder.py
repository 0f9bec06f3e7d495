"""A folder of results that appears as a whole or not at all."""

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
    """Give a temporary folder beside `out` to write into; it becomes `out` at the end, and vanishes on any error.

    What is at `out` is replaced, unless `refuse` raises. Folders above `out` are made where missing.

    Parameters
    ----------
    out
        The folder.
    option
        Of the command line that chose it, for complaints.
    refuse
        Raises an OutputError if `out`, whose links are followed, is there and must stay.

    Raises
    ------
    OutputError
        `out` cannot be written, or must stay.
    """
    out = Path(os.path.realpath(out))
    temporary = _beside(out, "partial")
    missing: list[Path] = []
    try:
        refuse(out)
        _clear_up_after_killed_runs(out)
        missing = [folder for folder in out.parents if not folder.exists()]
        temporary.mkdir(parents=True)
    except OSError as error:
        _remove_empty(missing)
        raise cannot_write(out, option, error) from error
    try:
        yield temporary
        refuse(out)  # again: somebody may have put something there meanwhile
        _move_into_place(temporary, out)
    except BaseException:
        shutil.rmtree(temporary, ignore_errors=True)
        _remove_empty(missing)
        raise


def is_unfinished(folder: Path) -> bool:
    """Whether it is one that `create` gave and never renamed: whoever wrote into it was killed, or still writes."""
    return bool(re.fullmatch(r"\..*-\d{1,9}-[0-9a-f]{8}\.partial", Path(os.path.realpath(folder)).name))


def cannot_write(folder: Path, option: str, error: OSError) -> OutputError:
    """Say why, and what to do."""
    return OutputError(f"{folder}: cannot write there ({error.strerror}); choose another folder with {option}")


def _move_into_place(temporary: Path, out: Path) -> None:
    """Swap a folder in; the earlier one is out of the way for the blink of a rename only."""
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
    """Return a name that nothing has yet, and that tells whose it is."""
    return out.with_name(f".{out.name}.{platform.node()}-{os.getpid()}-{secrets.token_hex(4)}.{purpose}")


def _clear_up_after_killed_runs(out: Path) -> None:
    """Remove what nobody will rename any more; put back an earlier run that was moved away and not yet replaced."""
    pattern = re.compile(rf"\.{re.escape(out.name)}\.(.*)-(\d{{1,9}})-[0-9a-f]{{8}}\.(partial|earlier)")
    for path in list(out.parent.iterdir()) if out.parent.is_dir() else ():
        if (match := pattern.fullmatch(path.name)) and _is_dead(host=match[1], pid=int(match[2])):
            if match[3] == "earlier" and not out.exists():
                path.rename(out)
            else:
                shutil.rmtree(path, ignore_errors=True)


def _is_dead(host: str, pid: int) -> bool:
    """Whether a process is clearly dead; one of another computer, or where asking would end it, may well live."""
    if host != platform.node() or os.name != "posix":
        return False
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return True
    except PermissionError:
        return False  # it lives, and is somebody else's
    return False


def _remove_empty(folders: list[Path]) -> None:
    """Take back the folders that were made above the output, innermost first."""
    for folder in folders:
        with suppress(OSError):
            folder.rmdir()
