"""Regrading of a run without simulation: from its tables, or from its scans and other tracks."""

from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

import pandas as pd

from luxloop.scenarios.errors import ScenarioError
from luxloop.scenarios.files import shipped
from luxloop.scenarios.files.scenario import Scenario
from luxloop.scenarios.grading import grader
from luxloop.scenarios.grading.body_points import Ranging
from luxloop.scenarios.grading.figures import Figures
from luxloop.scenarios.grading.occlusions import occlusion_table
from luxloop.scenarios.metrics.definitions import OF_LOOP, find_metric
from luxloop.scenarios.metrics.own_metric import PREFIX
from luxloop.scenarios.offline.recorded_scans import RecordedRun, RecordedScans
from luxloop.scenarios.offline.track_file import TrackFile
from luxloop.scenarios.result import Metric, Result
from luxloop.scenarios.run import device, own_metrics, versions
from luxloop.scenarios.run.device import DeviceFactory
from luxloop.scenarios.run.guard import Guard, guarded, warm_up
from luxloop.scenarios.run.process_tracker import STEP_TIMEOUT_S
from luxloop.scenarios.run.stopwatch import Stopwatch
from luxloop.scenarios.run.trace_hash import TraceHash

SIMULATORS = ("libsumo", "highway-env")
"""Packages whose versions are those of the original run."""


class Regrader:
    """Grades a run with its own limits and expectations, or with those of another scenario.

    Parameters
    ----------
    run
        The run.
    rules
        Scenario with the `[grading]` and `[expect]` to use.
    """

    def __init__(self, run: RecordedRun, rules: Scenario) -> None:
        self._run = run
        self._grading = rules.grading
        self._expect = rules.expect
        self._own = rules.metric

    def tables(self) -> Result:
        """Grade the tables of the run; timing and safety metrics are copied.

        Raises
        ------
        ScenarioError
            A limit that applies frame by frame differs from that of the run.
        """
        run = self._run
        for name in grader.PER_FRAME:
            then, now = (getattr(config, name) for config in (run.scenario.grading, self._grading))
            if then != now:
                raise ScenarioError(
                    f"grading.{name} = {now:g}: the tables of {run.folder} were made with {then:g}; "
                    "grade its recorded scans with --tracker or --tracks, or use the same limit"
                )
        tables = dict(run.result.tables)
        tables["occlusions"] = occlusion_table(tables["truth"], tables["tracks"], self._grading, tables.get("blockers"))
        metrics = grader.grade(tables, self._grading, run.result.frames) | self._of_loop()
        return self._result(metrics, tables, run.result.trace_hash, run.result.config["device"])

    def track_file(self, path: Path) -> Result:
        """Grade a file of tracks that another program produced from the run's scans.

        Raises
        ------
        OutputError, TracksError
            The run has no scans; the file has an invalid layout.
        """
        scans = self._run.scans()
        file = TrackFile(path, scans.time_s)
        with guarded(file.as_device, self._run.scenario.tracker) as tracks:
            result = self._replay(scans, tracks, str(path), timed=False)
        return replace(result, warnings=(*result.warnings, *file.warnings))

    def tracker(self, make_device: DeviceFactory, name: str, step_timeout_s: float = STEP_TIMEOUT_S) -> Result:
        """Run a tracker on the run's scans and grade it; a separate instance compiles the kernels before timing.

        Raises
        ------
        OutputError, ContractError
            The run has no scans; the tracker failed, took too long, or returned invalid tracks.
        """
        scans, config = self._run.scans(), self._run.scenario.tracker
        warm_up(make_device, config, self._run.result.scenario, scans, step_timeout_s)
        with guarded(make_device, config, step_timeout_s) as tracker:
            return self._replay(scans, tracker, name, timed=True)

    def _replay(self, scans: RecordedScans, tracker: Guard, name: str, *, timed: bool) -> Result:
        """Grade a tracker on recorded scans: the run loop without traffic and LIDARs."""
        stopwatch, trace_hash = Stopwatch(), TraceHash()
        rig = self._run.rig
        ranging = Ranging.of(rig, self._run.scenario.noise)
        run_grader = grader.Grader(self._grading, ranging, rig.range_max_m)
        for frame, scan, truth in scans:
            tracker.show_truth(frame, truth)
            tracks, trace = tracker.checked(stopwatch.time("tracker", tracker.step, scan), scan)
            run_grader.add(frame, scan, truth, tracks, trace)
            trace_hash.add(frame, scan, truth, tracks)
        metrics, tables = run_grader.finish()
        measured = stopwatch.stage("tracker") if timed else {}
        return self._result(metrics | {**self._not_simulated(), **measured}, tables, trace_hash.hexdigest(), name)

    def _not_simulated(self) -> dict[str, Metric]:
        """Return the metrics that need a simulation, without a value; an earlier reason is kept."""
        reason = "recorded scans were graded, without a simulation"
        found = self._of_loop()
        return {name: Metric(None, metric.unit, 0, metric.reason or reason) for name, metric in found.items()}

    def _of_loop(self) -> dict[str, Metric]:
        """Return the metrics that the run loop measured."""
        found = self._run.result.metrics
        names = (name for name in found if not name.startswith(PREFIX))
        return {name: found[name] for name in names if find_metric(name).definition.kind in OF_LOOP}

    def _result(self, metrics: Figures, tables: dict[str, pd.DataFrame], trace_hash: str, tracked_by: str) -> Result:
        run = self._run.result
        config: dict[str, Any] = {
            **run.config,
            "grading": asdict(self._grading),
            "expect": {name: asdict(limit) for name, limit in self._expect.items()},
            "metric": [metric.model_dump(mode="json") for metric in self._own],
            "device": tracked_by,
        }
        metrics |= own_metrics.grade(self._own, tables, metrics, run.frames)
        here = {name: version for name, version in versions.installed().items() if name not in SIMULATORS}
        return Result(
            scenario=run.scenario,
            seed=run.seed,
            trace_hash=trace_hash,
            ended_early=run.ended_early,
            simulator_failed=run.simulator_failed,
            warnings=run.warnings,
            frames=run.frames,
            metrics=metrics.asked(self._expect),
            tables=tables,
            config=config,
            versions={**run.versions, **here},
        )


def grade(
    run: RecordedRun, tracks: Path | None, tracker: str | None, scenario: str | None, step_timeout_s: float
) -> Result:
    """Grade a file of tracks on the scans of a run, a tracker, or without either the run's own tables.

    Parameters
    ----------
    scenario
        Scenario whose rules are used, by name or path; default those of the run.

    Raises
    ------
    InputError, OutputError
        As the methods of `Regrader`, or there is no such scenario or tracker.
    """
    regrader = Regrader(run, Scenario.load(shipped.find(scenario)) if scenario else run.scenario)
    if tracks:
        return regrader.track_file(tracks)
    if tracker:
        return regrader.tracker(device.load(tracker), tracker, step_timeout_s)
    return regrader.tables()
