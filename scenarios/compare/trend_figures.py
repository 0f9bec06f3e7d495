"""Figures of trends: one of each metric for all runs together, and small lines for each scenario."""

from typing import TYPE_CHECKING

import numpy as np
from markupsafe import Markup, escape

from luxloop.scenarios.arrays import Floats
from luxloop.scenarios.compare.compared_metrics import ComparedMetric
from luxloop.scenarios.compare.comparison import MetricVerdict
from luxloop.scenarios.compare.trend_values import KEY_METRICS, TITLES, Trends
from luxloop.scenarios.document.figure import Figure
from luxloop.scenarios.document.palette import BAD, BLUE, GOOD, WARN

if TYPE_CHECKING:
    from matplotlib.figure import Figure as Canvas

COLORS: dict[MetricVerdict, str] = {"worse": BAD, "lost": BAD, "better": GOOD, "unclear": WARN}
LONGEST_LABEL = 14
"""Characters of a name under an axis; the table beside the figures has the whole names."""
SPAN = 10.0
"""Smallest height of a small line [smallest relevant differences], so that noise looks flat."""
WIDTH, HEIGHT, EDGE = 96.0, 24.0, 4.0
"""Size of a small line and its margin [px]."""


def suite_figures(trends: Trends) -> list[Figure]:
    """Draw each key metric over the baselines, with the verdict against the baseline before as colour."""
    return [_suite_figure(trends, number, metric) for number, metric in enumerate(KEY_METRICS)]


def _suite_figure(trends: Trends, number: int, metric: ComparedMetric) -> Figure:
    shown = trends.suite[:, number]

    def on(canvas: "Canvas") -> None:
        axes = canvas.subplots()
        at = np.arange(len(shown))
        axes.plot(at, shown, color=BLUE, lw=1.6)
        for place, (value, verdicts) in enumerate(zip(shown, trends.verdicts, strict=True)):
            color = COLORS.get(verdicts.get(metric.name, "same"), BLUE)
            axes.plot(place, value, "o", color=color, ms=7 if color != BLUE else 4)
        low, high = _range(shown, metric)
        axes.set(xlim=(-0.3, len(shown) - 0.7), ylim=(low, high))
        axes.set_xticks(at, [_axis_label(label) for label in trends.labels], rotation=30, ha="right", fontsize=7.5)

    title = f"{TITLES[metric.name]}: {metric.better} is better"
    return Figure(f"suite-{number}", title, f"{metric.name} of all common runs together.", (5.0, 2.9), on)


def _axis_label(label: str) -> str:
    return label if len(label) <= LONGEST_LABEL else f"..{label[-LONGEST_LABEL + 2 :]}"


def small_line(values: Floats, changed: list[int], metric: ComparedMetric, name: str) -> Markup:
    """Draw one metric of one scenario over the baselines; hollow dots: the scenario itself was changed there."""
    low, high = _range(values, metric)
    x = np.linspace(EDGE, WIDTH - EDGE, len(values))
    y = EDGE + (HEIGHT - 2 * EDGE) * (high - values) / (high - low)
    parts = [
        f'<polyline points="{" ".join(f"{x[k]:.1f},{y[k]:.1f}" for k in run)}"/>'
        for run in _unbroken(np.isfinite(values), changed)
        if len(run) > 1
    ]
    parts += [f'<circle class="new" cx="{x[k]:.1f}" cy="{y[k]:.1f}" r="2"/>' for k in changed if np.isfinite(y[k])]
    seen = np.flatnonzero(np.isfinite(values))
    parts += [f'<circle cx="{x[k]:.1f}" cy="{y[k]:.1f}" r="2"/>' for k in seen[-1:]]
    opening = f'<svg class="small" viewBox="0 0 {WIDTH:g} {HEIGHT:g}" role="img" aria-label="{escape(name)}">'
    return Markup(opening + "".join(parts) + "</svg>")


def _unbroken(measured: "np.ndarray[tuple[int], np.dtype[np.bool_]]", changed: list[int]) -> list[list[int]]:
    """Split the measured baselines at gaps and where the scenario was changed."""
    runs: list[list[int]] = [[]]
    for place in range(len(measured)):
        if not measured[place] or place in changed:
            runs.append([])
        if measured[place]:
            runs[-1].append(place)
    return runs


def _range(values: Floats, metric: ComparedMetric) -> tuple[float, float]:
    """Return the limits of an axis, at least `SPAN` of the smallest relevant differences apart."""
    seen = values[np.isfinite(values)]
    low, high = (float(seen.min()), float(seen.max())) if len(seen) else (0.0, 1.0)
    missing = SPAN * metric.relevance.margin(high) - (high - low)
    half = max(missing, 0.1 * (high - low)) / 2.0
    bottom = max(low - half, 0.0) if low >= 0.0 else low - half
    return bottom, bottom + (high - low) + 2.0 * half
