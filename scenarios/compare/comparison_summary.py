"""Statements of a comparison by importance, shared by its page and its Markdown text."""

import math
from dataclasses import dataclass

from luxloop.scenarios.compare.comparison import LEVEL, Comparison, MetricChange
from luxloop.scenarios.compare.digest import Expectation
from luxloop.scenarios.compare.expectation_changes import ExpectationChange
from luxloop.scenarios.compare.run_pairs import listed
from luxloop.scenarios.compare.single_scenarios import ScenarioLoss
from luxloop.scenarios.report.cells import NONE
from luxloop.scenarios.statistics.confidence import TOO_FEW

INTERVALS = (
    "The 95 % interval of a change follows from its spread as each vehicle is left out in turn: an interval that "
    "contains 0 is no evidence of a change."
)
"""Explanation of the intervals."""


@dataclass(frozen=True, slots=True)
class Statement:
    """A change of one metric, scenario, expectation or run."""

    subject: str
    detail: str


def statements(comparison: Comparison) -> dict[str, list[Statement]]:
    """Return the changes by heading, the losses first; headings without a change are left out."""
    by_fate: dict[str, list[Statement]] = {}
    for change in comparison.expectation_changes:
        by_fate.setdefault(change.fate, []).append(_expectation(change))
    by_verdict: dict[str, list[Statement]] = {}
    for metric in comparison.changes:
        by_verdict.setdefault(metric.verdict, []).append(_metric(metric))
    early = comparison.pairs.newly_incomplete
    groups = {
        "Newly incomplete": [Statement(str(key), comparison.pairs.incomparable[key]) for key in early],
        "Newly failed": by_fate.get("newly failed", []),
        "Worse": [
            *by_verdict.get("lost", []),
            *by_verdict.get("worse", []),
            *(_scenario(loss) for loss in comparison.scenario_losses),
        ],
        "Now known to fail": by_fate.get("now known to fail", []),
        "Cannot tell": by_verdict.get("unclear", []),
        "Better": [*by_verdict.get("better", []), *by_fate.get("mended", [])],
    }
    return {heading: found for heading, found in groups.items() if found}


def sentence(comparison: Comparison) -> str:
    """Return the verdict in one sentence."""
    percent = f"{100.0 * comparison.loss:g} %"
    found = statements(comparison)
    metrics = sum(change.verdict in ("worse", "lost") for change in comparison.changes)
    counts = {
        "run{s} newly incomplete": len(found.get("Newly incomplete", [])),
        "expectation{s} newly failed": len(found.get("Newly failed", [])),
        "metric{s} worse": metrics,
        "scenario{s} worse alone": len(comparison.scenario_losses),
    }
    losses = [f"{count} {what.format(s='' if count == 1 else 's')}" for what, count in counts.items() if count]
    if losses:
        return f"HEAD is worse than BASE: {', '.join(losses)}"
    if comparison.outcome == "cannot tell":
        if "Cannot tell" not in found:
            return "The runs cannot tell: no metric has a value"
        return f"The runs cannot tell: a loss of {percent} is not excluded for {len(found['Cannot tell'])} metrics"
    same = "HEAD is better than BASE" if comparison.outcome == "better" else "HEAD is as good as BASE"
    return f"{same}: no metric is worse, and a loss of {percent} is excluded"


def compared_runs(comparison: Comparison) -> list[str]:
    """Return the numbers of compared runs, the runs left out with the reason, and notes."""
    pairs = comparison.pairs
    identical = sum(pair.identical for pair in pairs.compared)
    same = sum(pair.same for pair in pairs.compared if not pair.identical)
    lines = [f"{len(pairs.compared)} pairs of runs compared, {identical} of them identical (same trace hash)"]
    lines += [f"{same} more are equal within the tolerances, as runs on different CPUs are"] if same else []
    if comparison.measured < len(pairs.compared):
        lines.append(f"The metrics are those of the {comparison.measured} pairs that differ")
    lines += [f"Not compared: {key}: {why}" for key, why in pairs.incomparable.items()]
    lines += [f"Only in BASE: {listed(pairs.only_base)}"] if pairs.only_base else []
    lines += [f"Only in HEAD: {listed(pairs.only_head)}"] if pairs.only_head else []
    return [*lines, *pairs.notes]


def false_positives(comparison: Comparison) -> str:
    """Return the sentence on the probability of a wrong verdict."""
    single = f", and {LEVEL:.0%} of a loss in a single scenario" if comparison.scenarios_tested else ""
    return f"Without any change, the probability of a better or worse is {LEVEL:.0%}{single}"


def number(value: float, sign: str = "") -> str:
    """Format a metric with four decimals."""
    return NONE if math.isnan(value) else f"{value:{sign}.4f}"


def interval(change: MetricChange, between: str = " to ") -> str:
    """Format the interval of a change, or say that it has none."""
    ends = change.numbers.interval
    return TOO_FEW if math.isnan(ends[0]) else between.join(number(end, sign="+") for end in ends)


def expected_value(expectation: Expectation | None) -> str:
    """Format the value of an expectation; None: the side does not have it."""
    return NONE if expectation is None or expectation.value is None else f"{expectation.value:.4g}"


def _metric(change: MetricChange) -> Statement:
    numbers, unit = change.numbers, "" if change.metric.unit == "1" else f" {change.metric.unit}"
    text = f"{number(numbers.base)} to {number(numbers.head)}{unit}"
    if change.verdict != "lost":
        text += f" ({number(numbers.difference, sign='+')}; 95 %: {interval(change)})"
    return Statement(change.metric.name, text + (f"; most in {listed(change.where)}" if change.where else ""))


def _scenario(loss: ScenarioLoss) -> Statement:
    text = f"{number(loss.base)} to {number(loss.head)}, {loss.units} vehicles, p = {loss.p:.2g}"
    return Statement(loss.scenario, f"alone: {loss.metric.name} {text}")


def _expectation(change: ExpectationChange) -> Statement:
    values = f"{expected_value(change.base)} to {expected_value(change.head)}"
    return Statement(str(change.key), f"{change.name} {change.head.limit}: {values}")
