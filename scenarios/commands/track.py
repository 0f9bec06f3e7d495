"""`luxloop track`."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from luxloop.printable import print_text
from luxloop.scenarios.commands.arguments import DEFAULT_STEP_TIMEOUT_S, AsJson, Full, StepTimeout, Tracker

if TYPE_CHECKING:
    from luxloop.scenarios.recordings.track_recording import Tracked


def track(
    recording: Annotated[Path, typer.Argument(metavar="RECORDING", help="A folder that `luxloop import` wrote.")],
    tracker: Tracker = None,
    scenario: Annotated[
        str | None,
        typer.Option(metavar="SCENARIO", help="Scenario whose [tracker], [grading] and [expect] are used."),
    ] = None,
    out: Annotated[Path | None, typer.Option(help="Folder of the results; runs/RECORDING-tracks if left out.")] = None,
    as_json: AsJson = False,
    full: Full = False,
    no_recording: Annotated[bool, typer.Option("--no-recording", help="Write no recording.rrd.")] = False,
    step_timeout: StepTimeout = DEFAULT_STEP_TIMEOUT_S,
) -> None:
    """Run a tracker over recorded scans: tracks, a report with pictures, and a recording for the viewer."""
    from luxloop.scenarios.execute import file_name
    from luxloop.scenarios.files.expect import exit_code, verdict
    from luxloop.scenarios.recordings.graded_recording import rules_of
    from luxloop.scenarios.recordings.recording import Recording
    from luxloop.scenarios.recordings.track_recording import track_recording
    from luxloop.scenarios.run import device

    scans = Recording(recording)
    name = tracker or device.SHIPPED
    other = "" if name == device.SHIPPED else f"-{file_name(device.short_name(name))}"
    out = out or Path("runs") / f"{scans.name}-tracks{other}"
    scans.refuse_to_write_to(out)
    tracked = track_recording(
        scans,
        device.load(name),
        rules_of(scans, scenario),
        name,
        out,
        record=not no_recording,
        step_timeout_s=step_timeout,
    )
    _show(tracked, out, as_json, full, recorded=not no_recording)
    raise typer.Exit(exit_code(verdict(tracked.checks, complete=True)))


def _show(tracked: "Tracked", out: Path, as_json: bool, full: bool, *, recorded: bool) -> None:
    """Print the first screen, the whole report or JSON."""
    import json

    from luxloop.scenarios.recordings.track_recording import PAGE
    from luxloop.scenarios.report import first_screen, text
    from luxloop.scenarios.run import run_folder

    result, checks = tracked.result, tracked.checks
    if as_json:
        print_text(json.dumps({**run_folder.document(result, checks), "out": str(out)}, allow_nan=False))
    elif full:
        text.show(tracked.report)
        print_text(f"Results are in {out}; the report is {out / PAGE}" + (f"; to view: luxloop view {out}" * recorded))
    else:
        commands = first_screen.commands_of(out, recorded=recorded, page=out / PAGE)
        first_screen.show(result, checks, commands, str(out / run_folder.REPORT), tracked.facts)
