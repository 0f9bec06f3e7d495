"""The command line. Slow packages are imported inside the commands, so that help and list are fast."""

import os
import sys
import threading
from typing import Annotated

import typer

from scenarios.commands import (
    baseline,
    blame,
    check_tracker,
    compare,
    compile_kernels,
    grade,
    import_,
    list_scenarios,
    mcap,
    paper,
    realism,
    report,
    run,
    schema,
    search,
    sweep,
    track,
    trends,
    view,
)  # fmt: skip
from scenarios.commands.error_line import print_error
from scenarios.commands.plain_help import PlainHelp
from scenarios.errors import Interrupted
from scenarios.run import versions

app = typer.Typer(
    help="Simulation in the loop for LIDAR vehicle tracking: traffic in, graded tracks out.",
    pretty_exceptions_enable=False,
)
app.command("list", cls=PlainHelp)(list_scenarios.list_scenarios)
for command in (
    run.run, view.view, report.report, paper.paper, blame.blame, compare.compare, baseline.baseline, trends.trends,
    grade.grade, check_tracker.check_tracker, mcap.mcap, realism.realism, sweep.sweep, search.search, schema.schema,
):  # fmt: skip
    app.command(cls=PlainHelp)(command)
app.command("warm-up", cls=PlainHelp)(compile_kernels.warm_up)
app.command("import", cls=PlainHelp)(import_.import_)
app.command(cls=PlainHelp)(track.track)

INTERRUPTED = 130
"""Exit code of Ctrl-C, as typer's."""

BROKEN_TRACKER = 4

UNKNOWN = -1
"""For errors of luxloop itself, which keep their traceback."""


def main(arguments: list[str] | None = None) -> int:
    """Run the command line and return its exit code; a program gives no arguments.

    0 passed, 1 failed or ended early, 2 bad input, 3 the simulator failed, 4 the tracker broke its contract,
    130 Ctrl-C.

    Known errors are printed as one line on standard error. Others keep their traceback: they are defects of luxloop.
    """
    code = _carry_out(arguments)
    if code == BROKEN_TRACKER and arguments is None and threading.active_count() > 1:
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(code)  # a thread of the tracker would keep the process alive
    return code


def _carry_out(arguments: list[str] | None) -> int:
    """Run a command and print its error, if any, on one line."""
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


def _print_versions(wanted: bool) -> None:
    if wanted:
        installed = versions.installed()
        names = ["luxloop", *(name for name in installed if name != "luxloop")]
        print("\n".join(f"{name} {installed[name]}" for name in names))
        raise typer.Exit


@app.callback()
def _options(
    version: Annotated[
        bool,
        typer.Option(
            "--version", callback=_print_versions, is_eager=True,
            help="Print the versions of luxloop and of the packages that can change a result.",
        ),
    ] = False,
) -> None:  # fmt: skip
    pass


def _exit_code(error: BaseException) -> int:
    """Return the exit code of a user's error or of Ctrl-C, and `UNKNOWN` for any other error."""
    from scenarios.errors import ContractError, InputError
    from sensor_model.rig.rig import RigError
    from sim.source import SimulatorFailedError, TrafficError

    if isinstance(error, SimulatorFailedError):
        return 3
    if isinstance(error, ContractError):
        return BROKEN_TRACKER
    if isinstance(error, InputError | RigError | TrafficError):
        return 2
    if isinstance(error, SystemError) and error.__cause__:  # numba raises it from an interrupt while it loads a kernel
        return _exit_code(error.__cause__)
    return INTERRUPTED if isinstance(error, KeyboardInterrupt) else UNKNOWN
