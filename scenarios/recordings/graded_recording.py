"""Grading of a recording with true poses: a tracker, or a file of tracks, by the rules of a scenario."""

from collections.abc import Callable
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from luxloop.scenarios.errors import InputError
from luxloop.scenarios.files import shipped
from luxloop.scenarios.files.expect import Limit
from luxloop.scenarios.files.scenario import Scenario
from luxloop.scenarios.grading.figures import Figures
from luxloop.scenarios.grading.frame_truth import FrameGrade
from luxloop.scenarios.grading.grader import Grader
from luxloop.scenarios.grading.grading_config import GradingConfig
from luxloop.scenarios.metrics import of_recordings
from luxloop.scenarios.offline.track_file import TrackFile
from luxloop.scenarios.recordings.recording import Recording
from luxloop.scenarios.result import Result
from luxloop.scenarios.run import device, progress, versions
from luxloop.scenarios.run.device import DeviceFactory
from luxloop.scenarios.run.guard import Guard, guarded, warm_up
from luxloop.scenarios.run.process_tracker import STEP_TIMEOUT_S
from luxloop.scenarios.run.stopwatch import Stopwatch
from luxloop.scenarios.run.trace_hash import TraceHash
from luxloop.sensor_model.truth import ScanTruth
from luxloop.sim.world import WorldFrame
from luxloop.tracker.records import StepTrace, Tracks
from luxloop.tracker.scan import Scan
from luxloop.tracker.tracker import TrackerConfig

USUAL_PERIOD_S = 0.08
"""[s] Scan period for which the defaults of the tracker are meant, that of the LUX at 12.5 Hz."""


@dataclass(frozen=True, slots=True)
class Rules:
    """Settings of a run over a recording."""

    tracker: TrackerConfig = field(default_factory=TrackerConfig)
    grading: GradingConfig = field(default_factory=GradingConfig)
    expect: dict[str, Limit] = field(default_factory=dict)


def rules_of(recording: Recording, scenario: str | None) -> Rules:
    """Return the settings of a scenario, by name or path, or the defaults for the scan period of a recording.

    Raises
    ------
    ScenarioError
        The scenario does not exist, or is invalid.
    """
    if scenario is None:
        return Rules(_for_period(TrackerConfig(), recording))
    chosen = Scenario.load(shipped.find(scenario))
    return Rules(chosen.tracker, chosen.grading, chosen.expect)


def _for_period(config: TrackerConfig, recording: Recording) -> TrackerConfig:
    """Return settings in which a tentative and a confirmed track survive as many missed scans as at the usual period.

    Both limits are times. At 4 Hz the default of tentative tracks is shorter than one scan period, and none would
    survive a missed scan.
    """
    period_s = float(np.median(np.diff(recording.time_s))) if len(recording) > 1 else USUAL_PERIOD_S
    factor = max(1.0, period_s / USUAL_PERIOD_S)
    confirmation = replace(
        config.confirmation,
        tentative_coast_s=factor * config.confirmation.tentative_coast_s,
        gap_s=factor * config.confirmation.gap_s,
    )
    return replace(config, confirmation=confirmation)


Observer = Callable[[WorldFrame, Scan, ScanTruth, Tracks, StepTrace | None, FrameGrade], None]
"""Receives every frame with its results, to write tracks, pictures and a recording."""


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
    warm_up(make_device, rules.tracker, recording.name, recording.frames(), step_timeout_s)
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
    measured = of_recordings.not_simulated() | (stopwatch.stage("tracker") if timed else {})
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
        metrics=Figures(metrics.run, measured, of_recordings.why_not(recording.has_truth)),
        tables=tables,
        config=_config(recording, rules, name),
        versions=versions.installed(),
    )


def _ungraded(verdict: Any) -> Any:
    """Return the verdicts of tracks without truth: "false" becomes "ungraded"."""
    return verdict.mask(verdict == "false", "ungraded")


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


def grade_recording(
    folder: Path,
    tracks: Path | None,
    tracker: str | None,
    scenario: str | None,
    step_timeout_s: float = STEP_TIMEOUT_S,
) -> Result:
    """Grade tracks on a recording, or a tracker; without either, the shipped tracker.

    Parameters
    ----------
    folder
        Folder of the recording.
    tracks
        File of tracks, see docs/own-tracker.md.
    tracker
        `MODULE:NAME` of a tracker.
    scenario
        Scenario whose settings are used, by name or path.
    step_timeout_s
        Limit of one step of the tracker [s].

    Raises
    ------
    InputError
        The recording has no true poses or is damaged, or the tracks do not fit it.
    """
    recording = Recording(folder)
    if not recording.has_truth:
        raise InputError(f"{folder}: has no true poses to grade by; import it with --truth, or use luxloop track")
    rules = rules_of(recording, scenario)
    if tracks:
        file = TrackFile(tracks, recording.time_s)
        with guarded(file.as_device, rules.tracker) as device_of_file:
            result = grade_device(recording, device_of_file, rules, str(tracks), timed=False)
        return replace(result, warnings=(*result.warnings, *file.warnings))
    name = tracker or device.SHIPPED
    return run_tracker(recording, device.load(name), rules, name, step_timeout_s=step_timeout_s)
