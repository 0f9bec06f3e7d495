"""Figures of a kind that is computed as a whole: known names only, each once, and no number without observations."""

import math

import numpy as np

from luxloop.arrays import Bools, Floats, Ints
from luxloop.scenarios.metrics.definitions import find_metric
from luxloop.scenarios.result import Metric
from luxloop.scenarios.statistics.intervals import NO_ERROR, TOO_FEW, Interval
from luxloop.scenarios.statistics.jackknife import ratio_interval

Values = Floats | Bools


class MetricSheet:
    """Figures that are computed together, by the names of their metrics."""

    def __init__(self) -> None:
        self.metrics: dict[str, Metric] = {}

    def write(
        self,
        name: str,
        value: float | None,
        n: int,
        why_none: str,
        interval: Interval | None = None,
        why_no_interval: str = "",
    ) -> None:
        """Enter a metric.

        Parameters
        ----------
        name
            Name of the metric, with its parameters.
        value
            Its value; None without one.
        n
            Number of observations; without any the metric is None, too.
        why_none
            Reason of a missing value.
        interval
            95 % interval.
        why_no_interval
            Reason of a missing interval; empty for figures that have none by their kind, such as counts.

        Raises
        ------
        ValueError
            The name is unknown or entered already, or the value is not finite.
        """
        unit = find_metric(name).unit
        if name in self.metrics:
            raise ValueError(f"metric {name} is on the sheet already")
        if value is None or n == 0:
            self.metrics[name] = Metric(None, unit, n, why_none)
            return
        if not math.isfinite(value):
            raise ValueError(f"metric {name} is {value} over {n} observations")
        self.metrics[name] = Metric(
            float(value), unit, n, interval=interval, why_no_interval="" if interval else why_no_interval
        )

    def mean(self, name: str, values: Values, why_none: str, vehicle: Ints | None = None) -> None:
        """Enter the mean of `values` (n,), with an interval if their vehicles (n,) are given."""
        self.ratio(name, values.astype(np.float64), np.ones(len(values)), why_none, vehicle)

    def ratio(self, name: str, part: Floats, whole: Floats, why_none: str, vehicle: Ints | None = None) -> None:
        """Enter sum `part` (n,) over sum `whole` (n,), with an interval if their vehicles (n,) are given."""
        value = float(part.sum() / whole.sum()) if len(part) else None
        if vehicle is None:
            self.write(name, value, len(part), why_none)
            return
        interval = ratio_interval(vehicle, part, whole, find_metric(name).definition.range)
        self.write(name, value, len(part), why_none, interval, why_no_interval(value))

    def rate(self, name: str, part: int, whole: int, why_none: str) -> None:
        """Enter `part` / `whole`, with `whole` observations."""
        self.write(name, part / whole if whole else None, whole, why_none)


def why_no_interval(value: float | None) -> str:
    """Return the reason for a figure over vehicles: an error of 0 is that of all of them, and has no scale."""
    return NO_ERROR if value == 0.0 else TOO_FEW
