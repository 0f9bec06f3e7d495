"""What changed, metric by metric, and which expectations no longer hold: two different questions."""

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
"""Chance that any metric is called better or worse though nothing has changed."""
MOST = 3
"""Runs that are named as those that moved a metric."""

MetricVerdict = Literal["same", "unclear", "better", "worse", "lost", "not measured"]
"""`better` and `worse` are no chance and large enough to matter. `same` is neither, and no change that matters lies in
the interval; where one does, the runs are too few to tell: `unclear`. `lost`: BASE measured it, HEAD does not."""

Fate = Literal["newly failed", "now known to fail", "still failing", "mended"]


@dataclass(frozen=True, slots=True)
class Change:
    """One metric in BASE and in HEAD."""

    headline: ComparedMetric
    numbers: Difference
    verdict: MetricVerdict
    where: dict[Key, float]
    """Runs that moved it most, and by how much; of better and worse ones only."""

    @property
    def margin(self) -> float:
        """The least difference that matters; NaN where BASE has no value."""
        return self.headline.relevance.margin(self.numbers.base)


@dataclass(frozen=True, slots=True)
class Fall:
    """An expectation that does not hold on one of the sides."""

    key: Key
    name: str
    base: Expectation | None
    head: Expectation
    fate: Fate


@dataclass(frozen=True, slots=True, eq=False)
class Moved:
    """What each of R runs has to do with a change."""

    keys: list[Key]
    head: Floats
    """(len(COLUMNS),) HEAD's sums over all runs."""
    change: Floats
    """(R, len(COLUMNS)) HEAD's minus BASE's of each run."""

    def most(self, headline: ComparedMetric) -> dict[Key, float]:
        """Take back one run's change after the other; by how much each moves the value of all, the most first."""
        moved = np.nan_to_num(headline.value(self.head[None]) - headline.value(self.head - self.change))
        order = np.argsort(-np.abs(moved), kind="stable")[:MOST].tolist()
        return {self.keys[run]: float(moved[run]) for run in order if moved[run]}


@dataclass(frozen=True, slots=True)
class Comparison:
    """All that a comparison says."""

    pairs: Pairs
    changes: list[Change]
    falls: list[Fall]

    @property
    def failed(self) -> bool:
        """Whether HEAD fails where BASE did not: an expectation, or a run that did not get to its end."""
        return bool(self.pairs.newly_incomplete) or any(fall.fate == "newly failed" for fall in self.falls)

    @property
    def verdict(self) -> Literal["same", "better", "worse"]:
        """Of all metrics together: worse if any is."""
        found = {change.verdict for change in self.changes}
        if found & {"worse", "lost"}:
            return "worse"
        return "better" if "better" in found else "same"


def compare(pairs: Pairs) -> Comparison:
    """Judge every headline metric and every expectation."""
    units = [pair.units() for pair in pairs.compared]
    base, head = (np.vstack(side) for side in zip(*units, strict=True))
    change_of_run = np.array([(h - b).sum(axis=0) for b, h in units])
    moved = Moved([pair.key for pair in pairs.compared], head.sum(axis=0), change_of_run)
    found = differences(base, head, COMPARED_METRICS)
    changes = [_change(headline, numbers, moved) for headline, numbers in zip(COMPARED_METRICS, found, strict=True)]
    return Comparison(pairs, changes, [fall for pair in pairs.compared for fall in _falls(pair)])


def judge(headline: ComparedMetric, numbers: Difference) -> MetricVerdict:
    """Say what a difference is."""
    margin = headline.relevance.margin(numbers.base)
    if math.isnan(numbers.difference):
        return "not measured" if math.isnan(numbers.base) else "lost"
    if numbers.p <= LEVEL and abs(numbers.difference) >= margin:
        return "better" if (numbers.difference > 0) == (headline.better == "more") else "worse"
    low, high = numbers.interval
    return "same" if -margin <= low and high <= margin else "unclear"


def _change(headline: ComparedMetric, numbers: Difference, moved: Moved) -> Change:
    verdict = judge(headline, numbers)
    return Change(headline, numbers, verdict, moved.most(headline) if verdict in ("better", "worse") else {})


def _falls(pair: Pair) -> list[Fall]:
    """Hold what became of a run's expectations in HEAD against BASE; one that BASE did not have yet counts as held."""
    falls = []
    for name, head in pair.head.expectations.items():
        base = pair.base.expectations.get(name)
        fate = _fate(held=base is None or base.holds, head=head)
        if fate:
            falls.append(Fall(pair.key, name, base, head, fate))
    return falls


def _fate(held: bool, head: Expectation) -> Fate | None:
    if head.holds:
        return None if held else "mended"
    if head.outcome == "failed":
        return "newly failed" if held else "still failing"
    return "now known to fail" if held else None
