"""Intervals of figures that follow from sums over clusters, by leaving out one cluster after the other.

Observations of one vehicle are correlated from frame to frame, so that vehicles are the clusters. The variance is
that of the delete-one jackknife (Tukey 1958; Efron and Stein 1981, Annals of Statistics 9, 586), and the quantile
Student's with the effective number of clusters by their weights (Kish 1965, Survey Sampling, section 8.2). The scale
is that of the figure: for a share the exact interval with the number of independent observations that has the variance,
logarithms of the distance from the end of the range for errors and scores with one natural end, else linear.

A figure has no interval for too few effective clusters, and where the approximation behind it fails: the standard error
exceeds the figure on a logarithmic scale, or a limit is outside the possible range.

The interval of a median is that of the share below it, turned into values (Woodruff 1952, J. Am. Statistical
Association 47, 635).
"""

import math

import numpy as np
import scipy

from luxloop.arrays import Floats, Ints
from luxloop.scenarios.statistics.intervals import (
    CONFIDENCE,
    FEWEST_CLUSTERS,
    TAIL,
    Interval,
    binomial_interval,
    effective_number,
)

MOST_OF_CLUSTER = 4.0
"""Independent observations that a cluster counts as at most. Vehicles that agree say little about those not seen:
without this limit, intervals of shares of 8 to 30 vehicles contain the true one in 67 to 90 % of the cases."""
ROUNDING = 1e-9
"""Tolerance for rounding in the number of effective clusters."""

ANY, POSITIVE, SHARE = (-math.inf, math.inf), (0.0, math.inf), (0.0, 1.0)
"""Possible ranges of a figure."""


def ratio_interval(cluster: Ints, part: Floats, whole: Floats, within: Interval) -> Interval | None:
    """Return the interval of sum `part` (n,) over sum `whole` (n,).

    Parameters
    ----------
    cluster
        (n,) vehicle of each observation.
    within
        Possible range of the ratio.

    Returns
    -------
    Interval or None
        None as for `jackknife_interval`.
    """
    sums = sums_by_cluster(cluster, part, whole)
    sums = sums[sums[:, 1] > 0.0]
    if len(sums) < FEWEST_CLUSTERS:
        return None
    total = sums.sum(axis=0)
    rest = total - sums
    return jackknife_interval(float(total[0] / total[1]), rest[:, 0] / rest[:, 1], sums[:, 1], within)


def std_interval(cluster: Ints, values: Floats, within: Interval = POSITIVE) -> Interval | None:
    """Return the interval of the standard deviation of `values` (n,); parameters and None as for `ratio_interval`."""
    sums = sums_by_cluster(cluster, np.ones_like(values), values, values**2)
    if len(sums) < FEWEST_CLUSTERS:
        return None
    total = sums.sum(axis=0)
    return jackknife_interval(float(_std(total[None])[0]), _std(total - sums), sums[:, 0], within)


def sums_by_cluster(cluster: Ints, *columns: Floats) -> Floats:
    """(V, columns) sums of each of the V clusters."""
    found, row = np.unique(cluster, return_inverse=True)
    return np.stack([np.bincount(row, column, len(found)) for column in columns], axis=1)


def jackknife_interval(value: float, without: Floats, weight: Floats, within: Interval) -> Interval | None:
    """Return the interval of a figure.

    Parameters
    ----------
    value
        The figure over all clusters.
    without
        (V,) the figure without each cluster.
    weight
        (V,) observations of each cluster.
    within
        Possible range of the figure. An error from 0 on, and a score up to a largest value, have a logarithmic scale.

    Returns
    -------
    Interval or None
        None for fewer than `FEWEST_CLUSTERS` effective clusters, a standard error that exceeds the figure on a
        logarithmic scale, and a limit outside the possible range. A figure of 0 on this scale has none either.
    """
    clusters = effective_clusters(weight)
    if clusters < FEWEST_CLUSTERS - ROUNDING:
        return None
    error = standard_error(value, without)
    if within == SHARE:
        return _of_share(value, error, clusters)
    quantile = student(clusters)
    low, high = within
    if low == 0.0:
        limits = _logarithmic(value, error, quantile)
    elif low == -math.inf and high < math.inf:
        mirrored = _logarithmic(high - value, error, quantile)
        limits = mirrored and (high - mirrored[1], high - mirrored[0])
    else:
        limits = value - quantile * error, value + quantile * error
    return limits if limits and low <= limits[0] and limits[1] <= high else None


def effective_clusters(weight: Floats) -> float:
    """Return the number of equal clusters with the same variance as those of `weight` (V,) (Kish 1965)."""
    return float(weight.sum() ** 2 / max(float((weight**2).sum()), 1e-300))


def standard_error(value: float, without: Floats) -> float:
    """Return the standard error; a cluster without which there is no value is taken as without effect."""
    n = len(without)
    change = np.where(np.isfinite(without), without - value, 0.0)
    return math.sqrt((n - 1) / n * float((change**2).sum())) if n > 1 else math.nan


def student(clusters: float) -> float:
    """Return Student's quantile for a number of effective clusters, which need not be whole."""
    return float(scipy.special.stdtrit(max(clusters - 1.0, 1.0), 0.5 + 0.5 * CONFIDENCE))


def _logarithmic(distance: float, error: float, quantile: float) -> Interval | None:
    """Return the limits of a distance; None if it is 0 or less than its standard error."""
    if distance <= 0.0 or error > distance:
        return None
    factor = math.exp(quantile * error / distance)
    return distance / factor, distance * factor


def _of_share(value: float, error: float, clusters: float) -> Interval:
    """Return the exact interval of a share with an effective number of observations."""
    share = np.array([min(max(value, 0.0), 1.0)])
    if share[0] in (0.0, 1.0):
        unseen = 1.0 - (2.0 * TAIL) ** (1.0 / clusters)  # rule of three
        return (0.0, unseen) if share[0] == 0.0 else (1.0 - unseen, 1.0)
    few = float(scipy.special.ndtri(1.0 - TAIL)) / student(clusters)
    number = np.clip(effective_number(share, np.array([error**2]), few), 1.0, MOST_OF_CLUSTER * clusters)
    first, last = binomial_interval(share, number)
    return float(first[0]), float(last[0])


def _std(sums: Floats) -> Floats:
    """(R,) standard deviations from counts, totals and totals of squares (R, 3)."""
    mean = sums[:, 1] / sums[:, 0]
    return np.sqrt(np.maximum(sums[:, 2] / sums[:, 0] - mean**2, 0.0))


def cluster_median_interval(cluster: Ints, values: Floats) -> Interval | None:
    """Return the interval of the median of `values` (n,) of vehicles `cluster` (n,); None as for `ratio_interval`."""
    median = np.median(values)
    below = 0.5 * ((values < median).astype(np.float64) + (values <= median))
    shares = ratio_interval(cluster, below, np.ones_like(values), SHARE)
    if shares is None:
        return None
    low, high = np.quantile(values, shares)
    return float(low), float(high)
