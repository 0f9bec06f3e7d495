"""`luxloop grade`."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from scenarios.commands.arguments import DEFAULT_STEP_TIMEOUT_S, AsJson, StepTimeout

if TYPE_CHECKING:
    from scenarios.files.expect import Check
    from scenarios.files.scenario import Scenario
    from scenarios.offline.recorded_run import RecordedRun
    from scenarios.result import Result


def grade(
    run: Annotated[Path, typer.Argument(metavar="RUN", help="A folder that `luxloop run` or `luxloop import` wrote.")],
    tracks: Annotated[
        Path | None, typer.Option(metavar="FILE", help="File of tracks that another program made from the run's scans.")
    ] = None,
    tracker: Annotated[
        str | None,
        typer.Option(metavar="MODULE:NAME", help="A tracker to run on the scans, as for luxloop run."),
    ] = None,
    scenario: Annotated[
        str | None,
        typer.Option(metavar="SCENARIO", help="Scenario whose [grading] and [expect] replace the run's."),
    ] = None,
    out: Annotated[Path | None, typer.Option(help="Folder of the results; if left out, they are only printed.")] = None,
    as_json: AsJson = False,
    step_timeout: StepTimeout = DEFAULT_STEP_TIMEOUT_S,
) -> None:
    """Grade a run again without simulation, or a recording with true poses: its own tracks, or other ones."""
    from scenarios.errors import InputError
    from scenarios.files import shipped
    from scenarios.files.expect import check, verdict
    from scenarios.files.scenario import Scenario
    from scenarios.offline.recorded_run import RecordedRun
    from scenarios.recordings.grade_recording import grade_recording
    from scenarios.recordings.recording import Recording, is_recording

    if tracks and tracker:
        raise InputError("--tracks and --tracker are both given; give one, or none for the run's own tracks")
    if is_recording(run):
        if out:
            Recording(run).refuse_to_write_to(out)
        result, checks = grade_recording(run, tracks, tracker, scenario, step_timeout)
    else:
        _refuse_tracked_recording(run)
        recorded = RecordedRun.open(run)
        if out:
            recorded.refuse_to_write_to(out)
        rules = Scenario.load(shipped.find(scenario)) if scenario else recorded.scenario
        result = _graded(recorded, rules, tracks, tracker, step_timeout)
        checks = check(result.metrics, rules.expect, result.config["device"])
    _deliver(result, checks, out, as_json)
    raise typer.Exit(0 if verdict(checks, result.complete) == "passed" else 1)


def _refuse_tracked_recording(run: Path) -> None:
    """Raise an InputError for the results of `luxloop track`, whose truth is in the recording."""
    from scenarios.errors import InputError
    from scenarios.recordings.track_recording import TRACKS

    if (run / TRACKS).is_file():
        raise InputError(
            f"{run}: results of luxloop track; grade the recording: luxloop grade RECORDING --tracks {run / TRACKS}"
        )


def _graded(
    recorded: "RecordedRun", rules: "Scenario", tracks: Path | None, tracker: str | None, step_timeout_s: float
) -> "Result":
    from scenarios.offline.regrade import Regrader
    from scenarios.run import device

    regrader = Regrader(recorded, rules)
    if tracks:
        return regrader.track_file(tracks)
    if tracker:
        return regrader.tracker(device.load(tracker), tracker, step_timeout_s)
    return regrader.tables()


def _deliver(result: "Result", checks: "list[Check]", out: Path | None, as_json: bool) -> None:
    """Write the folder if one is given, and print the document or the report."""
    import json

    from scenarios.report import text
    from scenarios.run import run_folder

    printed = text.report(result, checks)
    if out:
        with run_folder.create(out) as folder:
            run_folder.write(folder, result, checks, text.as_text(printed))
    if as_json:
        print(json.dumps({**run_folder.document(result, checks), "out": out and str(out)}, allow_nan=False))
    else:
        text.show(printed)
        print(f"Results are in {out}" if out else "Nothing was written; to keep it, give --out")
