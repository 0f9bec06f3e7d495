"""What chance does to a difference: paired resampling of vehicles.

Intervals: vehicles are drawn with replacement, each with its frames in BASE and in HEAD (paired cluster bootstrap,
Davison and Hinkley 1997, Bootstrap Methods and their Application, section 3.8; percentiles).

Verdicts: if a change does nothing, it is a coin's toss which of a vehicle's two lives is called BASE. Such tosses give
the distribution of every difference (paired randomisation test, Fisher 1935, The Design of Experiments, section 21),
right for few vehicles, too. All metrics are tossed together, and each is held against the largest of all, in units of
its own spread. So the chance that any metric is taken for changed without being so is the level, however many there are
and however they hang together (single-step max-T, Westfall and Young 1993, Resampling-Based Multiple Testing).
"""

from dataclasses import dataclass

import numpy as np

from scenarios.arrays import Floats
from scenarios.compare.compared_metrics import ComparedMetric
from scenarios.grading.bootstrap import QUANTILES

RESAMPLES = 2000
SEED = 0
"""Fixed, so that a comparison comes out the same every time."""
TIE = 1e-9
"""Spreads by which two statistics may differ and be the same but for rounding."""


@dataclass(frozen=True, slots=True)
class Difference:
    """One metric; numbers are NaN where a side has no value."""

    base: float
    head: float
    interval: tuple[float, float]
    """95 % of the difference, of this metric alone."""
    p: float
    """Chance that any of all metrics would differ as clearly as this one if nothing had changed."""

    @property
    def difference(self) -> float:
        """HEAD minus BASE."""
        return self.head - self.base


def differences(base: Floats, head: Floats, headlines: tuple[ComparedMetric, ...]) -> list[Difference]:
    """Compare the units' sums (U, len(COLUMNS)) of BASE and HEAD in every headline metric."""
    rng = np.random.default_rng(SEED)
    units = len(base)
    drawn = rng.multinomial(units, np.full(units, 1.0 / units), size=RESAMPLES).astype(np.float64)
    resampled = values(drawn @ head, headlines) - values(drawn @ base, headlines)
    swapped = rng.integers(2, size=(RESAMPLES, units)).astype(np.float64) @ (base - head)
    null = values(head.sum(axis=0) + swapped, headlines) - values(base.sum(axis=0) - swapped, headlines)
    before, after = (values(sums.sum(axis=0, keepdims=True), headlines)[0] for sums in (base, head))
    p = _adjusted_p(after - before, null)
    return [
        Difference(float(before[m]), float(after[m]), _percentiles(resampled[:, m]), float(p[m]))
        for m in range(len(headlines))
    ]


def values(sums: Floats, headlines: tuple[ComparedMetric, ...]) -> Floats:
    """(R, M) metrics for R sets of sums (R, len(COLUMNS))."""
    return np.column_stack([headline.value(sums) for headline in headlines])


def _percentiles(resampled: Floats) -> tuple[float, float]:
    """Interval from the resamples (R,) in which there was anything to see."""
    seen = resampled[np.isfinite(resampled)]
    low, high = np.quantile(seen, QUANTILES) if len(seen) else (np.nan, np.nan)
    return float(low), float(high)


def _adjusted_p(difference: Floats, null: Floats) -> Floats:
    """(M,) single-step max-T of differences (M,) against those of the tosses (R, M)."""
    null = np.nan_to_num(null)
    spread = np.sqrt((null**2).mean(axis=0))  # about 0, which is the mean of all tosses
    spread[spread == 0.0] = np.inf  # no vehicle differs: nothing to take for a change
    largest = (np.abs(null) / spread).max(axis=1)
    statistic = np.abs(difference) / spread
    reached = (largest[:, None] >= statistic - TIE).sum(axis=0)
    return np.where(np.isnan(difference), np.nan, (1 + reached) / (1 + len(null)))
