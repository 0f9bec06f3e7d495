"""Errors of a full disk and of a refused path, which any access to a file may meet: one line each."""

import errno
import os
import sys

REFUSED = {errno.ENAMETOOLONG, errno.EACCES, errno.EPERM}
"""Error numbers of a path that is too long, and of a file or folder without the rights to it."""
FULL = {errno.ENOSPC, errno.EDQUOT, errno.EFBIG}
"""Error numbers of a full disk, an exceeded quota and a limit on the size of files."""


def is_full(error: BaseException) -> bool:
    """Return True for an error of a full disk."""
    return isinstance(error, OSError) and error.errno in FULL


def message(error: BaseException) -> str:
    """Return the line of such an error; empty for others, as that of a missing file, which `Path.is_dir` catches."""
    if not isinstance(error, OSError) or error.errno is None:
        return ""
    if error.errno in FULL:
        place = error.filename or "a file or standard output"
        return f"{place}: cannot be written ({os.strerror(error.errno)}); free some space"
    if error.errno in REFUSED and error.filename is not None:
        return f"{error.filename}: {os.strerror(error.errno)}; give another path"
    return ""


def flush_output() -> None:
    """Flush standard output; if that fails, drop what is left of it, which Python would write again at its end.

    Raises
    ------
    OSError
        It cannot be written.
    """
    try:
        sys.stdout.flush()
    except OSError:
        drop_output()
        raise


def drop_output() -> None:
    """Connect standard output to nothing."""
    nothing = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nothing, 1)
    os.close(nothing)
