"""Interval of a median from order statistics, which needs no assumption on the distribution.

The number of values below the median is binomial for any distribution (Thompson 1936, Annals of Mathematical Statistics
7, 122). Interpolation between two order statistics brings the coverage close to the nominal one
(Hettmansperger and Sheather 1986, Statistics and Probability Letters 4, 75). A mean has no such interval: a few seeds
rarely contain the rare large values that dominate it.
"""

import functools

import numpy as np
import scipy

from luxloop.scenarios.arrays import Floats
from luxloop.scenarios.statistics.confidence import CONFIDENCE, FEWEST_SEEDS, Interval


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
    return float(1.0 - 2.0 * scipy.stats.binom.cdf(rank - 1, n, 0.5))
