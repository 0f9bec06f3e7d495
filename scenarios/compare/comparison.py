"""Comparison of two sets of runs: changed metrics, losses in single scenarios, and newly failed expectations."""

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np

from luxloop.scenarios.arrays import Floats
from luxloop.scenarios.compare.compared_metrics import COMPARED_METRICS, ComparedMetric
from luxloop.scenarios.compare.digest import Key
from luxloop.scenarios.compare.expectation_changes import ExpectationChange, expectation_changes
from luxloop.scenarios.compare.resampling import Difference, differences
from luxloop.scenarios.compare.run_pairs import Pairs
from luxloop.scenarios.compare.single_scenarios import ScenarioLoss, losses

LEVEL = 0.01
"""Family-wise error rate: probability that any pooled metric is called better or worse without a real change; also the
probability that any loss in a single scenario is found."""
STATED_LOSS = 0.02
"""Loss that a comparison must exclude, as a share: of all observations, or of the mean error in BASE."""
RUNS_NAMED = 3
"""Number of runs named as the largest contributions to a change."""

MetricVerdict = Literal["same", "unclear", "better", "worse", "lost", "not measured"]
"""`better` and `worse` are significant and relevant. `same` is neither, and the interval excludes the stated loss. If
it does not, the runs are too few for a decision: `unclear`. `lost`: BASE has a value, HEAD has none."""

Verdict = Literal["same", "better", "worse", "cannot tell"]


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
    measured: int
    """Number of pairs that the metrics are pooled over: those that differ, or all if none does."""
    changes: list[MetricChange]
    scenarios_tested: int
    """Number of scenarios that are also tested alone; 0 if only one differs."""
    scenario_losses: list[ScenarioLoss]
    """Losses in single scenarios."""
    expectation_changes: list[ExpectationChange]
    loss: float
    """Stated loss, as a share."""

    @property
    def failed(self) -> bool:
        """True if an expectation newly fails in HEAD, or a run newly ends early."""
        newly_failed = any(change.fate == "newly failed" for change in self.expectation_changes)
        return bool(self.pairs.newly_incomplete) or newly_failed

    @property
    def scenarios(self) -> set[str]:
        """Names of the compared scenarios."""
        return {pair.key.scenario for pair in self.pairs.compared}

    @property
    def verdict(self) -> Verdict:
        """Verdict on metrics, single scenarios, expectations and complete runs together; it sets the exit code."""
        found = {change.verdict for change in self.changes}
        if found & {"worse", "lost"} or self.scenario_losses or self.failed:
            return "worse"
        if "unclear" in found or found == {"not measured"}:
            return "cannot tell"
        return "better" if "better" in found else "same"

    def report(self) -> str:
        """Return the report as text without colours."""
        from luxloop.scenarios.compare.comparison_document import comparison_document
        from luxloop.scenarios.report import text

        return text.as_text(comparison_document(self, "BASE", "HEAD"))

    def _repr_html_(self) -> str:
        """Return answer and tables as HTML, for notebooks."""
        from luxloop.scenarios.compare.comparison_document import comparison_document
        from luxloop.scenarios.document import html

        return html.fragment(comparison_document(self, "BASE", "HEAD"))


def compare(pairs: Pairs, loss: float = STATED_LOSS) -> Comparison:
    """Compare all metrics and expectations of paired runs; `loss` is the loss to exclude, as a share.

    Runs that are the same on both sides do not take part: they would dilute a loss in the others.
    """
    measured = [pair for pair in pairs.compared if not pair.same] or pairs.compared
    units = [pair.units() for pair in measured]
    of_scenario: dict[str, list[tuple[Floats, Floats]]] = {pair.key.scenario: [] for pair in measured}
    for pair, sides in zip(measured, units, strict=True):
        of_scenario[pair.key.scenario].append(sides)
    pooled, several = _stacked(units), len(of_scenario) > 1
    change_of_run = np.array([(h - b).sum(axis=0) for b, h in units])
    contributions = RunContributions([pair.key for pair in measured], pooled[1].sum(axis=0), change_of_run)
    found = zip(COMPARED_METRICS, differences(*pooled, COMPARED_METRICS), strict=True)
    return Comparison(
        pairs,
        len(measured),
        [_change(metric, numbers, judge(metric, numbers, loss), contributions) for metric, numbers in found],
        len(of_scenario) if several else 0,
        losses({name: _stacked(sides) for name, sides in of_scenario.items()}, LEVEL) if several else [],
        [change for pair in pairs.compared for change in expectation_changes(pair)],
        loss,
    )


def _stacked(units: list[tuple[Floats, Floats]]) -> tuple[Floats, Floats]:
    """Return the units of several runs as those of one."""
    base, head = (np.vstack(side) for side in zip(*units, strict=True))
    return base, head


def judge(metric: ComparedMetric, numbers: Difference, loss: float = STATED_LOSS) -> MetricVerdict:
    """Return the verdict on the difference of one metric."""
    if math.isnan(numbers.difference):
        return "not measured" if math.isnan(numbers.base) else "lost"
    margin = metric.relevance.margin(numbers.base)
    if numbers.p <= LEVEL and abs(numbers.difference) >= margin:
        return "worse" if metric.loss(numbers.difference) > 0.0 else "better"
    largest_loss = max(metric.loss(end) for end in numbers.interval)
    return "same" if largest_loss <= metric.relevance.stated_loss(numbers.base, loss) else "unclear"


def _change(
    metric: ComparedMetric, numbers: Difference, verdict: MetricVerdict, contributions: RunContributions
) -> MetricChange:
    where = contributions.largest(metric) if verdict in ("better", "worse") else {}
    return MetricChange(metric, numbers, verdict, where)
