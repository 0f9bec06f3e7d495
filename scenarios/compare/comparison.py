"""Comparison of two sets of runs: changed metrics, and newly failed expectations. The two are independent."""

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np

from scenarios.arrays import Floats
from scenarios.compare.compared_metrics import COMPARED_METRICS, ComparedMetric
from scenarios.compare.digest import Expectation, Key
from scenarios.compare.resampling import Difference, differences
from scenarios.compare.run_pairs import Pair, Pairs

LEVEL = 0.01
"""Family-wise error rate: probability that any metric is called better or worse without a real change."""
RUNS_NAMED = 3
"""Number of runs named as the largest contributions to a change."""

MetricVerdict = Literal["same", "unclear", "better", "worse", "lost", "not measured"]
"""`better` and `worse` are significant and relevant. `same` is neither, and the interval contains no relevant change.
If it contains one, the runs are too few for a decision: `unclear`. `lost`: BASE has a value, HEAD has none."""

ExpectationFate = Literal["newly failed", "now known to fail", "still failing", "mended"]


@dataclass(frozen=True, slots=True)
class MetricChange:
    """A metric in BASE and in HEAD."""

    metric: ComparedMetric
    numbers: Difference
    verdict: MetricVerdict
    where: dict[Key, float]
    """Largest contributions of single runs, for the verdicts better and worse only."""

    @property
    def margin(self) -> float:
        """The smallest relevant difference; NaN if BASE has no value."""
        return self.metric.relevance.margin(self.numbers.base)


@dataclass(frozen=True, slots=True)
class ExpectationChange:
    """An expectation that fails on at least one side."""

    key: Key
    name: str
    base: Expectation | None
    """None if BASE does not have the expectation."""
    head: Expectation
    fate: ExpectationFate


@dataclass(frozen=True, slots=True, eq=False)
class RunContributions:
    """Contribution of each of R runs to a change of the pooled metrics."""

    keys: list[Key]
    head: Floats
    """(len(COLUMNS),) HEAD's sums over all runs."""
    change: Floats
    """(R, len(COLUMNS)) HEAD's minus BASE's sums of each run."""

    def largest(self, metric: ComparedMetric) -> dict[Key, float]:
        """Return the largest contributions: differences of the pooled value with and without the change of one run."""
        moved = np.nan_to_num(metric.value(self.head[None]) - metric.value(self.head - self.change))
        order = np.argsort(-np.abs(moved), kind="stable")[:RUNS_NAMED].tolist()
        return {self.keys[run]: float(moved[run]) for run in order if moved[run]}


@dataclass(frozen=True, slots=True)
class Comparison:
    """Result of a comparison."""

    pairs: Pairs
    changes: list[MetricChange]
    expectation_changes: list[ExpectationChange]

    @property
    def failed(self) -> bool:
        """True if an expectation newly fails in HEAD, or a run newly ends early."""
        newly_failed = any(change.fate == "newly failed" for change in self.expectation_changes)
        return bool(self.pairs.newly_incomplete) or newly_failed

    @property
    def verdict(self) -> Literal["same", "better", "worse"]:
        """Verdict on all metrics together: worse if any metric is worse or lost."""
        found = {change.verdict for change in self.changes}
        if found & {"worse", "lost"}:
            return "worse"
        return "better" if "better" in found else "same"


def compare(pairs: Pairs) -> Comparison:
    """Compare all metrics and expectations of paired runs."""
    units = [pair.units() for pair in pairs.compared]
    base, head = (np.vstack(side) for side in zip(*units, strict=True))
    change_of_run = np.array([(h - b).sum(axis=0) for b, h in units])
    contributions = RunContributions([pair.key for pair in pairs.compared], head.sum(axis=0), change_of_run)
    found = differences(base, head, COMPARED_METRICS)
    changes = [_change(metric, numbers, contributions) for metric, numbers in zip(COMPARED_METRICS, found, strict=True)]
    return Comparison(pairs, changes, [change for pair in pairs.compared for change in _expectation_changes(pair)])


def judge(metric: ComparedMetric, numbers: Difference) -> MetricVerdict:
    """Return the verdict on the difference of one metric."""
    margin = metric.relevance.margin(numbers.base)
    if math.isnan(numbers.difference):
        return "not measured" if math.isnan(numbers.base) else "lost"
    if numbers.p <= LEVEL and abs(numbers.difference) >= margin:
        return "better" if (numbers.difference > 0) == (metric.better == "more") else "worse"
    low, high = numbers.interval
    return "same" if -margin <= low and high <= margin else "unclear"


def _change(metric: ComparedMetric, numbers: Difference, contributions: RunContributions) -> MetricChange:
    verdict = judge(metric, numbers)
    where = contributions.largest(metric) if verdict in ("better", "worse") else {}
    return MetricChange(metric, numbers, verdict, where)


def _expectation_changes(pair: Pair) -> list[ExpectationChange]:
    """Return the expectations of a run that fail on at least one side; one that is missing in BASE counts as held."""
    changes = []
    for name, head in pair.head.expectations.items():
        base = pair.base.expectations.get(name)
        fate = _fate(held=base is None or base.holds, head=head)
        if fate:
            changes.append(ExpectationChange(pair.key, name, base, head, fate))
    return changes


def _fate(held: bool, head: Expectation) -> ExpectationFate | None:
    if head.holds:
        return None if held else "mended"
    if head.outcome == "failed":
        return "newly failed" if held else "still failing"
    return "now known to fail" if held and head.outcome == "known failure" else None
