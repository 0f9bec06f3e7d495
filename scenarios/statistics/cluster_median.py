"""Interval of the median of correlated observations: that of the share below it, turned into values.

Woodruff 1952, J. Am. Statistical Association 47, 635.
"""

import numpy as np

from luxloop.scenarios.arrays import Floats, Ints
from luxloop.scenarios.statistics.confidence import Interval
from luxloop.scenarios.statistics.jackknife import SHARE, ratio_interval


def cluster_median_interval(cluster: Ints, values: Floats) -> Interval | None:
    """Return the interval of the median of `values` (n,) of vehicles `cluster` (n,); None as for `ratio_interval`."""
    median = np.median(values)
    below = 0.5 * ((values < median).astype(np.float64) + (values <= median))
    shares = ratio_interval(cluster, below, np.ones_like(values), SHARE)
    if shares is None:
        return None
    low, high = np.quantile(values, shares)
    return float(low), float(high)
