"""The run loop: traffic, LIDARs, tracker, grader, recorder."""

import math
from collections.abc import Callable
from contextlib import closing
from dataclasses import asdict
from pathlib import Path
from typing import Any

from luxloop.scenarios.control import ego_driver
from luxloop.scenarios.control.ego_driver import SafetyLog, TrackDriver, drive_by_truth
from luxloop.scenarios.errors import ScenarioError
from luxloop.scenarios.files.scenario import Scenario
from luxloop.scenarios.grading.body_points import Ranging
from luxloop.scenarios.grading.frame_truth import FrameGrade
from luxloop.scenarios.grading.grader import Grader
from luxloop.scenarios.rerun_log.recorder import NullRecorder, Recorder
from luxloop.scenarios.result import Result
from luxloop.scenarios.run import device, own_metrics, progress, termination, versions
from luxloop.scenarios.run.device import DeviceFactory
from luxloop.scenarios.run.guard import guarded, warm_up
from luxloop.scenarios.run.process_tracker import STEP_TIMEOUT_S
from luxloop.scenarios.run.scan_source import NoiseInputError, Scans, ScanSource, ScanStart
from luxloop.scenarios.run.stopwatch import RECORDING, SCANNED, Stopwatch
from luxloop.scenarios.run.trace_hash import TraceHash
from luxloop.sensor_model.rig.rig import Rig, RigError, load_rig
from luxloop.sensor_model.truth import ScanTruth
from luxloop.sim.factory import make_source, run_ahead
from luxloop.sim.source import SimulatorFailedError, TrafficEndedError, TrafficError, TrafficInputError, TrafficSource
from luxloop.sim.world import Obstacles, WorldFrame
from luxloop.tracker.scan import Scan


def run(
    scenario: Scenario,
    make_device: DeviceFactory,
    record_to: Path | None = None,
    export: Callable[[WorldFrame, Scan, ScanTruth, FrameGrade], None] | None = None,
    step_timeout_s: float = STEP_TIMEOUT_S,
    start: Callable[[Obstacles], None] | None = None,
    ahead: bool = False,
) -> Result:
    """Run a scenario and grade it.

    Parameters
    ----------
    scenario
        The scenario to run.
    make_device
        Makes the tracker, see `luxloop.scenarios.run.device`.
    record_to
        File of the recording; None records nothing.
    export
        Called with every frame, to write a data set.
    step_timeout_s
        Limit of one step of the tracker [s].
    start
        Receives the static obstacles before the first frame.
    ahead
        True to compute traffic and scans in a process of their own, ahead of tracker and grading: the same results.
        A controlled ego needs the tracks of every frame before the next, so that its run ignores this.

    Raises
    ------
    ScenarioError
        The scenario names a file or object that does not exist, or a value out of range; or its file, its rig or a
        package was changed during the run, so that the result would not say what it rests on.
    SimulatorFailedError, TrafficEndedError
        The traffic failed or ended before the first frame. If it does later, the result is incomplete.
    MetricError
        A function of a `[[metric]]` cannot be imported, fails, or returns no number.
    ContractError
        The tracker failed, took too long, or returned invalid tracks.
    """
    own_metrics.load(scenario.metric)  # a function that is not there is reported before the run
    rig, used = _rig(scenario), versions.installed()
    stopwatch, trace_hash, frames = Stopwatch(), TraceHash(), 0
    end: TrafficError | None = None
    ahead = ahead and not scenario.control
    traffic = _traffic(scenario, rig, apart=not ahead)
    scans = ScanSource(traffic, rig, scenario.noise, scenario.sensor)
    with closing(run_ahead(scans, scenario.traffic) if ahead else scans) as source:
        _require_scan_period(scenario, rig, source.dt)
        started = _reset(source, scenario)
        if start:
            start(started.obstacles)
        one_car = ((one.frame, one.scan, one.truth) for one in started.warm_up)
        warm_up(make_device, scenario.tracker, scenario.name, one_car, step_timeout_s)
        grader = Grader(scenario.grading, Ranging.of(rig, scenario.noise), rig.range_max_m)
        driver = TrackDriver(scenario.control, traffic) if scenario.control else None
        frame_count = max(1, round(scenario.duration_s / source.dt))
        recorder = _recorder(scenario, record_to, started.obstacles, frame_count)
        with closing(recorder), guarded(make_device, scenario.tracker, step_timeout_s) as tracker:
            try:
                for _ in progress.frames(frame_count, source.dt, scenario.name):
                    termination.raise_lost()
                    scanned = stopwatch.time(SCANNED, source.step)
                    frame, scan, truth = scanned.frame, scanned.scan, scanned.truth
                    stopwatch.add("sim", scanned.sim_s)
                    stopwatch.add("sensor", scanned.sensor_s)
                    tracker.show_truth(frame, truth)
                    output = stopwatch.time("tracker", tracker.step, scan)
                    tracks, trace = tracker.checked(output, scan)
                    grade = grader.add(frame, scan, truth, tracks, trace)
                    trace_hash.add(frame, scan, truth, tracks)
                    frames += 1
                    decision = driver.drive(frame, scan, tracks) if driver else None
                    stopwatch.time(RECORDING, recorder.log, frame, scan, truth, tracks, trace, grade, decision)
                    if export:
                        stopwatch.time(RECORDING, export, frame, scan, truth, grade)
            except (TrafficEndedError, SimulatorFailedError) as error:
                if not frames:
                    raise
                end = error
                if isinstance(error, TrafficEndedError):
                    grader.end(error.collisions)
            recorder.finish()
    metrics, tables = grader.finish()
    own = own_metrics.grade(scenario.metric, tables, metrics, frames)
    drives, end_by_truth = _drives(scenario, rig, driver, frames)
    control_metrics, control_tables = ego_driver.grade(drives)
    end = end or end_by_truth
    _require_unchanged(scenario, rig)
    return Result(
        scenario=scenario.name,
        seed=scenario.seed,
        trace_hash=trace_hash.hexdigest(),
        ended_early=" ".join(str(end).split()) if end else "",
        simulator_failed=isinstance(end, SimulatorFailedError),
        frames=frames,
        metrics=(metrics | {**control_metrics, **stopwatch.metrics(frames, source.dt), **own}).asked(scenario.expect),
        tables={**tables, **control_tables},
        config=_effective_config(scenario, rig, make_device, source.ego_name),
        versions=used,
        warnings=source.warnings,
    )


def _rig(scenario: Scenario) -> Rig:
    """Read the rig. Errors name its file and the scenario."""
    try:
        return load_rig(str(scenario.rig), scenario.folder)
    except RigError as error:
        key = "file" if scenario.rig.name is None else "name"
        raise ScenarioError(f'{scenario.path}: rig.{key} = "{scenario.rig}": {error}') from error


def _require_unchanged(scenario: Scenario, rig: Rig) -> None:
    """Check that scenario, limits, rig and versions are those that were read before the tracker started."""
    scenario.require_unchanged()
    if _rig(scenario) != rig:
        raise ScenarioError(f"{scenario.path}: its rig {scenario.rig} was changed during the run; run it again")
    versions.require_unchanged()


def _traffic(scenario: Scenario, rig: Rig, apart: bool = True) -> TrafficSource:
    """Make the traffic source of a scenario, which delivers actors up to the longest range of any LIDAR."""
    return make_source(scenario.traffic, scenario.folder, rig.range_max_m, apart)


def _drives(
    scenario: Scenario, rig: Rig, driver: TrackDriver | None, frames: int
) -> tuple[dict[str, SafetyLog], TrafficError | None]:
    """Repeat the drive with ground truth. Return both drives, and the reason why the second one ended early, if any."""
    if not (scenario.control and driver):
        return {}, None
    by_truth = SafetyLog()
    drives = {"tracks": driver.log, "truth": by_truth}
    try:
        with closing(_traffic(scenario, rig)) as source:
            source.reset(scenario.seed)
            drive_by_truth(scenario.control, source, by_truth, frames)
    except (TrafficEndedError, SimulatorFailedError) as end:
        return drives, end
    return drives, None


def _reset(source: Scans, scenario: Scenario) -> ScanStart:
    """Start traffic and LIDARs. Their errors get the path of the scenario file, which they do not know."""
    try:
        with progress.start(scenario.name) as report:
            source.report_start = report
            return source.reset(scenario.seed)
    except TrafficInputError as error:
        table = "noise" if isinstance(error, NoiseInputError) else "traffic"
        raise ScenarioError(f"{scenario.path}: {table}: {error}") from error


def _recorder(scenario: Scenario, record_to: Path | None, obstacles: Obstacles, frames: int) -> Recorder | NullRecorder:
    if record_to is None:
        return NullRecorder()
    return Recorder(record_to, scenario.name, obstacles, controlled=scenario.control is not None, frames=frames)


def _require_scan_period(scenario: Scenario, rig: Rig, dt: float) -> None:
    """Check, before the traffic starts, that its time step is the scan period: the LIDARs scan once per frame.

    The buffers of the truth layer last a time, so that a tiny step would fill the memory.
    """
    if not math.isclose(dt * rig.scan_rate_hz, 1.0):
        raise ScenarioError(
            f"{scenario.path}: traffic steps {dt} s, but rig {scenario.rig} scans at {rig.scan_rate_hz} Hz; "
            f"step {1.0 / rig.scan_rate_hz!r} s (traffic.dt_s), or choose another rig"
        )


def _effective_config(scenario: Scenario, rig: Rig, make_device: DeviceFactory, ego: str) -> dict[str, Any]:
    """Return the whole configuration of the run, including defaults, the content of the rig files and the ego's id."""
    config = {**scenario.model_dump(mode="json"), "rig": asdict(rig), "device": device.name_of(make_device)}
    config |= {"in_process": True} if device.is_in_process(make_device) else {}
    return config | ({"ego": ego} if ego else {}) | ({"set": list(scenario.settings)} if scenario.settings else {})
