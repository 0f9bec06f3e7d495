"""Time-correlated errors of the tracked corners of T vehicles, see `luxloop.tracker.tracking.corner_error`."""

import math

import numpy as np

from luxloop.tracker.arrays import Bools, Floats
from luxloop.tracker.compiled import kernel


@kernel()
def variance_along(covariance: Floats, x: float, y: float) -> float:
    """Variance of a covariance (2, 2) along a unit vector x, y."""
    return float(x * x * covariance[0, 0] + 2.0 * x * y * covariance[0, 1] + y * y * covariance[1, 1])


@kernel()
def rotated(variance: Floats, heading: Floats) -> Floats:
    """(T, 2, 2) covariances with variances (T, 2) along and across headings (T,)."""
    covariance = np.empty((len(heading), 2, 2))
    for t in range(len(heading)):
        x, y = math.cos(heading[t]), math.sin(heading[t])
        along, across = variance[t]
        covariance[t, 0, 0] = x * x * along + y * y * across
        covariance[t, 1, 1] = y * y * along + x * x * across
        covariance[t, 0, 1] = covariance[t, 1, 0] = x * y * (along - across)
    return covariance


@kernel()
def released(variance: Floats, exact: Bools, covariance: Floats, heading: Floats) -> Floats:
    """(T, 2, 2) covariances of the past errors (T, 2) that observations with covariances (T, 2, 2) remove.

    They are `exact` (T, 2) along and across the headings (T,).
    """
    removed = np.zeros_like(variance)
    for t in range(len(heading)):
        x, y = math.cos(heading[t]), math.sin(heading[t])
        if exact[t, 0]:
            removed[t, 0] = max(variance[t, 0] - variance_along(covariance[t], x, y), 0.0)
        if exact[t, 1]:
            removed[t, 1] = max(variance[t, 1] - variance_along(covariance[t], -y, x), 0.0)
    return rotated(removed, heading)


@kernel()
def observe(variance: Floats, exact: Bools, covariance: Floats, heading: Floats, least: float) -> Floats:
    """(T, 2) variances after observations with covariances (T, 2, 2) that are `exact` (T, 2) along and across."""
    observed = np.empty_like(variance)
    for t in range(len(heading)):
        x, y = math.cos(heading[t]), math.sin(heading[t])
        observed[t, 0] = variance_along(covariance[t], x, y) if exact[t, 0] else max(variance[t, 0], least)
        observed[t, 1] = variance_along(covariance[t], -y, x) if exact[t, 1] else max(variance[t, 1], least)
    return observed
