"""`luxloop track`."""

from pathlib import Path
from typing import Annotated

import typer

from luxloop.scenarios.commands.arguments import DEFAULT_STEP_TIMEOUT_S, AsJson, StepTimeout, Tracker


def track(
    recording: Annotated[Path, typer.Argument(metavar="RECORDING", help="A folder that `luxloop import` wrote.")],
    tracker: Tracker = None,
    scenario: Annotated[
        str | None,
        typer.Option(metavar="SCENARIO", help="Scenario whose [tracker], [grading] and [expect] are used."),
    ] = None,
    out: Annotated[Path | None, typer.Option(help="Folder of the results; runs/RECORDING-tracks if left out.")] = None,
    as_json: AsJson = False,
    no_recording: Annotated[bool, typer.Option("--no-recording", help="Write no recording.rrd.")] = False,
    step_timeout: StepTimeout = DEFAULT_STEP_TIMEOUT_S,
) -> None:
    """Run a tracker over recorded scans: tracks, a report with pictures, and a recording for the viewer."""
    import json

    from luxloop.scenarios.execute import file_name
    from luxloop.scenarios.files.expect import exit_code, verdict
    from luxloop.scenarios.recordings.graded_recording import rules_of
    from luxloop.scenarios.recordings.recording import Recording
    from luxloop.scenarios.recordings.track_recording import PAGE, track_recording
    from luxloop.scenarios.report import text
    from luxloop.scenarios.run import device, run_folder

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
    if as_json:
        print(json.dumps({**run_folder.document(tracked.result, tracked.checks), "out": str(out)}, allow_nan=False))
    else:
        text.show(tracked.report)
        print(
            f"Results are in {out}; the report is {out / PAGE}"
            + ("" if no_recording else f"; to view: luxloop view {out}")
        )
    raise typer.Exit(exit_code(verdict(tracked.checks, complete=True)))
