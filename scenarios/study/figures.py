"""Figures of a study: curves with confidence intervals and single seeds, and heat maps over two parameters."""

from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from luxloop.scenarios.document.figure import Figure, note
from luxloop.scenarios.document.palette import INK, PAGE, SERIES
from luxloop.scenarios.study.curves import estimates, is_binary, levels, seed_dots, seed_warnings
from luxloop.scenarios.study.study_file import Curve, Study

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure as Canvas

MARKERS = "osD^vP"
PANEL_IN = (2.9, 3.3)
"""[inch] Width and height of a panel with curves."""
WIDE_IN = 6.0
"""[inch] Figures wider than this span the page."""
CELL_IN = (0.62, 0.42)
"""[inch] Width and height of a cell of a map."""
DOT, FAINT_DOT = 7.0, 0.5
"""[points] Size and opacity of the dots of single seeds."""
DODGE = 0.012
"""Horizontal offset between neighbouring curves, as a fraction of the axis length."""
MAP_COLORS = "cividis"
"""Perceptually uniform and readable with colour vision deficiency (Nunez, Anderton and Renslow 2018)."""


def picture(study: Study, rows: pd.DataFrame, curve: Curve, name: str) -> Figure:
    """Return the figure of one `[[curve]]` of a study.

    Parameters
    ----------
    study
        The study, for labels and scales.
    rows
        Rows of the completed runs.
    curve
        Metric, axes and kind of the figure.
    name
        File name without suffix.
    """
    found = estimates(rows, curve.metric, curve.keys)
    found = found[found["n"] > 0]
    dots = seed_dots(rows, curve.metric, curve.keys)
    panels = list(found.groupby(curve.panels, sort=True, observed=True)) if curve.panels else [("", found)]
    columns = max(1, len(panels))

    def paint(canvas: "Canvas") -> None:
        if found.empty:
            note(canvas.subplots(), "no run has a value")
            return
        grid = canvas.subplots(1, columns, sharey=True, sharex=curve.kind == "curve", squeeze=False)[0]
        for axes, (level, shown) in zip(grid, panels, strict=False):
            if curve.kind == "map":
                _map(axes, study, curve, shown)
            else:
                _curves(axes, study, curve, shown, dots if not curve.panels else dots[dots[curve.panels] == level])
            if curve.panels:
                axes.set_title(f"{label(study, curve.panels)}: {text(level)}")
        grid[0].set_ylabel(label(study, curve.by if curve.kind == "map" and curve.by else curve.metric))
        if curve.kind == "curve":
            _set_limits(grid[0], definition.unit if definition else "", found, dots)
            if curve.by:
                canvas.legend(
                    *grid[0].get_legend_handles_labels(), title=label(study, curve.by), loc="outside right upper"
                )

    definition = study.definition(curve.metric)
    title = curve.title or (definition.meaning if definition else curve.metric)
    size = _size(curve, rows, columns)
    return Figure(name, title[0].upper() + title[1:], _caption(study, rows, curve), size, paint, size[0] > WIDE_IN)


def label(study: Study, key: str) -> str:
    """Return the axis label of a parameter or a metric, with its unit."""
    if definition := study.definition(key):
        return key if definition.unit == "1" else f"{key} [{definition.unit}]"
    return next((parameter.label for parameter in study.vary if parameter.key == key), "") or key


def text(level: object) -> str:
    """Return a level of a parameter as text."""
    return f"{level:g}" if isinstance(level, float | int) else str(level)


def _curves(axes: "Axes", study: Study, curve: Curve, found: pd.DataFrame, dots: pd.DataFrame) -> None:
    """Draw one curve per level of `by`, with a small horizontal offset so that their intervals do not overlap."""
    names = list(found[curve.against].cat.categories)
    by_number = all(isinstance(name, float | int) for name in names)
    is_log = any(parameter.key == curve.against and parameter.scale == "log" for parameter in study.vary)
    order = list(found[curve.by].cat.categories) if curve.by else [""]
    step = DODGE * (np.ptp(np.array(names, dtype=np.float64)) if by_number else len(names) - 1) * (not is_log)
    for level, line in found.groupby(curve.by, sort=True, observed=True) if curve.by else [("", found)]:
        n = order.index(level)
        offset = step * (n - 0.5 * (len(order) - 1))
        single = dots if curve.by is None else dots[dots[curve.by] == level]
        beside = _at(single[curve.against], by_number) + offset - 0.4 * step
        axes.plot(beside, single["value"], ".", color=SERIES[n % len(SERIES)], ms=DOT, alpha=FAINT_DOT, mew=0.0)
        _curve(axes, _at(line[curve.against], by_number) + offset, line, n, text(level))
    if not by_number:
        axes.set_xticks(range(len(names)), [text(name) for name in names])
    elif is_log:
        axes.set_xscale("log")
    axes.set_xlabel(label(study, curve.axis))


def _at(level: pd.Series, by_number: bool) -> pd.Series:
    """Return the places of levels on the horizontal axis."""
    return level.astype(float) if by_number else level.cat.codes


def _curve(axes: "Axes", x: pd.Series, line: pd.DataFrame, n: int, name: str) -> None:
    """Draw the n-th curve; points at which some runs have no value are hollow."""
    color, marker = SERIES[n % len(SERIES)], MARKERS[n % len(MARKERS)]
    axes.plot(x, line["value"], f"-{marker}", color=color, ms=4.5, label=name)
    axes.vlines(x, line["low"], line["high"], color=color, lw=1.2)
    partial = line["n"] < line["runs"]
    axes.plot(x[partial], line["value"][partial], marker, color=color, mfc=PAGE, ms=4.5)


def _set_limits(axes: "Axes", unit: str, found: pd.DataFrame, dots: pd.DataFrame) -> None:
    """Start the vertical axis at zero, and end it at one for fractions."""
    if dots["value"].min() < 0.0:
        return
    is_share = unit == "1" and dots["value"].max() <= 1.0
    top = max(float(dots["value"].max()), float(found[["value", "high"]].max().max()))
    axes.set_ylim(*((-0.02, 1.02) if is_share else (-0.02 * top, 1.06 * top or 1.0)))


def _map(axes: "Axes", study: Study, curve: Curve, found: pd.DataFrame) -> None:
    """Draw a heat map with the figure written in each cell, in parentheses if some runs have no value."""
    assert curve.by is not None
    table = found.set_index([curve.by, curve.against])
    value = table["value"].unstack()
    shade = axes.pcolormesh(np.ma.masked_invalid(value.to_numpy()), cmap=MAP_COLORS, edgecolors=PAGE, lw=1.0)
    middle = float(np.mean(shade.get_clim()))
    for (upwards, right), cell in table.iterrows():
        place = (value.columns.get_loc(right) + 0.5, value.index.get_loc(upwards) + 0.5)
        shown = f"{cell['value']:.3g}" if cell["n"] == cell["runs"] else f"({cell['value']:.3g})"
        axes.text(*place, shown, ha="center", va="center", fontsize=7.5, color=PAGE if cell["value"] <= middle else INK)
    axes.set_xticks(np.arange(len(value.columns)) + 0.5, [text(name) for name in value.columns])
    axes.set_yticks(np.arange(len(value.index)) + 0.5, [text(name) for name in value.index])
    axes.set_xlabel(label(study, curve.axis))
    axes.grid(visible=False)
    axes.tick_params(length=0)


def _caption(study: Study, rows: pd.DataFrame, curve: Curve) -> str:
    rest = [label(study, parameter.key) for parameter in study.vary if parameter.key not in curve.keys]
    binary = is_binary(rows[curve.metric])
    parts = [f"{label(study, curve.metric)}, {'share of runs' if binary else 'median over seeds'}"]
    if rest:
        parts[0] += f", {'and' if binary else 'each the mean'} over {', '.join(rest)}"
    if curve.kind == "curve":
        of = "exact, over seeds" if binary else "order statistics of the seeds"
        parts += [f"whiskers show the 95 % confidence interval ({of})", "dots show the single seeds"]
    if rows[curve.metric].isna().any():
        how = "hollow points" if curve.kind == "curve" else "in parentheses"
        parts.append(f"{how}: some runs have no value and are not in the figure")
    return "; ".join([*parts, *seed_warnings(rows, curve.metric, curve.keys)]) + "."


def _size(curve: Curve, rows: pd.DataFrame, panels: int) -> tuple[float, float]:
    if curve.kind == "curve":
        return (1.6 + PANEL_IN[0] * panels, PANEL_IN[1])
    assert curve.by is not None
    across, up = (levels(rows[key]).cat.categories.size for key in (curve.against, curve.by))
    return (1.3 + max(2.0, CELL_IN[0] * across) * panels, 1.2 + max(1.2, CELL_IN[1] * up))
