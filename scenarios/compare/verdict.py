"""What changed, metric by metric, and which expectations no longer hold: two different questions."""

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np

from scenarios.compare.digest import Expectation, Key
from scenarios.compare.headline import HEADLINES, Headline
from scenarios.compare.pairing import Pair, Pairs, stacked
from scenarios.compare.resampling import Difference, differences
from scenarios.grading.geometry import Floats

LEVEL = 0.01
"""Chance that any metric is called better or worse though nothing has changed."""
MOST = 3
"""Runs that are named as those that moved a metric."""

Verdict = Literal["same", "unclear", "better", "worse", "lost", "not measured"]
"""`better` and `worse` are no chance and large enough to matter. `same` is neither, and no change that matters lies in
the interval; where one does, the runs are too few to tell: `unclear`. `lost`: BASE measured it, HEAD does not."""

Fate = Literal["newly failed", "now known to fail", "still failing", "mended"]


@dataclass(frozen=True, slots=True)
class Change:
    """One metric in BASE and in HEAD."""

    headline: Headline
    numbers: Difference
    verdict: Verdict
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
    found = differences(*stacked(pairs.compared), HEADLINES)
    changes = [_change(headline, numbers, pairs.compared) for headline, numbers in zip(HEADLINES, found, strict=True)]
    return Comparison(pairs, changes, [fall for pair in pairs.compared for fall in _falls(pair)])


def judge(headline: Headline, numbers: Difference) -> Verdict:
    """Say what a difference is."""
    margin = headline.relevance.margin(numbers.base)
    if math.isnan(numbers.difference):
        return "not measured" if math.isnan(numbers.base) else "lost"
    if numbers.p <= LEVEL and abs(numbers.difference) >= margin:
        return "better" if (numbers.difference > 0) == (headline.better == "more") else "worse"
    low, high = numbers.interval
    return "same" if -margin <= low and high <= margin else "unclear"


def _change(headline: Headline, numbers: Difference, pairs: list[Pair]) -> Change:
    verdict = judge(headline, numbers)
    return Change(headline, numbers, verdict, _where(headline, pairs) if verdict in ("better", "worse") else {})


def _where(headline: Headline, pairs: list[Pair]) -> dict[Key, float]:
    """Take back the change of one run after the other, and see how far the value of all comes back with it."""
    base, head = (np.vstack([units.sum(axis=0) for units in side]) for side in _by_side(pairs))
    moved = headline.value(head.sum(axis=0, keepdims=True)) - headline.value(head.sum(axis=0) - head + base)
    most = np.argsort(-np.abs(moved), kind="stable")[:MOST]
    return {pairs[p].key: float(moved[p]) for p in most if moved[p]}


def _by_side(pairs: list[Pair]) -> tuple[list[Floats], list[Floats]]:
    units = [pair.units() for pair in pairs]
    return [base for base, _ in units], [head for _, head in units]


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
