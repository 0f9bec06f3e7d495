"""Confidence level and intervals of printed figures, and warnings of figures from few seeds.

`bounded_mean_interval` is for the mean of few values in a known range, such as the share of runs that keep a track in
each seed. The weights of the values are drawn from a flat Dirichlet distribution, together with one more value that was
not seen: at the lower or at the upper end of the range, with equal probability (Gaffke 2005, Three test statistics for
a nonparametric one-sided hypothesis on the mean of a nonnegative variable; Learned-Miller and Thomas 2019, A New
Confidence Interval for the Mean of a Bounded Random Variable, who always take the less favourable end). For values at
the ends of the range, such as 0 and 1, this is the mid-p interval of Clopper and Pearson (Lancaster 1961, J. Am.
Statistical Association 56, 223). Without any 1 in n values its upper limit is 1 - 0.05**(1/n): at most 3/n, the rule
of three.

`binomial_interval` of a share from correlated observations is that of as many independent ones as have its variance
(Clopper and Pearson 1934, Biometrika 26, 404; effective number by Korn and Graubard 1998, Survey Methodology 24, 193).
It stays within 0 and 1, and has a width also if all observations agree.

`median_interval` uses order statistics and assumes nothing about the distribution: the number of values below the
median is binomial (Thompson 1936, Annals of Mathematical Statistics 7, 122). Interpolation between two order statistics
brings the coverage close to the nominal one (Hettmansperger and Sheather 1986, Statistics and Probability Letters 4,
75). A mean has no such interval: a few seeds rarely contain the rare large values that dominate it.
"""

import functools

import numpy as np
import scipy

from luxloop.arrays import Floats

CONFIDENCE = 0.95
TAIL = 0.5 * (1.0 - CONFIDENCE)
FEWEST_SEEDS = 5
"""Fewest seeds with an interval of a median. The extremes of four values contain their median in 88 % of the cases only
(1 - 2 / 2**4); those of five in 94 %."""
FEWEST_CLUSTERS = 3
"""Fewest effective vehicles with an interval: equal ones that have the same variance. Student's quantile is 4.3 for
three, but 12.7 for two, so that limits of two mean nothing."""

TOO_FEW = "too few vehicles"
"""Printed where a figure over vehicles has no interval."""
NO_ERROR = "no vehicle has an error"
"""Printed where an interval would have no scale, because all vehicles are at the best value."""

Interval = tuple[float, float]


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


def effective_number(share: Floats, variance: Floats, few: Floats | float) -> Floats:
    """(K,) number of independent observations with the variance of the shares (K,).

    Parameters
    ----------
    few
        Student's quantile with the degrees of freedom of the observations over that of the variance: it lowers the
        number, because a variance from few clusters is uncertain itself.
    """
    number: Floats = share * (1.0 - share) / np.maximum(variance, 1e-12) * np.asarray(few) ** 2
    return number


def binomial_interval(share: Floats, number: Floats) -> tuple[Floats, Floats]:
    """Return the limits (K,) of shares (K,) of a number of observations (K,), which need not be whole."""
    count = share * number
    low = scipy.special.betaincinv(count, number - count + 1.0, TAIL)
    high = scipy.special.betaincinv(count + 1.0, number - count, 1.0 - TAIL)
    return np.where(share <= 0.0, 0.0 * number, low), np.where(share >= 1.0, 1.0 + 0.0 * number, high)


def median_interval(values: Floats) -> Interval | None:
    """Return the interval of the median of independent `values` (n,), or None for fewer than `FEWEST_SEEDS`."""
    if len(values) < FEWEST_SEEDS:
        return None
    weight, ordered = _weights(len(values)), np.sort(values)
    return float(weight @ ordered), float(weight[::-1] @ ordered)


@functools.cache
def _weights(n: int) -> Floats:
    """(n,) weights of the ordered values in the lower limit; those of the upper limit are mirrored."""
    rank = 1
    while 2 * (rank + 1) <= n and _coverage(rank + 1, n) >= CONFIDENCE:
        rank += 1
    weight = np.zeros(n)
    weight[rank - 1] = 1.0
    if 2 * (rank + 1) <= n and _coverage(rank, n) > CONFIDENCE:
        excess = _coverage(rank, n) - CONFIDENCE
        step = excess / (_coverage(rank, n) - _coverage(rank + 1, n))
        part = (n - rank) * step / (rank + (n - 2 * rank) * step)
        weight[rank - 1], weight[rank] = 1.0 - part, part
    return weight


def _coverage(rank: int, n: int) -> float:
    """Return the probability that the median lies between the values of this rank from below and from above."""
    return float(1.0 - 2.0 * scipy.special.bdtr(rank - 1, n, 0.5))


FEW_SEEDS = 10
"""Fewest seeds without a warning."""
DOMINANT = 0.5
"""Share of the sum over seeds that one seed has if it dominates."""
FEWEST_COMPARED = 3
"""Fewest seeds of which one can dominate."""


def few_seeds(seeds: int) -> str:
    """Return a warning for fewer than `FEW_SEEDS`, else an empty text."""
    return f"only {seeds} seeds: intervals are wide, and rare outcomes are not in them" if seeds < FEW_SEEDS else ""


def is_dominated(values: Floats) -> bool:
    """Return True if one of the `values` (n,), one per seed, has more than half of the sum of their magnitudes."""
    size = np.abs(values)
    return len(size) >= FEWEST_COMPARED and bool(size.max() > DOMINANT * size.sum() > 0.0)
