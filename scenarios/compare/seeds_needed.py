"""Number of seeds with which a comparison that cannot tell could exclude the stated loss."""

import math
from collections import Counter
from dataclasses import dataclass

from luxloop.scenarios.compare.comparison import Comparison, MetricChange


@dataclass(frozen=True, slots=True)
class SeedsNeeded:
    """Seeds of each scenario."""

    now: int
    """Most seeds of a scenario whose runs differ."""
    needed: int | None
    """None if no number can be named."""
    unbounded: str = ""
    """A metric whose measured loss is the stated one or larger: more seeds would confirm it."""
    without_interval: str = ""
    """A metric with too few vehicles for an interval."""


def seeds_needed(comparison: Comparison) -> SeedsNeeded:
    """Return how many seeds would exclude the stated loss in every unclear metric, if the measured change is true.

    The half-width of an interval falls with the root of the number n of seeds. It must become the distance of the
    change from the limit: n_needed = n * (half-width / distance)^2. Student's quantile falls with n, too, which is
    left out, so that the number is rather too large for few vehicles.
    """
    pairs = [pair for pair in comparison.pairs.compared if not pair.same] or comparison.pairs.compared
    now = max(Counter(pair.key.scenario for pair in pairs).values())
    unclear = [change for change in comparison.changes if change.verdict == "unclear"]
    factors = {change.metric.name: _factor(change, comparison.loss) for change in unclear}
    for name, factor in factors.items():
        if math.isnan(factor):
            return SeedsNeeded(now, None, without_interval=name)
    for name, factor in factors.items():
        if math.isinf(factor):
            return SeedsNeeded(now, None, unbounded=name)
    return SeedsNeeded(now, max((math.ceil(now * factor) for factor in factors.values()), default=now))


def _factor(change: MetricChange, share: float) -> float:
    """Return n_needed / n; infinite if the change is at the limit or beyond, NaN without an interval."""
    numbers, metric = change.numbers, change.metric
    half = 0.5 * (numbers.interval[1] - numbers.interval[0])
    distance = metric.relevance.stated_loss(numbers.base, share) - metric.loss(numbers.difference)
    if math.isnan(half):
        return math.nan
    return (half / distance) ** 2 if distance > 0.0 else math.inf
