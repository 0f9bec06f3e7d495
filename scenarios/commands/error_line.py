"""Error messages on one line of standard error."""

import sys
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from luxloop.scenarios.result import Result

LONGEST_LINE = 1000
"""Characters. The list of all highway-env environments takes 600; longer lines keep their beginning and end."""


def print_error(message: str, code: int) -> int:
    """Print a message as one printable line on standard error, and return the exit code."""
    line = "".join(letter if letter.isprintable() else "?" for letter in " ".join(message.split()))
    if len(line) > LONGEST_LINE:
        line = f"{line[: LONGEST_LINE // 2]} ... {line[-LONGEST_LINE // 2 :]}"
    print(f"luxloop: error: {line}", file=sys.stderr)
    return code


def print_early_end(result: "Result", kept: str) -> int:
    """Print why a run ended early and what is kept of it, and return the exit code.

    A reason with a remedy of its own names it after a semicolon.
    """
    has_remedy = result.simulator_failed or ";" in result.ended_early
    remedy = "" if has_remedy else "; give the ego a longer route, or the run a shorter --duration"
    return print_error(f"{result.ended_early.rstrip('.')}{remedy}; {kept}", 3 if result.simulator_failed else 1)
