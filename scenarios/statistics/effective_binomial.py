"""Interval of a share from correlated observations: that of as many independent ones as have its variance.

Clopper and Pearson 1934, Biometrika 26, 404, with the effective number of observations by Korn and Graubard 1998,
Survey Methodology 24, 193. It stays within 0 and 1, and has a width also if all observations agree.
"""

import numpy as np
import scipy

from luxloop.scenarios.arrays import Floats
from luxloop.scenarios.statistics.confidence import TAIL


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
    low = scipy.stats.beta.ppf(TAIL, count, number - count + 1.0)
    high = scipy.stats.beta.ppf(1.0 - TAIL, count + 1.0, number - count)
    return np.where(share <= 0.0, 0.0 * number, low), np.where(share >= 1.0, 1.0 + 0.0 * number, high)
