"""Comparison of two sets of runs: changed metrics, losses in single scenarios, and newly failed expectations.

Losses in single scenarios are too small in the pooled runs to be found there. Each scenario, with all its seeds, has an
exact one-sided randomisation test of its vehicles, adjusted for all metrics (single-step max-T, as for the pooled
runs), and for all scenarios by Holm 1979, A Simple Sequentially Rejective Multiple Test Procedure. Scenarios with so
few different vehicles that no outcome could be significant are left out of this correction (Tarone 1990, A Modified
Bonferroni Method for Discrete Data). Without it, every scenario without a change would lower the power of the others.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

import numpy as np

from luxloop.arrays import Floats
from luxloop.scenarios.compare.compared_metrics import COMPARED_METRICS, ComparedMetric, values
from luxloop.scenarios.compare.digest import Expectation, Key
from luxloop.scenarios.compare.resampling import SEED, TIE, Difference, differences
from luxloop.scenarios.compare.run_pairs import Pair, Pairs

ExpectationFate = Literal["newly failed", "now known to fail", "still failing", "mended"]


@dataclass(frozen=True, slots=True)
class ExpectationChange:
    """An expectation that fails on at least one side."""

    key: Key
    name: str
    base: Expectation
    head: Expectation
    fate: ExpectationFate


def expectation_changes(pair: Pair) -> list[ExpectationChange]:
    """Return the expectations of both runs that fail on at least one side."""
    changes = []
    for name, head in pair.head.expectations.items():
        base = pair.base.expectations.get(name)
        if base is not None and (fate := _fate_of(base.holds, head)):
            changes.append(ExpectationChange(pair.key, name, base, head, fate))
    return changes


def _fate_of(held: bool, head: Expectation) -> ExpectationFate | None:
    if head.holds:
        return None if held else "mended"
    if head.outcome == "failed":
        return "newly failed" if held else "still failing"
    return "now known to fail" if held and head.outcome == "known failure" else None


EXACT_UNITS = 13
"""Most units of which all exchanges are counted."""
RANDOM_EXCHANGES = 20000
"""Random exchanges of more units; enough for the p-values that the correction for many scenarios needs."""


@dataclass(frozen=True, slots=True, eq=False)
class LossTest:
    """Losses of M metrics in one scenario."""

    base: Floats
    """(M,) NaN if BASE has no value."""
    head: Floats
    """(M,)."""
    loss: Floats
    """(M,) positive if HEAD is worse; NaN if a side has no value."""
    relevant_p: Floats
    """(M,) p-values adjusted for all metrics; 1 for losses below the smallest relevant difference."""
    attainable_p: float
    """Smallest possible p-value with so many units."""
    units: int
    """Number of units that differ."""

    @property
    def smallest_p(self) -> float:
        """P-value of the scenario."""
        return float(self.relevant_p.min())


def loss_test(base: Floats, head: Floats, metrics: tuple[ComparedMetric, ...]) -> LossTest | None:
    """Test whether HEAD is worse; None if no unit differs.

    Parameters
    ----------
    base, head
        (U, len(COLUMNS)) sums of the U paired units.
    """
    differ = (base != head).any(axis=1)
    if not differ.any():
        return None
    sign = np.array([metric.loss(1.0) for metric in metrics])
    exchanged = _exchanges(int(differ.sum()))
    swapped = exchanged @ (base - head)[differ]
    null = sign * (
        values(head.sum(axis=0) + swapped, metrics) - values(base.sum(axis=0) - swapped, metrics)
    )  # the first row is without any exchange
    before, after = (values(side.sum(axis=0, keepdims=True), metrics)[0] for side in (base, head))
    loss = sign * (after - before)
    margins = np.array([metric.relevance.margin(value) for metric, value in zip(metrics, before, strict=True)])
    p = np.where(np.nan_to_num(loss) >= np.nan_to_num(margins, nan=np.inf), _p(np.nan_to_num(null)), 1.0)
    return LossTest(before, after, loss, p, 1.0 / len(exchanged), int(differ.sum()))


def _exchanges(units: int) -> Floats:
    """Return the exchanges (R, units) as 0 and 1: all of few units, random ones of many; the first exchanges none."""
    if units <= EXACT_UNITS:
        return (np.arange(2**units)[:, None] >> np.arange(units) & 1).astype(np.float64)
    drawn = np.random.default_rng(SEED).integers(2, size=(RANDOM_EXCHANGES, units)).astype(np.float64)
    return np.vstack([np.zeros((1, units)), drawn])


def _p(null: Floats) -> Floats:
    """(M,) single-step max-T p-values of the losses in the first row of (R, M)."""
    spread = np.sqrt((null**2).mean(axis=0))
    spread[spread == 0.0] = np.inf  # no unit differs in this metric
    standard = null / spread
    reached: Floats = (standard.max(axis=1)[:, None] >= standard[0] - TIE).mean(axis=0)
    return reached


@dataclass(frozen=True, slots=True)
class ScenarioLoss:
    """The clearest significant and relevant loss of one scenario."""

    scenario: str
    metric: ComparedMetric
    base: float
    head: float
    p: float
    """P-value adjusted for all metrics and all scenarios."""
    units: int
    """Number of different vehicles, and one for the false tracks."""


def scenario_losses(units: Mapping[str, tuple[Floats, Floats]], level: float) -> list[ScenarioLoss]:
    """Find significant and relevant losses in single scenarios, the clearest first.

    Parameters
    ----------
    units
        Sums (U, len(COLUMNS)) of the units in BASE and in HEAD, per scenario.
    level
        Probability of any loss found without a real change.
    """
    tests = {name: test for name, sides in units.items() if (test := loss_test(*sides, COMPARED_METRICS))}
    adjusted = _holm({name: test.smallest_p for name, test in tests.items()}, candidates(tests, level))
    found = [_loss(name, test, adjusted[name]) for name, test in tests.items() if adjusted[name] <= level]
    return sorted(found, key=lambda each: (each.p, each.scenario))


def candidates(tests: Mapping[str, LossTest], level: float) -> set[str]:
    """Return the scenarios for which significance is possible at all (Tarone 1990)."""
    count = 0
    chosen = set(tests)
    while len(chosen) > count:
        count += 1
        chosen = {name for name, test in tests.items() if test.attainable_p <= level / count}
    return chosen


def _holm(smallest: Mapping[str, float], chosen: set[str]) -> dict[str, float]:
    """Return p-values adjusted by Holm's procedure; 1 for scenarios that were not chosen."""
    adjusted, reached = dict.fromkeys(smallest, 1.0), 0.0
    for rank, name in enumerate(sorted(chosen, key=lambda name: smallest[name])):
        reached = max(reached, min(1.0, smallest[name] * (len(chosen) - rank)))
        adjusted[name] = reached
    return adjusted


def _loss(name: str, test: LossTest, p: float) -> ScenarioLoss:
    metric = int(np.argmin(test.relevant_p))
    return ScenarioLoss(
        name, COMPARED_METRICS[metric], float(test.base[metric]), float(test.head[metric]), p, test.units
    )


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
        scenario_losses({name: _stacked(sides) for name, sides in of_scenario.items()}, LEVEL) if several else [],
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
