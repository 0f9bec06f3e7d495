"""The command line. Slow packages are imported inside the commands, so that help and list are fast."""

import os
import select
import signal
import sys
import threading
from collections.abc import Callable
from typing import Annotated, Any

import typer
import typer.core

from luxloop.plugins import ABILITIES, formats_that
from luxloop.printable import print_text
from luxloop.scenarios import exit_codes
from luxloop.scenarios.commands import (
    compare,
    grade,
    import_,
    league,
    list_scenarios,
    look,
    own_data,
    run,
    study,
    tools,
    track,
)
from luxloop.scenarios.commands.error_messages import print_error, print_internal_error
from luxloop.scenarios.errors import Interrupted
from luxloop.scenarios.exit_codes import ExitCode, explain
from luxloop.scenarios.files import atomic_file
from luxloop.scenarios.run import termination, versions
from luxloop.sim.rare_collection import collect_rarely


class PlainHelp(typer.core.TyperGroup):
    """Group of commands whose help has a section for each `rich_help_panel`."""

    def format_help_text(self, ctx: Any, formatter: Any) -> None:
        """Write the description, then the sections in the order of their first commands."""
        super().format_help_text(ctx, formatter)
        groups: dict[Any, list[typer.core.TyperCommand]] = {}
        for name in self.list_commands(ctx):
            command = self.commands[name]
            assert isinstance(command, typer.core.TyperCommand)
            groups.setdefault(command.rich_help_panel, []).append(command)
        widest = max(map(len, self.commands))
        for group, commands in groups.items():
            with formatter.section(group):
                formatter.write_dl([(f"{each.name:{widest}}", each.short_help or "") for each in commands])

    def format_commands(self, ctx: Any, formatter: Any) -> None:
        """Write nothing after the options: the commands are above them."""


class FormatHelp(typer.core.TyperCommand):
    """Command whose help names the file formats that are found, in place of `{read_boxes}` and the like."""

    def format_help(self, *arguments: Any) -> None:
        """Write the help."""
        for parameter in self.params:
            if isinstance(parameter, typer.core.TyperOption) and parameter.help:
                parameter.help = _with_formats(parameter.help)
        super().format_help(*arguments)


def _with_formats(text: str) -> str:
    for ability in ABILITIES:
        place = f"{{{ability}}}"
        if place in text:
            text = text.replace(place, ", ".join(formats_that(ability)))
    return text


COMMANDS: dict[str, dict[str, tuple[Callable[..., None], str]]] = {
    "Run": {
        "list": (list_scenarios.list_scenarios, "List the scenarios that ship."),
        "metrics": (list_scenarios.metrics, "List the metrics with their sentences."),
        "run": (run.run, "Run a scenario and grade the tracker."),
        "grade": (grade.grade, "Grade recorded scans, or tracks and truth in files."),
        "check-tracker": (tools.check_tracker, "Check that a tracker keeps the interface contract."),
    },
    "Look": {
        "view": (look.view, "Open the recording of a run in the rerun viewer."),
        "report": (look.report, "Write an HTML page of one or several runs."),
        "paper": (look.paper, "Print the tables of the paper beside those of runs."),
        "occlusions": (look.occlusions, "Print the survival of track ids in occlusions."),
    },
    "Compare": {
        "compare": (compare.compare, "Compare two sets of runs of the same scenarios and seeds."),
        "baseline": (compare.baseline, "Write the baseline file of a comparison."),
        "trends": (compare.trends, "Draw the key metrics over many baselines."),
        "league": (league.league, "Run several trackers on the same scans."),
        "blame": (compare.blame, "Measure the error that each stage of the tracker causes."),
        "ceiling": (compare.ceiling, "Print HOTA beside what the scans allow."),
    },
    "Study": {
        "sweep": (study.sweep, "Run all combinations of a study's parameters."),
        "search": (study.search, "Search for the smallest disturbance that breaks the tracker."),
        "thresholds": (study.thresholds, "Estimate the parameter value at which a metric fails."),
    },
    "Own data": {
        "new": (own_data.new, "Write a scenario file for a SUMO net or a recording."),
        "egos": (own_data.egos, "List candidates for the ego in SUMO traffic."),
        "import": (import_.import_, "Make recorded scans of a real recording."),
        "track": (track.track, "Run a tracker over recorded scans."),
        "export": (own_data.export, "Write a run in the format of other programs."),
        "mcap": (own_data.mcap, "Write a run as MCAP, for ROS 2 and Foxglove."),
        "realism": (own_data.realism, "Compare simulated vehicles with real ones."),
        "fits": (own_data.fits, "Grade the fits to labelled vehicles."),
    },
    "Tools": {
        "warm-up": (tools.warm_up, "Compile the kernels before parallel runs do."),
        "schema": (tools.schema, "Print the JSON schema of scenario files."),
    },
}
"""Commands by group and name, with their line in the help of the program."""

app = typer.Typer(
    cls=PlainHelp,
    help="Simulation in the loop for LIDAR vehicle tracking: traffic in, graded tracks out.",
    epilog="luxloop COMMAND --help describes a command. Exit codes: 0 passed, 1 an expectation failed, 2 bad input, "
    "3 the simulator failed, 4 the tracker broke its contract, 5 a comparison could not tell, 70 a defect of luxloop.",
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
)
for group, commands in COMMANDS.items():
    for name, (command, line) in commands.items():
        app.command(name, cls=FormatHelp, short_help=line, rich_help_panel=group)(command)

COMPLETION = "_LUXLOOP_COMPLETE"
"""Variable by which a shell asks for completions; Typer prints them and leaves by SystemExit."""
SHOWN = 3
"""Largest number of paths in the message of Ctrl-C."""


def main(arguments: list[str] | None = None) -> int:
    """Run the command line and return its exit code, see `ExitCode`; a program gives no arguments.

    The code of an interrupted command is that of its signal: 130 Ctrl-C, 143 SIGTERM, 129 SIGHUP.
    Errors of a user are printed as one line on standard error. Defects of luxloop keep their traceback before it.
    """
    if arguments is None:
        collect_rarely()
    atomic_file.forget()
    with termination.as_interrupts() as received:
        code = _carry_out(arguments)
    if code == ExitCode.INTERRUPTED:
        code = received.exit_code
        termination.clear_unhandled()
    if arguments is None:
        termination.end_at_once(code)
    if code in (ExitCode.BROKEN_TRACKER, ExitCode.INTERNAL) and arguments is None and threading.active_count() > 1:
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(code)  # a thread of the tracker would keep the process alive
    return code


def _carry_out(arguments: list[str] | None) -> int:
    """Run a command, print its error, if any, and return the exit code."""
    try:
        code: int = app(arguments or sys.argv[1:] or ["--help"], prog_name="luxloop", standalone_mode=False) or 0
        exit_codes.flush_output()
    except typer.TyperException as error:
        return print_error(error.format_message(), error.exit_code)
    except Interrupted as error:
        return print_error(str(error), ExitCode.INTERRUPTED)
    except BaseException as error:  # no library ends luxloop with a code of its own
        if COMPLETION in os.environ:
            raise
        if _is_unread():
            exit_codes.drop_output()
            return 128 + signal.SIGPIPE
        if exit_codes.is_full(error):
            exit_codes.drop_output()
        code, message = explain(error)
        if code == ExitCode.INTERNAL:
            return print_internal_error(error)
        if code != ExitCode.INTERRUPTED:
            return print_error(message, code)
    return print_error(f"interrupted; {_kept()}", code) if code == ExitCode.INTERRUPTED else code


def _is_unread() -> bool:
    """Return True if the reader of standard output has ended, as in `luxloop list | head -1`."""
    output = select.poll()
    output.register(1)
    return any(event & select.POLLERR for _, event in output.poll(0))


def _kept() -> str:
    """Return the part of the message of Ctrl-C that names the results written before it."""
    whole = [str(path) for path in atomic_file.listed()]
    more = [f"{len(whole) - SHOWN} more"] if len(whole) > SHOWN else []
    return f"complete and kept: {', '.join([*whole[:SHOWN], *more])}" if whole else "nothing was written"


def _print_versions(wanted: bool) -> None:
    if wanted:
        installed = versions.installed()
        names = ["luxloop", *(name for name in installed if name != "luxloop")]
        print_text("\n".join(f"{name} {installed[name]}" for name in names))
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
