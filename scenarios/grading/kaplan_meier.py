"""Kaplan-Meier estimate of the distribution of times that may be censored (J. Am. Statistical Association 53, 1958)."""

import math

import numpy as np
import scipy

from luxloop.scenarios.arrays import Bools, Floats


def survival(times: Floats, reached: Bools) -> tuple[Floats, Floats]:
    """Return the estimated survival function.

    Parameters
    ----------
    times
        (N,) time of each event, or of the end of the observation without one.
    reached
        (N,) True for events, False for censored times.

    Returns
    -------
    tuple of arrays
        (K,) distinct times in ascending order, and the share of events that come later (K,).
    """
    data = scipy.stats.CensoredData.right_censored(times, ~reached)
    curve = scipy.stats.ecdf(data).sf
    return np.asarray(curve.quantiles, np.float64), np.asarray(curve.probabilities, np.float64)


def median(times: Floats, reached: Bools) -> float:
    """Return the least time at which half of the events have happened; infinite if the estimate stays above."""
    if not len(times):
        return math.inf
    at, share = survival(times, reached)
    half = np.flatnonzero(share <= 0.5 + 1e-12)
    return float(at[half[0]]) if len(half) else math.inf
