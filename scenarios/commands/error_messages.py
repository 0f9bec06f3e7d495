"""Error messages on standard error: one line, and a request to report a defect of luxloop itself.

Imports are minimal, so that a damaged installation is reported as well.
"""

import platform
import sys
import traceback
from collections.abc import Iterable
from importlib.metadata import PackageNotFoundError, version
from typing import TYPE_CHECKING

from luxloop.printable import print_text, printable

if TYPE_CHECKING:
    from luxloop.scenarios.result import Result


LONGEST_LINE = 1000
"""Characters. The list of all highway-env environments takes 600; longer lines keep their beginning and end."""


def print_error(message: str, code: int) -> int:
    """Print a message as one printable line on standard error, and return the exit code."""
    line = printable(" ".join(message.split()))
    if len(line) > LONGEST_LINE:
        line = f"{line[: LONGEST_LINE // 2]} ... {line[-LONGEST_LINE // 2 :]}"
    print_text(f"luxloop: error: {line}", file=sys.stderr)
    return code


def print_early_end(result: "Result", kept: str) -> int:
    """Print why a run ended early and what is kept of it, and return the exit code.

    A reason with a remedy of its own names it after a semicolon.
    """
    has_remedy = result.simulator_failed or ";" in result.ended_early
    remedy = "" if has_remedy else "; give the ego a longer route, or the run a shorter --duration"
    return print_error(f"{result.ended_early.rstrip('.')}{remedy}; {kept}", 3 if result.simulator_failed else 1)


CODE = 70
"""`ExitCode.INTERNAL`, whose module imports more."""


def print_internal_error(error: BaseException) -> int:
    """Print the traceback of an error and a line that asks for a report; return the exit code."""
    sys.stdout.flush()
    print_text("".join(traceback.format_exception(error)), sys.stderr, end="")
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
