"""Errors of a full disk and of a refused path, which any access to a file may meet: one line each."""

import errno
import os
import sys

REFUSED = {errno.ENAMETOOLONG, errno.EACCES, errno.EPERM}
"""Error numbers of a path that is too long, and of a file or folder without the rights to it."""


def is_refused(error: BaseException) -> bool:
    """Return True for such an error; `Path.is_dir` and others raise it, unlike that of a missing file."""
    return isinstance(error, OSError) and error.errno in REFUSED and error.filename is not None


def refused_message(error: OSError) -> str:
    """Return the line of such an error."""
    return f"{error.filename}: {os.strerror(error.errno or errno.EACCES)}; give another path"


FULL = {errno.ENOSPC, errno.EDQUOT, errno.EFBIG}
"""Error numbers of a full disk, an exceeded quota and a limit on the size of files."""


def is_full(error: BaseException) -> bool:
    """Return True for an error of a full disk."""
    return isinstance(error, OSError) and error.errno in FULL


def full_message(error: OSError) -> str:
    """Return the line of such an error."""
    place = error.filename or "a file or standard output"
    return f"{place}: cannot be written ({os.strerror(error.errno or errno.ENOSPC)}); free some space"


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
