"""The command line. What takes long to import is imported where it is needed, so that help and list stay quick."""

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from scenarios.compare import command as compare
from scenarios.offline import commands
from scenarios.oracle.stage import Stage
from scenarios.search import command as adversary

if TYPE_CHECKING:
    from scenarios.result import Result

app = typer.Typer(
    help="Simulation in the loop for LIDAR vehicle tracking: traffic in, graded tracks out.",
    add_completion=False,
    pretty_exceptions_enable=False,
)


@app.command("list")
def list_scenarios(
    folder: Annotated[bool, typer.Option("--folder", help="Print the folder they are in, for pytest.")] = False,
) -> None:
    """List the scenarios that ship, with a sentence on each."""
    from rich.console import Console
    from rich.table import Table

    from scenarios.listing import CATALOG, entries

    if folder:
        print(CATALOG)
        return
    table = Table("family", "name", "what happens", box=None, padding=(0, 2, 0, 0), header_style="bold")
    for entry in entries():
        table.add_row(*entry)
    Console().print(table)


@app.command()
def run(
    scenario: Annotated[
        str, typer.Argument(metavar="SCENARIO", help="A name from `luxloop list`, or the path of a .toml file.")
    ],
    seed: Annotated[int | None, typer.Option(help="Seed of traffic and noise, instead of the scenario's.")] = None,
    duration: Annotated[float | None, typer.Option(help="Simulated seconds, instead of the scenario's.")] = None,
    out: Annotated[Path | None, typer.Option(help="Folder of the results, else runs/SCENARIO-seedN.")] = None,
    tracker: Annotated[
        str | None, typer.Option(metavar="MODULE:NAME", help="Another device under test, see scenarios/device.py.")
    ] = None,
    oracle: Annotated[
        list[Stage] | None,
        typer.Option(help="Replace this stage of the shipped tracker by the truth; repeat for more."),
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print the result as JSON, and nothing else.")] = False,
    no_recording: Annotated[bool, typer.Option("--no-recording", help="Write no recording.rrd.")] = False,
    record_scans: Annotated[
        bool, typer.Option("--record-scans", help="Keep the scans and their truth with the run, for luxloop grade.")
    ] = False,
    dataset_to: Annotated[
        Path | None, typer.Option("--dataset", metavar="DIR", help="Write scans and labels into this new folder, too.")
    ] = None,
) -> None:
    """Run a scenario, grade it, and exit with 1 if an expectation fails."""
    import json

    from scenarios import listing, report, run_folder
    from scenarios.execute import execute, usual_folder
    from scenarios.oracle.factory import choose
    from scenarios.scenario import Scenario

    overrides = {key: value for key, value in {"seed": seed, "duration_s": duration}.items() if value is not None}
    chosen = Scenario.load(listing.find(scenario), overrides)
    make_device = choose(tracker, oracle or [])
    out = out or usual_folder(chosen, oracle or [])
    outcome = execute(
        chosen, make_device, out, record=not no_recording, record_scans=record_scans, dataset_to=dataset_to
    )
    result, code = outcome.result, 0 if outcome.verdict == "passed" else 1
    if as_json:
        print(json.dumps({**run_folder.document(result, outcome.checks), "out": str(out)}, allow_nan=False))
    else:
        report.show(outcome.report)
        print(f"Results are in {out}" + ("" if no_recording else f"; to watch them: luxloop view {out}"))
        if dataset_to:
            print(f"The data set is in {dataset_to}")
    if not result.complete:
        code = _complain_of_the_end(result, f"the {result.frames} frames until then are in {out}, marked incomplete")
    raise typer.Exit(code)


@app.command()
def blame(
    scenario: Annotated[
        str, typer.Argument(metavar="SCENARIO", help="A name from `luxloop list`, or the path of a .toml file.")
    ],
    seed: Annotated[int | None, typer.Option(help="Seed of traffic and noise, instead of the scenario's.")] = None,
    duration: Annotated[float | None, typer.Option(help="Simulated seconds, instead of the scenario's.")] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print the figures as JSON, and nothing else.")] = False,
) -> None:
    """Tell which stage of the shipped tracker costs what, by putting the truth in the place of each in turn."""
    import json

    from scenarios import listing, report
    from scenarios.blame import document, find_out
    from scenarios.report_blame import tell
    from scenarios.scenario import Scenario

    overrides = {key: value for key, value in {"seed": seed, "duration_s": duration}.items() if value is not None}
    found = find_out(Scenario.load(listing.find(scenario), overrides))
    if as_json:
        print(json.dumps(document(found), allow_nan=False))
    else:
        report.show(tell(found))
    code, result = 0, found.shipped
    if not result.complete:
        code = _complain_of_the_end(result, f"the figures are of the {result.frames} frames until then")
    raise typer.Exit(code)


@app.command()
def view(
    run: Annotated[Path, typer.Argument(metavar="RUN", help="A folder that `luxloop run` wrote.")],
    web: Annotated[bool, typer.Option("--web", help="In a browser instead of the rerun viewer.")] = False,
) -> None:
    """Open a run's recording in the rerun viewer."""
    import subprocess

    from scenarios.run_folder import recording

    command = [sys.executable, "-m", "rerun", "--bind", "127.0.0.1", str(recording(run))]
    raise typer.Exit(subprocess.run(command + ["--web-viewer"] * web, check=False).returncode)


@app.command()
def schema() -> None:
    """Print the JSON schema of scenario files, for editors."""
    from scenarios.scenario import schema_text

    print(schema_text(), end="")


for command in (
    compare.compare, compare.baseline, commands.grade, commands.check_tracker, commands.mcap, adversary.search,
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
        return _complain(error.format_message(), error.exit_code)
    except Exception as error:
        code = _exit_code(error)
        if code == UNKNOWN:
            raise
        if code != INTERRUPTED:
            return _complain(str(error), code)
    return _complain("interrupted; nothing was written", code) if code == INTERRUPTED else code


INTERRUPTED = 130
"""What typer makes of Ctrl-C."""

LONGEST_LINE = 1000
"""Letters. All environments of highway-env take 600; of what is longer, beginning and end tell the most."""

UNKNOWN = -1
"""For errors that are ours to mend."""


def _exit_code(error: BaseException) -> int:
    """Exit code of an error that people can mend themselves, or have made."""
    from scenarios.errors import InputError
    from sensor_model.rig import RigError
    from sim.source import SimulatorFailedError, TrafficError

    if isinstance(error, SimulatorFailedError):
        return 3
    if isinstance(error, InputError | RigError | TrafficError):
        return 2
    if isinstance(error, SystemError) and error.__cause__:  # numba makes this of what comes while it loads a kernel
        return _exit_code(error.__cause__)
    return INTERRUPTED if isinstance(error, KeyboardInterrupt) else UNKNOWN


def _complain_of_the_end(result: "Result", kept: str) -> int:
    """Say why a run ended early, and what is left of it."""
    remedy = "" if result.simulator_failed else "; give the ego a longer way, or the run a shorter --duration"
    return _complain(f"{result.ended_early.rstrip('.')}{remedy}; {kept}", 3 if result.simulator_failed else 1)


def _complain(message: str, code: int) -> int:
    """Say it in one line that can be read, whatever a simulator or a file put into the message."""
    line = "".join(letter if letter.isprintable() else "?" for letter in " ".join(message.split()))
    if len(line) > LONGEST_LINE:
        line = f"{line[: LONGEST_LINE // 2]} ... {line[-LONGEST_LINE // 2 :]}"
    print(f"luxloop: error: {line}", file=sys.stderr)
    return code
