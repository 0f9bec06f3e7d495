"""The command line. What takes long to import is imported where it is needed, so that help and list stay quick."""

import sys

import typer

from scenarios.commands import (
    baseline,
    blame,
    check_tracker,
    compare,
    grade,
    list_scenarios,
    mcap,
    report,
    run,
    schema,
    search,
    sweep,
    view,
)  # fmt: skip
from scenarios.commands.error_line import print_error
from scenarios.errors import Interrupted

app = typer.Typer(
    help="Simulation in the loop for LIDAR vehicle tracking: traffic in, graded tracks out.",
    add_completion=False,
    pretty_exceptions_enable=False,
)
app.command("list")(list_scenarios.list_scenarios)
for command in (
    run.run, view.view, report.report, blame.blame, compare.compare, baseline.baseline, grade.grade,
    check_tracker.check_tracker, mcap.mcap, sweep.sweep, search.search, schema.schema,
):  # fmt: skip
    app.command()(command)


def main(arguments: list[str] | None = None) -> int:
    """Run the command line and return its exit code.

    0 passed, 1 failed or ended early, 2 bad input, 3 the simulator failed, 130 Ctrl-C.

    Known errors become one line on standard error. Others keep their traceback: they are ours to mend.
    """
    try:
        code: int = app(arguments or sys.argv[1:] or ["--help"], prog_name="luxloop", standalone_mode=False) or 0
    except typer.TyperException as error:
        return print_error(error.format_message(), error.exit_code)
    except Interrupted as error:
        return print_error(str(error), INTERRUPTED)
    except Exception as error:
        code = _exit_code(error)
        if code == UNKNOWN:
            raise
        if code != INTERRUPTED:
            return print_error(str(error), code)
    return print_error("interrupted; nothing was written", code) if code == INTERRUPTED else code


INTERRUPTED = 130
"""What typer makes of Ctrl-C."""

UNKNOWN = -1
"""For errors that are ours to mend."""


def _exit_code(error: BaseException) -> int:
    """Exit code of an error that people can mend themselves, or have made."""
    from scenarios.errors import InputError
    from sensor_model.rig.rig import RigError
    from sim.source import SimulatorFailedError, TrafficError

    if isinstance(error, SimulatorFailedError):
        return 3
    if isinstance(error, InputError | RigError | TrafficError):
        return 2
    if isinstance(error, SystemError) and error.__cause__:  # numba makes this of what comes while it loads a kernel
        return _exit_code(error.__cause__)
    return INTERRUPTED if isinstance(error, KeyboardInterrupt) else UNKNOWN
