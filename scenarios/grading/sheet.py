"""The sheet that metrics are written on: known names only, each once, and no number where there was nothing to see."""

import math

import numpy as np
import numpy.typing as npt

from scenarios.grading.metrics import METRICS
from scenarios.result import Metric

Values = npt.NDArray[np.float64] | npt.NDArray[np.bool_]


class MetricSheet:
    """Metrics of one run, filled in family by family."""

    def __init__(self) -> None:
        self.metrics: dict[str, Metric] = {}

    def write(self, name: str, value: float | None, n: int, why_none: str) -> None:
        """Enter a metric of `n` observations; with none, or where `value` is None, it is None for the reason given.

        Raises
        ------
        ValueError
            The name is not in the registry, is on the sheet already, or the value is not finite.
        """
        if name not in METRICS:
            raise ValueError(f"{name} is no metric; define it in scenarios/grading/metrics.py")
        if name in self.metrics:
            raise ValueError(f"metric {name} is on the sheet already")
        if value is None or n == 0:
            self.metrics[name] = Metric(None, METRICS[name], n, why_none)
            return
        if not math.isfinite(value):
            raise ValueError(f"metric {name} is {value} over {n} observations")
        self.metrics[name] = Metric(float(value), METRICS[name], n)

    def mean(self, name: str, values: Values, why_none: str) -> None:
        """Enter the mean of `values` (n,)."""
        self.write(name, float(np.mean(values)) if len(values) else None, len(values), why_none)

    def std(self, name: str, values: Values, why_none: str) -> None:
        """Enter the standard deviation of `values` (n,), squares divided by n."""
        self.write(name, float(np.std(values)) if len(values) else None, len(values), why_none)

    def rate(self, name: str, part: int, whole: int, why_none: str) -> None:
        """Enter `part` / `whole`."""
        self.write(name, part / whole if whole else None, whole, why_none)
