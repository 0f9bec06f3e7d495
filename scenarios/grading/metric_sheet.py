"""The sheet that metrics are written on: known names only, each once, and no number where there was nothing to see."""

import math

import numpy as np

from scenarios.arrays import Bools, Floats, Ints
from scenarios.grading.bootstrap import Bootstrap, Interval
from scenarios.grading.metric_names import METRICS
from scenarios.result import Metric

Values = Floats | Bools


class MetricSheet:
    """Metrics of one run, filled in family by family.

    Parameters
    ----------
    bootstrap
        Of the run's vehicles; without it no metric has an interval.
    """

    def __init__(self, bootstrap: Bootstrap | None = None) -> None:
        self.metrics: dict[str, Metric] = {}
        self._bootstrap = bootstrap

    def write(self, name: str, value: float | None, n: int, why_none: str, interval: Interval | None = None) -> None:
        """Enter a metric of `n` observations; with none, or where `value` is None, it is None for the reason given.

        Raises
        ------
        ValueError
            The name is not in the registry, is on the sheet already, or the value is not finite.
        """
        if name not in METRICS:
            raise ValueError(f"{name} is no metric; define it in scenarios/grading/metric_names.py")
        if name in self.metrics:
            raise ValueError(f"metric {name} is on the sheet already")
        if value is None or n == 0:
            self.metrics[name] = Metric(None, METRICS[name], n, why_none)
            return
        if not math.isfinite(value):
            raise ValueError(f"metric {name} is {value} over {n} observations")
        self.metrics[name] = Metric(float(value), METRICS[name], n, interval=interval)

    def mean(self, name: str, values: Values, why_none: str, vehicle: Ints | None = None) -> None:
        """Enter the mean of `values` (n,), with its interval if the vehicles (n,) they are of are given."""
        self.ratio(name, values.astype(np.float64), np.ones(len(values)), why_none, vehicle)

    def ratio(self, name: str, part: Floats, whole: Floats, why_none: str, vehicle: Ints | None = None) -> None:
        """Enter sum `part` (n,) over sum `whole` (n,), likewise."""
        interval = None
        if vehicle is not None and self._bootstrap:
            interval = self._bootstrap.of_ratio(vehicle, part, whole)
        self.write(name, float(part.sum() / whole.sum()) if len(part) else None, len(part), why_none, interval)

    def std(self, name: str, values: Floats, why_none: str, vehicle: Ints | None = None) -> None:
        """Enter the standard deviation of `values` (n,), squares divided by n, likewise."""
        interval = None
        if vehicle is not None and self._bootstrap:
            interval = self._bootstrap.of_std(vehicle, values)
        self.write(name, float(np.std(values)) if len(values) else None, len(values), why_none, interval)

    def rate(self, name: str, part: int, whole: int, why_none: str) -> None:
        """Enter `part` / `whole`."""
        self.write(name, part / whole if whole else None, whole, why_none)
