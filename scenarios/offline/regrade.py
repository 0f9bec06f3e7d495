"""Grading a run that is on disk, without simulating: from its tables, or from its scans and other tracks."""

from dataclasses import asdict
from pathlib import Path
from typing import Any

import pandas as pd

from scenarios.errors import ScenarioError
from scenarios.files.scenario import Scenario
from scenarios.grading import grader
from scenarios.grading.bound import Ranging
from scenarios.grading.metric_names import GRADED
from scenarios.offline.recorded_run import RecordedRun
from scenarios.offline.recorded_scans import RecordedScans
from scenarios.offline.track_file import TrackFile
from scenarios.result import Metric, Result
from scenarios.run import device, versions, warm_up
from scenarios.run.device import Device, DeviceFactory
from scenarios.run.stopwatch import Stopwatch
from scenarios.run.trace_hash import TraceHash

SIMULATORS = ("libsumo", "highway-env")
"""No part of grading."""


class Regrader:
    """Grades one run, by its own limits and expectations or by those of another scenario file.

    Parameters
    ----------
    run
        The run.
    rules
        Whose `[grading]` and `[expect]` count.
    """

    def __init__(self, run: RecordedRun, rules: Scenario) -> None:
        self._run = run
        self._grading = rules.grading
        self._expect = rules.expect

    def tables(self) -> Result:
        """Grade what the run's tables say; times and safety stay as they were measured.

        Raises
        ------
        ScenarioError
            The limits differ in what is decided frame by frame.
        """
        run = self._run
        for name in grader.PER_FRAME:
            then, now = (getattr(config, name) for config in (run.scenario.grading, self._grading))
            if then != now:
                raise ScenarioError(
                    f"grading.{name} = {now:g}: the tables of {run.folder} were made with {then:g}; "
                    "grade its recorded scans with --tracker or --tracks, or leave this limit as it was"
                )
        graded = grader.grade(run.result.tables, self._grading, run.result.frames)
        metrics = run.result.metrics | graded
        return self._result(metrics, run.result.tables, run.result.trace_hash, run.result.config["device"])

    def track_file(self, path: Path) -> Result:
        """Grade tracks that a program made of the run's scans.

        Raises
        ------
        OutputError, TracksError
            The run has no scans; the file breaks the layout.
        """
        scans = self._run.scans()
        return self._over(scans, TrackFile(path, scans.time_s), str(path), timed=False)

    def tracker(self, make_device: DeviceFactory, name: str) -> Result:
        """Let a tracker follow the run's scans, and grade it; a throw-away one compiles before the clock starts.

        Raises
        ------
        OutputError, DeviceError
            The run has no scans; the tracker returns no tracks.
        """
        scans, config = self._run.scans(), self._run.scenario.tracker
        throw_away = make_device(config)
        for _, (frame, scan, truth) in zip(range(warm_up.FRAMES), scans, strict=False):
            device.show_truth(throw_away, frame, truth)
            device.step(throw_away, scan)
        return self._over(scans, make_device(config), name, timed=True)

    def _over(self, scans: RecordedScans, tracker: Device, name: str, *, timed: bool) -> Result:
        """The run loop, without traffic and LIDARs."""
        stopwatch, trace_hash = Stopwatch(), TraceHash()
        judge = grader.Grader(self._grading, Ranging.of(self._run.rig, self._run.scenario.noise))
        for frame, scan, truth in scans:
            device.show_truth(tracker, frame, truth)
            tracks, trace = stopwatch.time("tracker", device.step, tracker, scan)
            judge.add(frame, scan, truth, tracks, trace)
            trace_hash.add(frame, scan, truth, tracks)
        metrics, tables = judge.finish()
        measured = stopwatch.stage("tracker") if timed else {}
        return self._result({**metrics, **self._not_driven(), **measured}, tables, trace_hash.hexdigest(), name)

    def _not_driven(self) -> dict[str, Metric]:
        """Metrics of what happens only where there is traffic: without a value, for this or for an older reason."""
        why = "its scans were recorded: nothing was simulated"
        of_run = {name: metric for name, metric in self._run.result.metrics.items() if name not in GRADED}
        return {name: Metric(None, metric.unit, 0, metric.reason or why) for name, metric in of_run.items()}

    def _result(
        self, metrics: dict[str, Metric], tables: dict[str, pd.DataFrame], trace_hash: str, tracked_by: str
    ) -> Result:
        run = self._run.result
        config: dict[str, Any] = {
            **run.config,
            "grading": asdict(self._grading),
            "expect": {name: asdict(limit) for name, limit in self._expect.items()},
            "device": tracked_by,
        }
        here = {name: version for name, version in versions.installed().items() if name not in SIMULATORS}
        return Result(
            scenario=run.scenario,
            seed=run.seed,
            trace_hash=trace_hash,
            ended_early=run.ended_early,
            simulator_failed=run.simulator_failed,
            frames=run.frames,
            metrics=metrics,
            tables=tables,
            config=config,
            versions={**run.versions, **here},
        )
