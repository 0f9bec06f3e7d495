"""Exit codes of the command line, and the errors behind them."""

import errno
import os
import sys
from enum import IntEnum

from luxloop.scenarios.errors import ContractError, InputError
from luxloop.scenarios.run import termination

REFUSED = {errno.ENAMETOOLONG, errno.EACCES, errno.EPERM}
"""Error numbers of a path that is too long, and of a file or folder without the rights to it."""
FULL = {errno.ENOSPC, errno.EDQUOT, errno.EFBIG}
"""Error numbers of a full disk, an exceeded quota and a limit on the size of files."""


def is_full(error: BaseException) -> bool:
    """Return True for an error of a full disk."""
    return isinstance(error, OSError) and error.errno in FULL


def disk_message(error: BaseException) -> str:
    """Return the line of an error of a full disk or a refused path; empty for others, as that of a missing file."""
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


INTERNAL_ERROR = "internal error: "
"""Begin of the `error` of a run that ended by a defect of luxloop, in rows and logs of studies."""


class ExitCode(IntEnum):
    """Exit codes of all commands."""

    PASSED = 0
    FAILED = 1
    """An expectation failed, or the run ended early."""
    BAD_INPUT = 2
    SIMULATOR_FAILED = 3
    BROKEN_TRACKER = 4
    CANNOT_TELL = 5
    """Of `luxloop compare`."""
    INTERNAL = 70
    """A defect of luxloop or of its installation; `EX_SOFTWARE` of sysexits.h."""
    INTERRUPTED = termination.CTRL_C


NO_FOLDER = "cannot cache function"
"""Begin of numba's message where it finds no folder for compiled kernels, at the import of a kernel."""


def explain(error: BaseException) -> tuple[ExitCode, str]:
    """Return the exit code of an error, and its message; `INTERNAL` is every error that no user can correct."""
    if isinstance(error, RuntimeError) and str(error).startswith(NO_FOLDER):
        return ExitCode.BAD_INPUT, "no folder for compiled kernels can be written; set NUMBA_CACHE_DIR to one that can"
    from luxloop.sensor_model.rig.rig import RigError
    from luxloop.sim.source import SimulatorFailedError, TrafficError

    if line := disk_message(error):
        return ExitCode.BAD_INPUT, line
    if isinstance(error, SimulatorFailedError):
        return ExitCode.SIMULATOR_FAILED, str(error)
    if isinstance(error, ContractError):
        return ExitCode.BROKEN_TRACKER, str(error)
    if isinstance(error, InputError | RigError | TrafficError):
        return ExitCode.BAD_INPUT, str(error)
    return ExitCode.INTERRUPTED if termination.is_interrupt(error) else ExitCode.INTERNAL, str(error)
