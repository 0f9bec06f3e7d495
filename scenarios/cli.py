"""The command line. Slow packages are imported inside the commands, so that help and list are fast."""

import os
import sys
import threading
from typing import Annotated

import typer

from luxloop.scenarios.commands import (
    baseline,
    blame,
    check_tracker,
    compare,
    compile_kernels,
    egos,
    export,
    full_disk,
    grade,
    import_,
    league,
    list_scenarios,
    mcap,
    new,
    occlusions,
    paper,
    realism,
    refused_path,
    report,
    run,
    schema,
    search,
    sweep,
    thresholds,
    track,
    trends,
    view,
)  # fmt: skip
from luxloop.scenarios.commands.error_line import print_error
from luxloop.scenarios.commands.plain_help import PlainHelp
from luxloop.scenarios.errors import Interrupted
from luxloop.scenarios.files import completed
from luxloop.scenarios.run import termination, versions
from luxloop.sim.rare_collection import collect_rarely

app = typer.Typer(
    help="Simulation in the loop for LIDAR vehicle tracking: traffic in, graded tracks out.",
    pretty_exceptions_enable=False,
)
app.command("list", cls=PlainHelp)(list_scenarios.list_scenarios)
for command in (
    egos.egos, new.new, run.run, view.view, report.report, paper.paper, blame.blame, compare.compare, baseline.baseline,
    trends.trends, grade.grade, check_tracker.check_tracker, mcap.mcap, export.export, realism.realism,
    occlusions.occlusions, league.league, sweep.sweep, search.search, thresholds.thresholds, schema.schema,
):  # fmt: skip
    app.command(cls=PlainHelp)(command)
app.command("warm-up", cls=PlainHelp)(compile_kernels.warm_up)
app.command("import", cls=PlainHelp)(import_.import_)
app.command(cls=PlainHelp)(track.track)

INTERRUPTED = 130
"""Exit code of Ctrl-C, as typer's."""
SHOWN = 3
"""Largest number of paths in the message of Ctrl-C."""

BROKEN_TRACKER = 4

UNKNOWN = -1
"""For errors of luxloop itself, which keep their traceback."""


def main(arguments: list[str] | None = None) -> int:
    """Run the command line and return its exit code; a program gives no arguments.

    0 passed, 1 failed or ended early, 2 bad input, 3 the simulator failed, 4 the tracker broke its contract,
    130 Ctrl-C, 143 SIGTERM, 129 SIGHUP.

    Known errors are printed as one line on standard error. Others keep their traceback: they are defects of luxloop.
    """
    if arguments is None:
        collect_rarely()
    completed.forget()
    with termination.as_interrupts() as received:
        code = _carry_out(arguments)
    if code == INTERRUPTED:
        code = received.exit_code
        termination.clear_unhandled()
    if code == BROKEN_TRACKER and arguments is None and threading.active_count() > 1:
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(code)  # a thread of the tracker would keep the process alive
    return code


def _carry_out(arguments: list[str] | None) -> int:
    """Run a command and print its error, if any, on one line."""
    try:
        code: int = app(arguments or sys.argv[1:] or ["--help"], prog_name="luxloop", standalone_mode=False) or 0
        full_disk.flush_output()
    except typer.TyperException as error:
        return print_error(error.format_message(), error.exit_code)
    except Interrupted as error:
        return print_error(str(error), INTERRUPTED)
    except Exception as error:
        if isinstance(error, OSError) and full_disk.is_full(error):
            full_disk.drop_output()
            return print_error(full_disk.message(error), 2)
        if isinstance(error, OSError) and refused_path.is_refused(error):
            return print_error(refused_path.message(error), 2)
        code = _exit_code(error)
        if code == UNKNOWN:
            raise
        if code != INTERRUPTED:
            return print_error(str(error), code)
    return print_error(f"interrupted; {_kept()}", code) if code == INTERRUPTED else code


def _kept() -> str:
    """Return the part of the message of Ctrl-C that names the results written before it."""
    whole = [str(path) for path in completed.listed()]
    more = [f"{len(whole) - SHOWN} more"] if len(whole) > SHOWN else []
    return f"complete and kept: {', '.join([*whole[:SHOWN], *more])}" if whole else "nothing was written"


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
    from luxloop.scenarios.errors import ContractError, InputError
    from luxloop.sensor_model.rig.rig import RigError
    from luxloop.sim.source import SimulatorFailedError, TrafficError

    if isinstance(error, SimulatorFailedError):
        return 3
    if isinstance(error, ContractError):
        return BROKEN_TRACKER
    if isinstance(error, InputError | RigError | TrafficError):
        return 2
    return INTERRUPTED if termination.is_interrupt(error) else UNKNOWN
