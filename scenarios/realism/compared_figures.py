"""Figures that are compared, with their units, averages and limits."""

from typing import Literal, NamedTuple

import numpy as np

from luxloop.scenarios.arrays import Floats, Ints
from luxloop.scenarios.statistics.intervals import Interval
from luxloop.scenarios.statistics.jackknife import ANY, cluster_median_interval, ratio_interval

Average = Literal["median", "mean"]


class Figure(NamedTuple):
    """A compared figure."""

    name: str
    """Column of the tables."""
    label: str
    unit: str
    average: Average
    tolerance: float
    """Largest deviation of the simulated average, as a share of the real one."""
    by_quartiles: bool
    """True if a simulated average inside the real quartiles also agrees."""
    scale: float
    """Printed value over that of the tables."""
    digits: int
    """Printed decimals."""


TOLERANCE, METHOD_TOLERANCE = 0.25, 0.5
"""Heading errors have heavy tails, so that their means vary more than medians of shapes."""


def _shape(name: str, label: str, unit: str = "cm", average: Average = "median") -> Figure:
    return Figure(name, label, unit, average, TOLERANCE, True, 100.0 if unit in ("cm", "%") else 1.0, 1)


def _method(name: str) -> Figure:
    label = f"heading error {name}"
    return Figure(f"{name}_error_deg", label, "deg", "mean", METHOD_TOLERANCE, False, 1.0, 2)


def bow_figure(name: str, label: str) -> Figure:
    """Return the bow in a height band as a compared figure."""
    return _shape(name, label)


FIGURES = (
    _shape("bow_end_m", "bow end"),
    _shape("bow_flank_m", "bow flank"),
    _shape("layers_apart_end_m", "layers apart end"),
    _shape("layers_apart_flank_m", "layers apart flank"),
    _shape("std_about_faces_m", "spread about the faces"),
    _shape("line_noise_end_m", "line noise end"),
    _shape("line_noise_flank_m", "line noise flank"),
    _shape("share_10cm_inside", "more than 10 cm inside", "%", "mean"),
    _shape("share_20cm_inside", "more than 20 cm inside", "%", "mean"),
    _shape("share_40cm_inside", "more than 40 cm inside", "%", "mean"),
    _shape("share_10cm_outside", "more than 10 cm outside", "%", "mean"),
    _shape("points_per_m_layer", "points per m and layer", "1/m"),
    _shape("layers", "layers that hit", "1"),
    _shape("share_on_lines", "share on lines", "%"),
    *(_method(name) for name in ("area", "closeness", "variance", "tlinkage", "best")),
)


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


Verdict = Literal["agrees", "differs", "n/a"]


class ComparedRow(NamedTuple):
    """A figure of real and of simulated vehicles."""

    figure: Figure
    real: Summary | None
    simulated: Summary | None

    @property
    def verdict(self) -> Verdict:
        """Verdict by the figure's tolerance and the real quartiles."""
        if self.real is None or self.simulated is None:
            return "n/a"
        value, (low, high) = self.simulated.value, self.real.quartiles
        near = abs(value - self.real.value) <= self.figure.tolerance * abs(self.real.value)
        return "agrees" if near or (self.figure.by_quartiles and low <= value <= high) else "differs"
