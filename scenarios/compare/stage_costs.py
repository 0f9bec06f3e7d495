"""Costs of the stages of the tracker with intervals over vehicles, as of a comparison of two trackers."""

from luxloop.scenarios.compare.compared_metrics import COMPARED_METRICS
from luxloop.scenarios.compare.resampling import differences
from luxloop.scenarios.compare.vehicle_sums import vehicle_sums
from luxloop.scenarios.grading.grading_config import GradingConfig
from luxloop.scenarios.oracle.stage import Stage
from luxloop.scenarios.oracle.stage_blame import COST_METRIC, OF_TRACKS, Blame, StageCost

(COMPARED,) = (metric for metric in COMPARED_METRICS if metric.name == COST_METRIC)
(BLAMED,) = (metric for metric in OF_TRACKS if metric.name == COST_METRIC)


def stage_costs(blame: Blame) -> list[StageCost]:
    """Return the cost of each stage in `COST_METRIC`, the largest first; none without a value of the metric.

    Vehicles are paired: all oracles process the scans of the shipped tracker. If the tracks drive the ego, the drives
    differ, and there are no intervals.
    """
    found = [(stage, blame.gain(stage, BLAMED)) for stage in Stage]
    costs = [StageCost(stage, gain, _interval(blame, stage)) for stage, gain in found if gain is not None]
    return sorted(costs, key=lambda cost: -cost.value)


def _interval(blame: Blame, stage: Stage) -> tuple[float, float] | None:
    if stage not in blame.tables:
        return None
    config = GradingConfig(**blame.shipped.config["grading"])
    shipped, oracle = (vehicle_sums(tables, config).columns() for tables in (blame.shipped.tables, blame.tables[stage]))
    (change,) = differences(shipped, oracle, (COMPARED,))
    low, high = change.interval
    possible = -change.base <= low and high <= 1.0 - change.base  # False for NaN
    return (low, high) if possible else None
