"""Which stage of the tracker costs what: the same scans, with the truth in the place of one stage after the other."""

from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from typing import Any, Literal, NamedTuple

from scenarios.files.scenario import Scenario
from scenarios.grading.frame_grade import FrameGrade
from scenarios.grading.grader import Grader
from scenarios.oracle.device_choice import OracleFactory
from scenarios.oracle.stage import Stage
from scenarios.result import Metric, Result
from scenarios.run import device, loop
from scenarios.run.device import DeviceFactory
from sensor_model.truth import ScanTruth
from sim.world import WorldFrame
from tracker.scan import Scan

Metrics = dict[str, Metric]


class BlameMetric(NamedTuple):
    """A metric that stages are blamed by."""

    name: str
    title: str
    better: Literal["less", "more"]


OF_STAGES = (
    BlameMetric("segmentation.over_rate", "split", "less"),
    BlameMetric("segmentation.under_rate", "merged", "less"),
    BlameMetric("segmentation.missed_rate", "unfound", "less"),
    BlameMetric("outliers.mirror.precision", "mirror prec.", "more"),
    BlameMetric("outliers.mirror.recall", "mirror recall", "more"),
    BlameMetric("outliers.layer_overlap.precision", "overlap prec.", "more"),
    BlameMetric("outliers.layer_overlap.recall", "overlap recall", "more"),
    BlameMetric("fit.best.heading_abs_mean_deg", "heading [deg]", "less"),
    BlameMetric("fit.best.position_abs_mean_m", "corner [m]", "less"),
)
"""What the fitting half is graded by."""

OF_TRACKS = (
    BlameMetric("mma.mma.moving_target.x_abs_mean_m", "moving x [m]", "less"),
    BlameMetric("mma.mma.moving_target.y_abs_mean_m", "moving y [m]", "less"),
    BlameMetric("mma.mode_accuracy", "mode accuracy", "more"),
    BlameMetric("track.hota", "HOTA", "more"),
    BlameMetric("track.idf1", "IDF1", "more"),
    BlameMetric("track.missed", "missed", "less"),
    BlameMetric("track.false", "false", "less"),
    BlameMetric("track.id_switches", "id switches", "less"),
    BlameMetric("track.occlusion_survival", "survival", "more"),
)
"""What the whole tracker is graded by."""

BLAME_METRICS = (*OF_STAGES, *OF_TRACKS)

SHOWN_DIGITS = 3
"""Of differences; smaller ones are none."""


@dataclass(frozen=True, slots=True)
class Blame:
    """The shipped tracker beside its oracles."""

    shipped: Result
    by_truth: dict[Stage, Metrics]
    """Metrics with the truth in the place of one stage."""

    def gain(self, stage: Stage, headline: BlameMetric) -> float | None:
        """How much better the truth for a stage makes a metric, in its unit; None where it does not apply to both."""
        as_is, by_truth = self.shipped.metrics[headline.name].value, self.by_truth[stage][headline.name].value
        if as_is is None or by_truth is None:
            return None
        gain = by_truth - as_is if headline.better == "more" else as_is - by_truth
        return round(gain, SHOWN_DIGITS) + 0.0  # no negative zero

    def ranking(self, headline: BlameMetric) -> list[Stage]:
        """The stages whose truth makes a metric better, the one that gains most first."""
        gains = {stage: self.gain(stage, headline) or 0.0 for stage in Stage}
        return sorted((stage for stage in Stage if gains[stage] > 0.0), key=lambda stage: -gains[stage])


def find_out(
    scenario: Scenario,
    shipped: DeviceFactory | None = None,
    make_oracle: Callable[[Sequence[Stage]], DeviceFactory] = OracleFactory,
) -> Blame:
    """Run the shipped tracker, and beside it one oracle for each stage.

    All are shown the same scans, unless the tracker drives the ego (`[control]`): what it says then changes what comes
    next, and each has a simulation to itself.

    Parameters
    ----------
    shipped, make_oracle
        Other trackers than the shipped one and its oracles, to test blame itself with.

    Raises
    ------
    Exception
        As `scenarios.run.loop.run`.
    """
    shipped = shipped or device.load(device.SHIPPED)
    if scenario.control:
        result = loop.run(scenario, shipped)
        return Blame(result, {stage: loop.run(scenario, make_oracle([stage])).metrics for stage in Stage})
    beside = {stage: _Beside(scenario, make_oracle([stage])) for stage in Stage}

    def show(frame: WorldFrame, scan: Scan, truth: ScanTruth, _: FrameGrade) -> None:
        for oracle in beside.values():
            oracle.add(frame, scan, truth)

    result = loop.run(scenario, shipped, export=show)
    return Blame(result, {stage: oracle.finish() for stage, oracle in beside.items()})


class _Beside:
    """A device that is graded on the scans of another one's run."""

    def __init__(self, scenario: Scenario, make_device: DeviceFactory) -> None:
        self._device = make_device(scenario.tracker)
        self._grader = Grader(scenario.grading)

    def add(self, frame: WorldFrame, scan: Scan, truth: ScanTruth) -> None:
        device.show_truth(self._device, frame, truth)
        self._grader.add(frame, scan, truth, *device.step(self._device, scan))

    def finish(self) -> Metrics:
        metrics, _ = self._grader.finish()
        return metrics


def document(blame: Blame) -> dict[str, Any]:
    """Everything for JSON: the headlines as shipped and by the truth for each stage, and whom they blame."""
    result = blame.shipped

    def headlines(metrics: Metrics) -> dict[str, Any]:
        return {headline.name: asdict(metrics[headline.name]) for headline in BLAME_METRICS}

    return {
        "scenario": result.scenario,
        "seed": result.seed,
        "trace_hash": result.trace_hash,
        "complete": result.complete,
        "ended_early": result.ended_early,
        "frames": result.frames,
        "shipped": headlines(result.metrics),
        "by_truth": {stage: headlines(metrics) for stage, metrics in blame.by_truth.items()},
        "ranking": {headline.name: blame.ranking(headline) for headline in BLAME_METRICS},
    }
