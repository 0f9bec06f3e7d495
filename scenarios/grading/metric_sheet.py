"""Collection of the metrics of a run: known names only, each once, and no number without observations."""

import math

import numpy as np

from luxloop.scenarios.arrays import Bools, Floats, Ints
from luxloop.scenarios.grading.metric_names import METRICS
from luxloop.scenarios.grading.metric_range import possible_range
from luxloop.scenarios.result import Metric
from luxloop.scenarios.statistics.confidence import Interval
from luxloop.scenarios.statistics.jackknife import ratio_interval, std_interval

Values = Floats | Bools


class MetricSheet:
    """Metrics of one run, entered family by family."""

    def __init__(self) -> None:
        self.metrics: dict[str, Metric] = {}

    def write(self, name: str, value: float | None, n: int, why_none: str, interval: Interval | None = None) -> None:
        """Enter a metric.

        Parameters
        ----------
        name
            A name of `metric_names.METRICS`.
        value
            Its value; None without one.
        n
            Number of observations; without any the metric is None, too.
        why_none
            Reason of a missing value.
        interval
            95 % interval.

        Raises
        ------
        ValueError
            The name is unknown or entered already, or the value is not finite.
        """
        if name not in METRICS:
            raise ValueError(f"unknown metric {name}; define it in scenarios/grading/metric_names.py")
        if name in self.metrics:
            raise ValueError(f"metric {name} is on the sheet already")
        if value is None or n == 0:
            self.metrics[name] = Metric(None, METRICS[name], n, why_none)
            return
        if not math.isfinite(value):
            raise ValueError(f"metric {name} is {value} over {n} observations")
        self.metrics[name] = Metric(float(value), METRICS[name], n, interval=interval)

    def mean(self, name: str, values: Values, why_none: str, vehicle: Ints | None = None) -> None:
        """Enter the mean of `values` (n,), with an interval if their vehicles (n,) are given."""
        self.ratio(name, values.astype(np.float64), np.ones(len(values)), why_none, vehicle)

    def ratio(self, name: str, part: Floats, whole: Floats, why_none: str, vehicle: Ints | None = None) -> None:
        """Enter sum `part` (n,) over sum `whole` (n,), with an interval if their vehicles (n,) are given."""
        interval = None
        if vehicle is not None:
            interval = ratio_interval(vehicle, part, whole, possible_range(name))
        self.write(name, float(part.sum() / whole.sum()) if len(part) else None, len(part), why_none, interval)

    def std(self, name: str, values: Floats, why_none: str, vehicle: Ints | None = None) -> None:
        """Enter the standard deviation (divided by n) of `values` (n,), with an interval if vehicles (n,) are given."""
        interval = None
        if vehicle is not None:
            interval = std_interval(vehicle, values)
        self.write(name, float(np.std(values)) if len(values) else None, len(values), why_none, interval)

    def rate(self, name: str, part: int, whole: int, why_none: str) -> None:
        """Enter `part` / `whole`, with `whole` observations."""
        self.write(name, part / whole if whole else None, whole, why_none)
