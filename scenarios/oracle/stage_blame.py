"""Cost of each stage of the tracker: grade the same scans with an oracle in place of one stage after the other."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import pandas as pd

from luxloop.scenarios.files.scenario import Scenario
from luxloop.scenarios.grading.frame_truth import FrameGrade
from luxloop.scenarios.grading.grader import Grader
from luxloop.scenarios.metrics.definitions import find_metric
from luxloop.scenarios.oracle.oracle_tracker import OracleFactory
from luxloop.scenarios.oracle.stage import Stage
from luxloop.scenarios.result import Metric, Result
from luxloop.scenarios.run import loop, progress
from luxloop.scenarios.run.device import DeviceFactory
from luxloop.scenarios.run.guard import Guard
from luxloop.scenarios.run.process_tracker import STEP_TIMEOUT_S
from luxloop.sensor_model.rig.rig import load_rig
from luxloop.sensor_model.truth import ScanTruth
from luxloop.sim.world import WorldFrame
from luxloop.tracker.scan import Scan
from luxloop.tracker.tracker import Tracker

Metrics = Mapping[str, Metric]
Tables = dict[str, pd.DataFrame]
COST_METRIC = "track.hota"
"""Metric of the answer in one line."""


OF_STAGES = {
    "segmentation.over_rate": "split",
    "segmentation.under_rate": "merged",
    "segmentation.missed_rate": "unfound",
    "outliers.precision{cause=mirror}": "mirror prec.",
    "outliers.recall{cause=mirror}": "mirror recall",
    "outliers.precision{cause=layer_overlap}": "overlap prec.",
    "outliers.recall{cause=layer_overlap}": "overlap recall",
    "fit.heading_abs_mean_deg": "fit heading [deg]",
    "fit.position_abs_mean_m": "corner [m]",
}
"""Metrics of detection by name, with the heads of their columns."""

OF_FILTERS = {
    "mma.x_abs_mean_m{target=moving}": "moving x [m]",
    "mma.y_abs_mean_m{target=moving}": "moving y [m]",
    "mma.mode_accuracy": "mode accuracy",
    "track.moving_velocity_abs_mean_mps": "velocity [m/s]",
    "track.standing_speed_mean_mps": "standing [m/s]",
    "track.heading_flip_rate": "track heading flips",
    "track.length_abs_mean_m": "length [m]",
}
"""Metrics of the estimates of tracks."""

OF_TRACKS = {
    "track.hota": "HOTA",
    "track.idf1": "IDF1",
    "track.time_to_confirm_s": "confirm [s]",
    "track.missed": "missed",
    "track.false": "false",
    "track.false_on_nothing": "on nothing",
    "track.false_ill_fitting": "ill fitting",
    "track.id_switches": "id switches",
    "track.occlusion_survival": "survival",
}
"""Metrics of the whole tracker."""

BLAME_METRICS = (*OF_STAGES, *OF_FILTERS, *OF_TRACKS)

SHOWN_DIGITS = 3
"""Decimal digits of differences; smaller differences count as 0."""


@dataclass(frozen=True, slots=True)
class StageCost:
    """Cost of the errors of a stage in a metric: its improvement by the truth in the place of the stage."""

    stage: Stage
    value: float
    interval: tuple[float, float] | None
    """95 % interval over vehicles; None for too few of them (it would leave the range of the metric), or if each stage
    has a drive of its own."""


@dataclass(frozen=True, slots=True)
class Blame:
    """Results of a tracker, by default the shipped one, and of its oracles."""

    shipped: Result
    """Result of the tracker as it is."""
    by_truth: dict[Stage, Metrics]
    """Metrics with an oracle for one stage."""
    tables: dict[Stage, Tables]
    """Tables with an oracle for one stage, on the scans of the tracker; none if the tracks drive the ego."""

    def gain(self, stage: Stage, metric: str) -> float | None:
        """Return the improvement of a metric by the oracle of a stage, in its unit; None if it applies to one only."""
        as_is, by_truth = self.shipped.metrics[metric].value, self.by_truth[stage][metric].value
        if as_is is None or by_truth is None:
            return None
        gain = by_truth - as_is if find_metric(metric).definition.better == "more" else as_is - by_truth
        return round(gain, SHOWN_DIGITS) + 0.0  # no negative zero

    def ranking(self, metric: str) -> list[Stage]:
        """Return the stages whose oracle improves a metric, largest gain first."""
        gains = {stage: self.gain(stage, metric) or 0.0 for stage in Stage}
        return sorted((stage for stage in Stage if gains[stage] > 0.0), key=lambda stage: -gains[stage])


def find_out(scenario: Scenario, make_tracker: DeviceFactory = Tracker) -> Blame:
    """Run a tracker and one oracle for each of its stages.

    All process the same scans, unless the tracker drives the ego (`[control]`): its tracks then affect the traffic, so
    each has its own simulation.

    Parameters
    ----------
    make_tracker
        Makes a `Tracker`, the shipped one or one with stages of its own.

    Raises
    ------
    DeviceError
        It is no `Tracker`, or a stage has no parts that oracles could replace.
    Exception
        As `luxloop.scenarios.run.loop.run`.
    """
    oracles = {stage: OracleFactory([stage], make_tracker) for stage in Stage}
    if scenario.control:
        result = loop.run(scenario, make_tracker)
        return Blame(result, {stage: loop.run(scenario, oracle).metrics for stage, oracle in oracles.items()}, {})
    parallel = {stage: ParallelDevice(scenario, oracle) for stage, oracle in oracles.items()}

    def add(frame: WorldFrame, scan: Scan, truth: ScanTruth, _: FrameGrade) -> None:
        for oracle in parallel.values():
            oracle.add(frame, scan, truth)

    result = loop.run(scenario, make_tracker, export=add)
    of_oracles = progress.steps("grading", len(parallel), "stages", parallel.items())
    finished = {stage: oracle.finish() for stage, oracle in of_oracles}
    return Blame(
        result,
        {stage: metrics for stage, (metrics, _) in finished.items()},
        {stage: tables for stage, (_, tables) in finished.items()},
    )


class ParallelDevice:
    """Device that is graded on the scans of another device's run."""

    def __init__(self, scenario: Scenario, make_device: DeviceFactory) -> None:
        self._guard = Guard(make_device, scenario.tracker, STEP_TIMEOUT_S)
        rig = load_rig(str(scenario.rig), scenario.folder)
        self._grader = Grader(scenario.grading, delivered_m=rig.range_max_m)

    def add(self, frame: WorldFrame, scan: Scan, truth: ScanTruth) -> None:
        """Let the device process a scan, and grade its tracks."""
        self._guard.show_truth(frame, truth)
        self._grader.add(frame, scan, truth, *self._guard.checked(self._guard.step(scan), scan))

    def finish(self) -> tuple[Metrics, Tables]:
        """Return the metrics and the tables of all frames."""
        return self._grader.finish()


def document(blame: Blame, costs: Sequence[StageCost]) -> dict[str, Any]:
    """Return the JSON document: metrics of the tracker and of each oracle, ranking and costs of stages."""
    result = blame.shipped

    def selected(metrics: Metrics) -> dict[str, Any]:
        return {name: asdict(metrics[name]) for name in BLAME_METRICS}

    return {
        "scenario": result.scenario,
        "seed": result.seed,
        "tracker": result.config["device"],
        "trace_hash": result.trace_hash,
        "complete": result.complete,
        "ended_early": result.ended_early,
        "frames": result.frames,
        "shipped": selected(result.metrics),
        "by_truth": {stage: selected(metrics) for stage, metrics in blame.by_truth.items()},
        "costs": {COST_METRIC: {cost.stage: {"value": cost.value, "interval": cost.interval} for cost in costs}},
        "ranking": {name: blame.ranking(name) for name in BLAME_METRICS},
    }
