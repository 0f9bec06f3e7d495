"""Figures that are compared, with their units, averages and limits."""

from typing import Literal, NamedTuple

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
