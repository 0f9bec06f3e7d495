"""One-sided randomisation test of the vehicles of one scenario, exact for few vehicles."""

from dataclasses import dataclass

import numpy as np

from luxloop.scenarios.arrays import Floats
from luxloop.scenarios.compare.compared_metrics import ComparedMetric, values
from luxloop.scenarios.compare.resampling import SEED, TIE

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
