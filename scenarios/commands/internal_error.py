"""Errors of luxloop itself: the traceback, and a line that asks for a report.

Imports are minimal, so that a damaged installation is reported as well.
"""

import platform
import sys
import traceback
from collections.abc import Iterable
from importlib.metadata import PackageNotFoundError, version

from luxloop.scenarios.commands.error_line import print_error

CODE = 70
"""`ExitCode.INTERNAL`, whose module imports more."""


def print_internal_error(error: BaseException) -> int:
    """Print the traceback of an error and a line that asks for a report; return the exit code."""
    sys.stdout.flush()
    traceback.print_exception(error)
    what = " ".join(f"{type(error).__name__} {error}".split())
    return print_error(f"internal error ({what}): {request(error)}", CODE)


def request(error: BaseException) -> str:
    """Return the request to report an error."""
    if isinstance(error, ImportError):
        return f"the installation is damaged, or this is a defect of luxloop; install it again, else {_report()}"
    return f"this is a defect of luxloop: {_report()}"


def print_failed_runs(errors: Iterable[str]) -> int:
    """Print a line about the internal errors of some runs of a study, and return the exit code."""
    first, *others = dict.fromkeys(errors)
    more = f" and {len(others)} other ones" if others else ""
    return print_error(f"runs ended with an {first}{more}; this is a defect of luxloop: {_report()}", CODE)


def _report() -> str:
    return (
        f"report it with the traceback above, the command, and the output of luxloop --version "
        f"(luxloop {_version()}, Python {platform.python_version()})"
    )


def _version() -> str:
    try:
        return version("luxloop")
    except PackageNotFoundError:
        return "without metadata"
