"""Adaptive estimation of the values at which given shares of trials succeed.

The posterior of a curve is held on a grid, as in the psi method (Kontsevich and Tyler 1999, Vision Research 39, 2729).
The next trial has the least expected posterior variance of the values asked for (King-Smith et al. 1994, Vision
Research 34, 885). The curve may be asymmetric, and a share of lapses is estimated along (Prins 2013, Journal of Vision
13(7), 3): a slow decline before a sharp drop, or trials that fail for unrelated reasons, must not shift the values.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy

from luxloop.arrays import Floats
from luxloop.scenarios.statistics.intervals import TAIL, Interval

LAPSES = (0.0, 0.02, 0.04)
"""Shares of failures at the easy end; below 5 %, so that a threshold of 95 % exists."""
SHAPES = (0.2, 1.0, 5.0)
"""Exponents of the failures: below 1 the decline before the middle is slow and the drop after it sharp."""
MIDDLES, WIDTHS, TRIAL_VALUES = 81, 11, 41
"""Numbers of grid points of the curve's middle and width, and of values that a trial may have."""
WIDTH_SPAN = (0.005, 0.3)
"""Smallest and largest scale of the curve, in units of the range; its prior is uniform in the logarithm."""


@dataclass(frozen=True, slots=True)
class Threshold:
    """Value at which a share of trials succeeds, with its 95 % credible interval."""

    share: float
    value: float
    """Posterior median."""
    interval: Interval


class AdaptiveCurve:
    """Posterior of a curve P = (1 - lapse) (1 - (1 - expit(z))**shape), with z linear in the value.

    Parameters
    ----------
    low, high
        Range of the trials' values, and of the curve's middle, whose prior is uniform.
    shares
        Shares whose values are estimated.
    rising
        True if the share rises with the value.
    """

    def __init__(self, low: float, high: float, shares: Sequence[float], *, rising: bool = False) -> None:
        self.values: Floats = np.linspace(low, high, TRIAL_VALUES)
        """Values that `next_value` chooses from."""
        span = high - low
        middle = np.linspace(low, high, MIDDLES)
        width = np.geomspace(WIDTH_SPAN[0] * span, WIDTH_SPAN[1] * span, WIDTHS)
        grid = np.meshgrid(middle, width, LAPSES, SHAPES, indexing="ij")
        self._middle, self._width, self._lapse, self._shape = (part.ravel() for part in grid)
        self._sign = 1.0 if rising else -1.0
        self._at_half = _inverse(np.full_like(self._shape, 0.5), self._shape)
        self._posterior = np.full(len(self._middle), 1.0 / len(self._middle))
        self._success = self._shares(self.values)
        self._wanted = np.array([self._values_at(share) for share in shares])

    def next_value(self) -> float:
        """Return the value of the trial with the least expected variance of the wanted values, summed over shares."""
        variance = np.zeros(len(self.values))
        for likelihood in (self._success, 1.0 - self._success):
            total = likelihood @ self._posterior
            for wanted in self._wanted:
                mean = likelihood @ (self._posterior * wanted) / total
                # Variance after this outcome, times its probability.
                variance += likelihood @ (self._posterior * wanted**2) - total * mean**2
        return float(self.values[int(variance.argmin())])

    def add(self, value: float, outcome: float) -> None:
        """Add a trial: 1 is a success, 0 a failure, a number in between the share of successes in the trial."""
        p = np.clip(self._shares(np.array([value]))[0], 1e-9, 1.0 - 1e-9)
        posterior = self._posterior * p**outcome * (1.0 - p) ** (1.0 - outcome)
        self._posterior = posterior / posterior.sum()

    def threshold(self, share: float) -> Threshold:
        """Return the value at which a share of trials succeeds."""
        value = self._values_at(share)
        order = np.argsort(value, kind="stable")
        cumulative = np.cumsum(self._posterior[order])
        at = np.minimum(np.searchsorted(cumulative, (TAIL, 0.5, 1.0 - TAIL)), len(order) - 1)
        low, median, high = value[order][at].tolist()
        return Threshold(share, median, (low, high))

    def curve(self) -> tuple[Floats, Floats, Floats]:
        """Return the posterior mean and the 95 % limits (K,) of the share at `values`."""
        order = np.argsort(self._success, axis=1)
        cumulative = np.cumsum(self._posterior[order], axis=1)
        rows = np.arange(len(order))
        low, high = (
            self._success[rows, order[rows, np.minimum((cumulative < tail).sum(axis=1), order.shape[1] - 1)]]
            for tail in (TAIL, 1.0 - TAIL)
        )
        return self._success @ self._posterior, low, high

    def _values_at(self, share: float) -> Floats:
        """(G,) value at which a share of trials succeeds, within the range, by curve of the grid."""
        of_curve = np.minimum(share / (1.0 - self._lapse), 1.0 - 1e-12)
        value = self._middle + self._sign * self._width * (_inverse(of_curve, self._shape) - self._at_half)
        return np.clip(value, self.values[0], self.values[-1])

    def _shares(self, values: Floats) -> Floats:
        """(K, G) share of successes at values (K,), by curve of the grid."""
        z = self._sign * (values[:, None] - self._middle) / self._width + self._at_half
        shares: Floats = (1.0 - self._lapse) * (1.0 - scipy.special.expit(-z) ** self._shape)
        return shares


def _inverse(share: Floats, shape: Floats) -> Floats:
    """Return z (G,) at which 1 - (1 - expit(z))**shape is a share (G,)."""
    z: Floats = -scipy.special.logit((1.0 - share) ** (1.0 / shape))
    return z
