"""Averages with bootstrap intervals over vehicles.

The matched observations of one simulated vehicle are correlated, so that whole vehicles are resampled, as for the
metrics of a run (`scenarios.grading.bootstrap`).
"""

from typing import NamedTuple

import numpy as np

from scenarios.arrays import Floats, Ints
from scenarios.grading.bootstrap import QUANTILES, Bootstrap
from scenarios.realism.compared_figures import Average


class Summary(NamedTuple):
    """Average of a figure over vehicles, with its 95 % interval and the quartiles of the vehicles."""

    value: float
    interval: tuple[float, float] | None
    """None for a single vehicle."""
    quartiles: tuple[float, float]
    n: int
    """Number of values."""


def summarise(values: Floats, vehicle: Ints, average: Average) -> Summary | None:
    """Return the average of the finite `values` (N,) of vehicles (N,), or None without any."""
    finite = np.isfinite(values)
    values, vehicle = values[finite], vehicle[finite]
    if not len(values):
        return None
    low, high = np.quantile(values, (0.25, 0.75))
    value = float(np.median(values) if average == "median" else np.mean(values))
    return Summary(value, _interval(values, vehicle, average), (float(low), float(high)), len(values))


def _interval(values: Floats, vehicle: Ints, average: Average) -> tuple[float, float] | None:
    if len(np.unique(vehicle)) < 2:
        return None
    if average == "mean":
        return Bootstrap(vehicle).of_ratio(vehicle, values, np.ones_like(values))
    low, high = np.quantile(_medians(values, vehicle), QUANTILES)
    return float(low), float(high)


def _medians(values: Floats, vehicle: Ints) -> Floats:
    """Return the median (R,) of each resample of whole vehicles."""
    resamples = Bootstrap(vehicle)
    order = np.argsort(values, kind="stable")
    times = resamples.times[:, np.searchsorted(resamples.vehicles, vehicle[order])]
    below = np.cumsum(times, axis=1)
    middle = 0.5 * below[:, -1:]
    lower, upper = (values[order][np.argmax(mask, axis=1)] for mask in (below >= middle, below > middle))
    medians: Floats = 0.5 * (lower + upper)
    return medians
