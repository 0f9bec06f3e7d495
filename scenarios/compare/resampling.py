"""Intervals and p-values of differences between BASE and HEAD by paired resampling of vehicles.

Intervals: vehicles are drawn with replacement, each with its frames in BASE and in HEAD (paired cluster bootstrap,
Davison and Hinkley 1997, Bootstrap Methods and their Application, section 3.8; percentiles). Percentiles of few
vehicles are too narrow; both ends are moved away from the difference by the ratio of Student's to the normal quantile
(after Hesterberg 2015, What Teachers Should Know About the Bootstrap, section 5.1).

P-values: under the null hypothesis, the labels BASE and HEAD of a vehicle are exchangeable. Random exchanges give the
distribution of every difference (paired randomisation test, Fisher 1935, The Design of Experiments, section 21), which
is valid for few vehicles, too. Each exchange applies to all metrics. Each metric is compared with the largest
difference of all metrics, in units of its standard deviation. This controls the family-wise error rate for any number
of metrics and any correlation between them (single-step max-T, Westfall and Young 1993, Resampling-Based Multiple
Testing).
"""

from dataclasses import dataclass

import numpy as np
from scipy.special import ndtri, stdtrit

from scenarios.arrays import Floats
from scenarios.compare.compared_metrics import ComparedMetric, values
from scenarios.grading.bootstrap import QUANTILES

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
    """95 % interval of the difference, for this metric alone; NaN if a single vehicle differs and is the only one."""
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
    drawn = rng.multinomial(units, np.full(units, 1.0 / units), size=RESAMPLES).astype(np.float64)
    resampled = values(drawn @ head, metrics) - values(drawn @ base, metrics)
    swapped = rng.integers(2, size=(RESAMPLES, units)).astype(np.float64) @ (base - head)
    null = values(head.sum(axis=0) + swapped, metrics) - values(base.sum(axis=0) - swapped, metrics)
    before, after = (values(sums.sum(axis=0, keepdims=True), metrics)[0] for sums in (base, head))
    p = _adjusted_p(after - before, null)
    found = []
    for m, metric in enumerate(metrics):
        observing = int((metric.observations(base) + metric.observations(head) > 0.0).sum())
        interval = _widened(_percentiles(resampled[:, m]), float(after[m] - before[m]), observing)
        found.append(Difference(float(before[m]), float(after[m]), interval, float(p[m])))
    return found


def _percentiles(resampled: Floats) -> tuple[float, float]:
    """Return the interval over the resamples (R,) with observations."""
    seen = resampled[np.isfinite(resampled)]
    low, high = np.quantile(seen, QUANTILES) if len(seen) else (np.nan, np.nan)
    return float(low), float(high)


def _widened(interval: tuple[float, float], difference: float, units: int) -> tuple[float, float]:
    """Return the interval of a difference, widened for few units with observations."""
    if difference == 0.0 and interval == (0.0, 0.0):
        return interval
    if units < 2:
        return np.nan, np.nan
    student, normal = stdtrit(units - 1, QUANTILES[1]), ndtri(QUANTILES[1])
    wider = float(student / normal) * (units / (units - 1)) ** 0.5
    return difference + wider * (interval[0] - difference), difference + wider * (interval[1] - difference)


def _adjusted_p(difference: Floats, null: Floats) -> Floats:
    """(M,) single-step max-T p-values of differences (M,), given those of the random exchanges (R, M)."""
    null = np.nan_to_num(null)
    spread = np.sqrt((null**2).mean(axis=0))  # about 0, the mean of all exchanges
    spread[spread == 0.0] = np.inf  # no vehicle differs
    largest = (np.abs(null) / spread).max(axis=1)
    statistic = np.abs(difference) / spread
    reached = (largest[:, None] >= statistic - TIE).sum(axis=0)
    return np.where(np.isnan(difference), np.nan, (1 + reached) / (1 + len(null)))
