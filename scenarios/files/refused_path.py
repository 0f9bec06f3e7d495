"""Errors of a path that the system refuses, which any look at a file may meet."""

import errno
import os

REFUSED = {errno.ENAMETOOLONG, errno.EACCES, errno.EPERM}
"""Error numbers of a path that is too long, and of a file or folder without the rights to it."""


def is_refused(error: BaseException) -> bool:
    """Return True for such an error; `Path.is_dir` and others raise it, unlike that of a missing file."""
    return isinstance(error, OSError) and error.errno in REFUSED and error.filename is not None


def message(error: OSError) -> str:
    """Return the line of such an error."""
    return f"{error.filename}: {os.strerror(error.errno or errno.EACCES)}; give another path"
