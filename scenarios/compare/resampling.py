"""Intervals and p-values of differences between BASE and HEAD over paired vehicles.

Intervals: each vehicle is left out in turn, with its frames in BASE and in HEAD (paired jackknife, by
`luxloop.scenarios.statistics`). Resamples with replacement would be too narrow for few vehicles.

P-values: under the null hypothesis, the labels BASE and HEAD of a vehicle are exchangeable. Random exchanges give the
distribution of every difference (paired randomisation test, Fisher 1935, The Design of Experiments, section 21), which
is valid for few vehicles, too. Each exchange applies to all metrics. Each metric is compared with the largest
difference of all metrics, in units of its standard deviation. This controls the family-wise error rate for any number
of metrics and any correlation between them (single-step max-T, Westfall and Young 1993, Resampling-Based Multiple
Testing).
"""

import math
from dataclasses import dataclass

import numpy as np

from luxloop.arrays import Floats
from luxloop.scenarios.compare.compared_metrics import ComparedMetric, values
from luxloop.scenarios.statistics.jackknife import effective_clusters, standard_error, student

RESAMPLES = 2000
SEED = 0
"""Fixed for reproducible comparisons."""
TIE = 1e-9
"""Tolerance for rounding in the comparison of two statistics [standard deviations]."""


@dataclass(frozen=True, slots=True)
class Difference:
    """A metric in BASE and HEAD; numbers are NaN if a side has no value."""

    base: float
    head: float
    interval: tuple[float, float]
    """95 % interval of the difference, for this metric alone; NaN for too few vehicles."""
    p: float
    """P-value adjusted for all metrics: probability of any difference as large as this one without a real change."""

    @property
    def difference(self) -> float:
        """HEAD minus BASE."""
        return self.head - self.base


def differences(base: Floats, head: Floats, metrics: tuple[ComparedMetric, ...]) -> list[Difference]:
    """Compare BASE and HEAD in every metric.

    Parameters
    ----------
    base, head
        (U, len(COLUMNS)) sums of the U paired resampling units.
    """
    rng = np.random.default_rng(SEED)
    units = len(base)
    without = values(head.sum(axis=0) - head, metrics) - values(base.sum(axis=0) - base, metrics)
    swapped = rng.integers(2, size=(RESAMPLES, units)).astype(np.float64) @ (base - head)
    null = values(head.sum(axis=0) + swapped, metrics) - values(base.sum(axis=0) - swapped, metrics)
    before, after = (values(sums.sum(axis=0, keepdims=True), metrics)[0] for sums in (base, head))
    p = _adjusted_p(after - before, null)
    found = []
    for m, metric in enumerate(metrics):
        weight = metric.observations(base) + metric.observations(head)
        change = float(after[m] - before[m])
        interval = difference_interval(change, without[:, m], weight, metric.largest_difference)
        found.append(Difference(float(before[m]), float(after[m]), interval, float(p[m])))
    return found


def difference_interval(
    difference: float, without: Floats, weight: Floats, largest: float = math.inf
) -> tuple[float, float]:
    """Return Student's interval of a difference from those without each unit (U,), of `weight` (U,) observations.

    NaN for too few units: a single one has observations, unless it does not differ, or the interval reaches beyond the
    `largest` possible difference.
    """
    seen = weight > 0.0
    if not np.isfinite(difference):
        return np.nan, np.nan
    if difference == 0.0 and (without[seen & np.isfinite(without)] == 0.0).all():
        return 0.0, 0.0  # no unit differs
    if seen.sum() < 2:
        return np.nan, np.nan
    half = student(effective_clusters(weight[seen])) * standard_error(difference, without[seen])
    return (difference - half, difference + half) if abs(difference) + half <= largest else (np.nan, np.nan)


def _adjusted_p(difference: Floats, null: Floats) -> Floats:
    """(M,) single-step max-T p-values of differences (M,), given those of the random exchanges (R, M)."""
    null = np.nan_to_num(null)
    spread = np.sqrt((null**2).mean(axis=0))  # about 0, the mean of all exchanges
    spread[spread == 0.0] = np.inf  # no vehicle differs
    largest = (np.abs(null) / spread).max(axis=1)
    statistic = np.abs(difference) / spread
    reached = (largest[:, None] >= statistic - TIE).sum(axis=0)
    return np.where(np.isnan(difference), np.nan, (1 + reached) / (1 + len(null)))
