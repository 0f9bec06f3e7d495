"""`luxloop grade`."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from luxloop.scenarios.commands.arguments import DEFAULT_STEP_TIMEOUT_S, AsJson, Full, StepTimeout, finite
from luxloop.scenarios.commands.grade_files import (
    GOSPA_CUTOFF_M,
    HIT_IOU_MIN,
    OccludedMax,
    RangeMax,
    TracksFormat,
    TruthFormat,
    grade_files,
)

if TYPE_CHECKING:
    from luxloop.scenarios.files.expect import Check
    from luxloop.scenarios.files.scenario import Scenario
    from luxloop.scenarios.offline.recorded_run import RecordedRun
    from luxloop.scenarios.result import Result


def grade(
    run: Annotated[
        Path | None, typer.Argument(metavar="RUN", help="A folder that `luxloop run` or `luxloop import` wrote.")
    ] = None,
    tracks: Annotated[
        Path | None, typer.Option(metavar="FILE", help="File of tracks that another program made from the run's scans.")
    ] = None,
    truth: Annotated[
        Path | None, typer.Option(metavar="FILE", help="File of true boxes, instead of RUN; see docs/formats.md.")
    ] = None,
    fits: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="File of rectangles fitted to single frames; only with --truth."),
    ] = None,
    truth_format: TruthFormat = None,
    tracks_format: TracksFormat = None,
    classes: Annotated[
        str | None, typer.Option(metavar="NAME,...", help="Classes of the truth to grade; only with --truth.")
    ] = None,
    hit_iou: Annotated[
        float,
        typer.Option(
            metavar="IOU", callback=finite, help="Least overlap of a hit of MOTA and IDF1; only with --truth."
        ),
    ] = HIT_IOU_MIN,
    gospa_cutoff: Annotated[
        float, typer.Option(metavar="M", callback=finite, help="Cut-off distance c of GOSPA; only with --truth.")
    ] = GOSPA_CUTOFF_M,
    points_min: Annotated[
        int, typer.Option(metavar="N", min=0, help="Leave out true boxes of fewer points; only with --truth.")
    ] = 0,
    range_max: RangeMax = None,
    occluded_max: OccludedMax = None,
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
    full: Full = False,
    step_timeout: StepTimeout = DEFAULT_STEP_TIMEOUT_S,
) -> None:
    """Grade a run again without simulation, a recording with true poses, or any tracks against any truth in files."""
    from luxloop.scenarios.errors import InputError
    from luxloop.scenarios.files.expect import exit_code, verdict

    if tracks and tracker:
        raise InputError("--tracks and --tracker are both given; give one, or none for the run's own tracks")
    if run is None:
        _refuse_options({"--tracker": tracker, "--scenario": scenario}, "needs RUN")
        limits = (hit_iou, gospa_cutoff, points_min, range_max, occluded_max)
        grade_files(truth, tracks, fits, (truth_format, tracks_format), classes, limits, out, as_json)
        return
    of_files = {"--truth": truth, "--fits": fits, "--truth-format": truth_format, "--tracks-format": tracks_format}
    other_limits = {
        "--hit-iou": hit_iou if hit_iou != HIT_IOU_MIN else None,
        "--gospa-cutoff": gospa_cutoff if gospa_cutoff != GOSPA_CUTOFF_M else None,
        "--points-min": points_min or None,
        "--range-max": range_max,
        "--occluded-max": occluded_max,
    }
    _refuse_options({**of_files, "--classes": classes, **other_limits}, "cannot be given with RUN")
    result, checks = _graded_folder(run, tracks, tracker, scenario, out, step_timeout)
    _deliver(result, checks, run, out, as_json, full)
    raise typer.Exit(exit_code(verdict(checks, result.complete)))


def _refuse_options(options: dict[str, object], why: str) -> None:
    """Raise an InputError for the first option that is given."""
    from luxloop.scenarios.errors import InputError

    for name, given in options.items():
        if given is not None:
            raise InputError(f"{name} {why}; give either RUN, or --truth FILE and --tracks FILE")


def _graded_folder(
    run: Path, tracks: Path | None, tracker: str | None, scenario: str | None, out: Path | None, step_timeout_s: float
) -> "tuple[Result, list[Check]]":
    """Grade a run or a recording."""
    from luxloop.scenarios.files import shipped
    from luxloop.scenarios.files.expect import check
    from luxloop.scenarios.files.scenario import Scenario
    from luxloop.scenarios.offline.recorded_run import RecordedRun
    from luxloop.scenarios.recordings.graded_recording import grade_recording
    from luxloop.scenarios.recordings.recording import Recording, is_recording

    if is_recording(run):
        if out:
            Recording(run).refuse_to_write_to(out)
        return grade_recording(run, tracks, tracker, scenario, step_timeout_s)
    _refuse_tracked_recording(run)
    recorded = RecordedRun.open(run)
    if out:
        recorded.refuse_to_write_to(out)
    rules = Scenario.load(shipped.find(scenario)) if scenario else recorded.scenario
    result = _graded(recorded, rules, tracks, tracker, step_timeout_s)
    return result, check(result.metrics, rules.expect, result.config["device"])


def _refuse_tracked_recording(run: Path) -> None:
    """Raise an InputError for the results of `luxloop track`, whose truth is in the recording."""
    from luxloop.scenarios.errors import InputError
    from luxloop.scenarios.recordings.track_recording import TRACKS

    if (run / TRACKS).is_file():
        raise InputError(
            f"{run}: results of luxloop track; grade the recording: luxloop grade RECORDING --tracks {run / TRACKS}"
        )


def _graded(
    recorded: "RecordedRun", rules: "Scenario", tracks: Path | None, tracker: str | None, step_timeout_s: float
) -> "Result":
    from luxloop.scenarios.offline.regrade import Regrader
    from luxloop.scenarios.run import device

    regrader = Regrader(recorded, rules)
    if tracks:
        return regrader.track_file(tracks)
    if tracker:
        return regrader.tracker(device.load(tracker), tracker, step_timeout_s)
    return regrader.tables()


def _deliver(result: "Result", checks: "list[Check]", run: Path, out: Path | None, as_json: bool, full: bool) -> None:
    """Write the folder if one is given, and print the document, the first screen or the full report."""
    import json

    from luxloop.scenarios.report import first_screen, text
    from luxloop.scenarios.run import run_folder

    printed = text.report(result, checks)
    if out:
        with run_folder.create(out) as folder:
            run_folder.write(folder, result, checks, text.as_text(printed))
    if as_json:
        print(json.dumps({**run_folder.document(result, checks), "out": out and str(out)}, allow_nan=False))
    elif full:
        text.show(printed)
        print(f"Results are in {out}" if out else "Nothing was written; to keep it, give --out")
    elif out:
        first_screen.show_folder(result, checks, out, recorded=False)
    else:
        keep = {f"luxloop grade {run} --out DIR": "nothing was written; this keeps it"}
        first_screen.show(result, checks, keep, "--full prints the whole report")
