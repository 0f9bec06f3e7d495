"""Interval of the mean of few values in a known range, such as the share of runs that keep a track in each seed.

The weights of the values are drawn from a flat Dirichlet distribution, together with one more value that was not
seen: at the lower or at the upper end of the range, with equal probability (Gaffke 2005, Three test statistics for a
nonparametric one-sided hypothesis on the mean of a nonnegative variable; Learned-Miller and Thomas 2019, A New
Confidence Interval for the Mean of a Bounded Random Variable, who always take the less favourable end). For values at
the ends of the range, such as 0 and 1, this is the mid-p interval of Clopper and Pearson (Lancaster 1961, J. Am.
Statistical Association 56, 223). Without any 1 in n values its upper limit is 1 - 0.05**(1/n): at most 3/n, the rule
of three.
"""

import functools

import numpy as np
import scipy

from luxloop.scenarios.arrays import Floats
from luxloop.scenarios.statistics.confidence import TAIL, Interval

DRAWS = 20000
SEED = 0
"""Fixed for reproducible intervals."""


def bounded_mean_interval(values: Floats, low: float = 0.0, high: float = 1.0) -> Interval:
    """Return the interval of the mean of independent `values` (n,) from `low` to `high`."""
    at_end = (values == low) | (values == high)
    if at_end.all():
        first, last = mid_p_interval(int((values == high).sum()), len(values))
        return low + (high - low) * first, low + (high - low) * last
    weight = np.random.default_rng(SEED).dirichlet(np.ones(len(values) + 1), DRAWS)
    seen = weight[:, :-1] @ np.sort(values)
    means = np.concatenate([seen + weight[:, -1] * low, seen + weight[:, -1] * high])
    first, last = np.quantile(means, (TAIL, 1.0 - TAIL))
    return float(first), float(last)


@functools.cache
def mid_p_interval(successes: int, trials: int) -> Interval:
    """Return the mid-p interval of a proportion."""

    def limit(tail: float) -> float:
        def excess(share: float) -> float:
            return _mid_p(successes, trials, share) - tail

        return float(scipy.optimize.brentq(excess, 0.0, 1.0, xtol=1e-12))

    return (0.0 if successes == 0 else limit(TAIL)), (1.0 if successes == trials else limit(1.0 - TAIL))


def _mid_p(successes: int, trials: int, share: float) -> float:
    """Return the probability of more successes, and half of that of as many, given the true share; it grows with it."""
    more = scipy.stats.binom.sf(successes, trials, share)
    return float(more + 0.5 * scipy.stats.binom.pmf(successes, trials, share))
