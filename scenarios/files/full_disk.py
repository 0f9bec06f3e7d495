"""Errors of a full disk, which any write may meet: that of results, of standard output, of a temporary file."""

import errno
import os
import sys

FULL = {errno.ENOSPC, errno.EDQUOT, errno.EFBIG}
"""Error numbers of a full disk, an exceeded quota and a limit on the size of files."""


def is_full(error: BaseException) -> bool:
    """Return True for an error of a full disk."""
    return isinstance(error, OSError) and error.errno in FULL


def message(error: OSError) -> str:
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
