"""Metrics of files by name, with the reason of a missing value."""

from luxloop.scenarios.arrays import Floats
from luxloop.scenarios.exchange.box_metric_names import DEFINITIONS
from luxloop.scenarios.result import Metric


def metric(name: str, value: float | None, n: int, why_none: str) -> dict[str, Metric]:
    """Return a metric; without a value or observations it has the reason `why_none`."""
    unit = DEFINITIONS[name].unit
    known = value is not None and n > 0
    return {name: Metric(float(value), unit, n) if known and value is not None else Metric(None, unit, n, why_none)}


def mean(name: str, values: Floats, why_none: str) -> dict[str, Metric]:
    """Return the mean of values (n,)."""
    return metric(name, float(values.mean()) if len(values) else None, len(values), why_none)
