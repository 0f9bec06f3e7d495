"""`luxloop blame`: costs of the stages with intervals over vehicles, and the printed report."""

from collections.abc import Mapping, Sequence

from luxloop.scenarios.compare.compared_metrics import COMPARED_METRICS
from luxloop.scenarios.compare.resampling import differences
from luxloop.scenarios.compare.vehicle_sums import vehicle_sums
from luxloop.scenarios.document.document import Answer, Block, Bullets, Document, Paragraph, Section, Span, Table, Words
from luxloop.scenarios.grading.grading_config import GradingConfig
from luxloop.scenarios.metrics.definitions import find_metric
from luxloop.scenarios.oracle.stage import Stage
from luxloop.scenarios.oracle.stage_blame import (
    BLAME_METRICS,
    COST_METRIC,
    OF_FILTERS,
    OF_STAGES,
    OF_TRACKS,
    SHOWN_DIGITS,
    Blame,
    StageCost,
)
from luxloop.scenarios.report.cells import NONE, table_of, value_of
from luxloop.scenarios.report.run_document import header

(COMPARED,) = (metric for metric in COMPARED_METRICS if metric.name == COST_METRIC)


def stage_costs(blame: Blame) -> list[StageCost]:
    """Return the cost of each stage in `COST_METRIC`, the largest first; none without a value of the metric.

    Vehicles are paired: all oracles process the scans of the shipped tracker. If the tracks drive the ego, the drives
    differ, and there are no intervals.
    """
    found = [(stage, blame.gain(stage, COST_METRIC)) for stage in Stage]
    costs = [StageCost(stage, gain, _paired_interval(blame, stage)) for stage, gain in found if gain is not None]
    return sorted(costs, key=lambda cost: -cost.value)


def _paired_interval(blame: Blame, stage: Stage) -> tuple[float, float] | None:
    if stage not in blame.tables:
        return None
    config = GradingConfig(**blame.shipped.config["grading"])
    shipped, oracle = (vehicle_sums(tables, config).columns() for tables in (blame.shipped.tables, blame.tables[stage]))
    (change,) = differences(shipped, oracle, (COMPARED,))
    low, high = change.interval
    possible = -change.base <= low and high <= 1.0 - change.base  # False for NaN
    return (low, high) if possible else None


OWN_DRIVES = "The tracks control the ego: every row is a separate drive with its own scans."


def blame_report(blame: Blame, costs: Sequence[StageCost]) -> Document:
    """Return the report: the answer in one sentence, the costs of the stages, and all metrics.

    Parameters
    ----------
    costs
        Costs of the stages, the largest first.
    """
    own = [Paragraph(OWN_DRIVES, "dim")] if blame.shipped.config["control"] else []
    blocks: list[Block] = [
        *([_costs(costs)] if costs else []),
        _table("Stages, with the truth in the place of one of them", blame, OF_STAGES),
        _table("Estimates, with the truth in the place of one stage", blame, OF_FILTERS),
        _table("Tracks, with the truth in the place of one stage", blame, OF_TRACKS),
        Bullets([_verdict(blame, metric) for metric in BLAME_METRICS], "Which stage costs most"),
        *own,
    ]
    return Document(
        f"{blame.shipped.scenario}: which stage costs most",
        Answer(answer(blame, costs)),
        header(blame.shipped),
        [Section("stages", "Stages", blocks)],
    )


def answer(blame: Blame, costs: Sequence[StageCost]) -> str:
    """Return which stage costs most, with its interval."""
    metric = blame.shipped.metrics[COST_METRIC]
    if not costs:
        return f"No stage is to blame: {COST_METRIC} is {NONE}, {metric.reason}"
    first = costs[0]
    if first.value <= 0.0:
        return f"No stage costs HOTA: the truth in the place of none of them improves its {value_of(metric)}"
    few = "; no interval: too few vehicles, or a drive for each stage" if first.interval is None else ""
    chance = ", which may be chance" if first.interval and first.interval[0] <= 0.0 else ""
    return f"{first.stage} costs {_cost(first)} HOTA{_interval(first)}, most of all stages{chance}{few}"


def _costs(costs: Sequence[StageCost]) -> Table:
    """Return a table with a row per stage."""
    table = table_of("Cost in HOTA", "stage", "cost", "95 %")
    for cost in costs:
        table.add_row(cost.stage, _cost(cost), _interval(cost).strip(" []") or NONE)
    return table


def _cost(cost: StageCost) -> str:
    return f"{cost.value:.{SHOWN_DIGITS}f}"


def _interval(cost: StageCost) -> str:
    if cost.interval is None:
        return ""
    low, high = (f"{end:.{SHOWN_DIGITS}f}" for end in cost.interval)
    return f" [{low}, {high}]"


def _table(title: str, blame: Blame, heads: Mapping[str, str]) -> Table:
    """Return a table with a row per stage: values of the metrics, and differences below them."""
    table = table_of(title, "truth for")
    for head in heads.values():
        table.add_column(head.replace(" ", "\n"), justify="right")
    shipped = blame.shipped.metrics
    table.add_row("none", *(value_of(shipped[name]) for name in heads), end_section=True)
    for stage in Stage:
        table.add_row(stage, *(_cell(blame, stage, name) for name in heads))
    return table


def _cell(blame: Blame, stage: Stage, metric: str) -> Words:
    measured, gain = blame.by_truth[stage][metric], blame.gain(stage, metric)
    if not gain:
        return Span(value_of(measured), "dim")
    change = gain if find_metric(metric).definition.better == "more" else -gain
    signed = f"{change:+.0f}" if measured.unit == "count" else f"{change:+.{SHOWN_DIGITS}f}"
    return value_of(measured), Span("\n" + signed, "good" if gain > 0 else "bad")


def _verdict(blame: Blame, metric: str) -> str:
    """Name the two stages with the largest cost for a metric."""
    as_is = blame.shipped.metrics[metric]
    if as_is.value is None:
        return f"{metric} is {NONE}: {as_is.reason}"
    costly = [f"{stage} ({value_of(blame.by_truth[stage][metric])})" for stage in blame.ranking(metric)[:2]]
    verdict = f"{costly[0]} costs most" if costly else "no stage's truth makes it better"
    return f"{metric} is {value_of(as_is)}: {', then '.join([verdict, *costly[1:]])}"
