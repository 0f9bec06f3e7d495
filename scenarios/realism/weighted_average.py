"""Averages with intervals over vehicles, because the matched observations of one simulated vehicle are correlated."""

from typing import NamedTuple

import numpy as np

from luxloop.scenarios.arrays import Floats, Ints
from luxloop.scenarios.realism.compared_figures import Average
from luxloop.scenarios.statistics.cluster_median import cluster_median_interval
from luxloop.scenarios.statistics.confidence import Interval
from luxloop.scenarios.statistics.jackknife import ANY, ratio_interval


class Summary(NamedTuple):
    """Average of a figure over vehicles, with its 95 % interval and the quartiles of the vehicles."""

    value: float
    interval: Interval | None
    """None for too few vehicles."""
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


def _interval(values: Floats, vehicle: Ints, average: Average) -> Interval | None:
    if average == "median":
        return cluster_median_interval(vehicle, values)
    return ratio_interval(vehicle, values, np.ones_like(values), ANY)
