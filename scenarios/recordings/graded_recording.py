"""A tracker on recorded scans: tracks, metrics and tables, with the reason for each metric that does not apply."""

from collections.abc import Callable
from dataclasses import asdict
from typing import Any

from luxloop.scenarios.grading.frame_grade import FrameGrade
from luxloop.scenarios.grading.grader import Grader
from luxloop.scenarios.grading.metric_names import CONTROL, METRICS
from luxloop.scenarios.grading.track_metric_names import BANDED_NAMES, SEEN
from luxloop.scenarios.recordings.recording import Recording
from luxloop.scenarios.recordings.recording_rules import Rules
from luxloop.scenarios.result import Metric, Result
from luxloop.scenarios.run import car_ahead, progress, versions
from luxloop.scenarios.run.compilation import compilation_reported
from luxloop.scenarios.run.device import DeviceFactory
from luxloop.scenarios.run.guard import Guard, guarded
from luxloop.scenarios.run.stopwatch import Stopwatch
from luxloop.scenarios.run.time_limit import START_FACTOR, STEP_TIMEOUT_S
from luxloop.scenarios.run.trace_hash import TraceHash
from luxloop.sensor_model.truth import ScanTruth
from luxloop.sim.world import WorldFrame
from luxloop.tracker.records import StepTrace, Tracks
from luxloop.tracker.scan import Scan

Observer = Callable[[WorldFrame, Scan, ScanTruth, Tracks, StepTrace | None, FrameGrade], None]
"""Receives every frame with its results, to write tracks, pictures and a recording."""

NO_TRUTH = "the recording has no true poses"
NO_SIMULATION = "the scans were recorded, not simulated"
UNKNOWN = {
    "sim.": NO_SIMULATION,
    "outliers.": "causes of single points are not known in a recording",
    "track.occlusion": "occlusion is not known in a recording",
    "track.hidden": "occlusion is not known in a recording",
    "track.reacquire": "occlusion is not known in a recording",
    "track.reappearance": "occlusion is not known in a recording",
    "track.id_switches_in_view": "occlusion is not known in a recording",
    "fit.best.bound": "the range noise of the sensor is not known",
    **{f"{kind}.{view}.": "visible sides are not known in a recording"
       for kind in ("fit", "dataset") for view in SEEN},
    **{f"{name}.by_view.": "visible sides are not known in a recording" for name in BANDED_NAMES},
}  # fmt: skip
"""Reasons by the beginning of the names of metrics that need more truth than poses."""


def run_tracker(
    recording: Recording,
    make_device: DeviceFactory,
    rules: Rules,
    name: str,
    observe: Observer | None = None,
    step_timeout_s: float = STEP_TIMEOUT_S,
) -> Result:
    """Run a tracker over a recording and grade it as far as the recording has truth.

    A separate instance compiles the kernels before timing.

    Raises
    ------
    OutputError, ContractError
        The recording is damaged; the tracker failed, took too long, or returned invalid tracks.
    """
    with (
        progress.start(recording.name) as report,
        compilation_reported(report),
        guarded(make_device, rules.tracker, START_FACTOR * step_timeout_s, "warm-up, ") as unused,
    ):
        for _, scan in zip(range(car_ahead.FRAMES), recording.scans(), strict=False):
            unused.checked(unused.step(scan), scan)
    with guarded(make_device, rules.tracker, step_timeout_s) as tracker:
        return grade_device(recording, tracker, rules, name, observe, timed=True)


def grade_device(
    recording: Recording, tracker: Guard, rules: Rules, name: str, observe: Observer | None = None, *, timed: bool
) -> Result:
    """Grade a device on a recording; `timed` measures its steps."""
    stopwatch, trace_hash, grader = Stopwatch(), TraceHash(), Grader(rules.grading)
    frames = progress.steps("track", len(recording), "scans", recording.frames())
    for frame, scan, truth in frames:
        tracks, trace = tracker.checked(stopwatch.time("tracker", tracker.step, scan), scan)
        grade = grader.add(frame, scan, truth, tracks, trace)
        trace_hash.add(scan, tracks)
        if observe:
            observe(frame, scan, truth, tracks, trace, grade)
    metrics, tables = grader.finish()
    measured = stopwatch.stage("tracker") if timed else {}
    if not recording.has_truth:  # every track would be false
        tables = {key: table for key, table in tables.items() if not key.startswith("snapshot")}
        tables["tracks"] = tables["tracks"].assign(verdict=_ungraded(tables["tracks"]["verdict"]))
    return Result(
        scenario=recording.name,
        seed=0,
        trace_hash=trace_hash.hexdigest(),
        ended_early="",
        simulator_failed=False,
        frames=len(recording),
        metrics={**_applicable(metrics, recording.has_truth), **_not_simulated(), **measured},
        tables=tables,
        config=_config(recording, rules, name),
        versions=versions.installed(),
    )


def _ungraded(verdict: Any) -> Any:
    """Return the verdicts of tracks without truth: "false" becomes "ungraded"."""
    return verdict.mask(verdict == "false", "ungraded")


def _applicable(metrics: dict[str, Metric], has_truth: bool) -> dict[str, Metric]:
    """Return metrics without the values that need more truth than the recording has."""
    return {name: _judged(name, metric, has_truth) for name, metric in metrics.items()}


def _judged(name: str, metric: Metric, has_truth: bool) -> Metric:
    if not has_truth:
        return Metric(None, metric.unit, 0, NO_TRUTH)
    reason = next((reason for start, reason in UNKNOWN.items() if name.startswith(start)), None)
    return metric if reason is None else Metric(None, metric.unit, 0, reason)


def _not_simulated() -> dict[str, Metric]:
    names = [name for name in METRICS if name in CONTROL or name.startswith("perf.")]
    return {name: Metric(None, METRICS[name], 0, NO_SIMULATION) for name in names}


def _config(recording: Recording, rules: Rules, name: str) -> dict[str, Any]:
    """Return the settings of the run, with the keys of a run folder that reports read."""
    summary = recording.summary
    description = (
        f"A recording: {', '.join(summary['files'])}, {len(recording)} scans of {summary['duration_s']:.1f} s."
    )
    return {
        "description": description,
        "reason": "",
        "recording": {key: value for key, value in summary.items() if key != "versions"},
        "tracker": asdict(rules.tracker),
        "grading": asdict(rules.grading),
        "expect": {key: asdict(limit) for key, limit in rules.expect.items()},
        "control": None,
        "device": name,
    }
