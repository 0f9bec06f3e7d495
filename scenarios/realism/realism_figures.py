"""Figures of a comparison with real vehicles: bow by height, distributions, and points of matched vehicles."""

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from luxloop.arrays import Floats
from luxloop.scenarios.document.figure import STYLE
from luxloop.scenarios.document.palette import BLUE, FAINT, INK, MUTED, ORANGE, PAGE
from luxloop.scenarios.realism.labelled_vehicle import LabelledVehicle
from luxloop.scenarios.realism.realism_comparison import ComparedRow, Comparison, Summary

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.collections import PathCollection
    from matplotlib.figure import Figure as Canvas

PIXELS_PER_INCH = 110
COLUMNS = 4
PANEL_IN = (2.6, 1.9)
"""[inch] Width and height of a panel with distributions."""
VEHICLES = 8
"""Number of matched vehicles with a picture."""
SHOWN_QUANTILES = (0.02, 0.98)
"""Range of a distribution's axis: single far values would hide the shape."""
HEIGHTS_M = (0.0, 1.8)
"""[m] Range of the colour scale of heights."""
HEIGHT_COLORS = "cividis"
"""Perceptually uniform and readable with colour vision deficiency (Nunez, Anderton and Renslow 2018)."""

REAL, SIMULATED = ORANGE, BLUE


def save(comparison: Comparison, folder: Path) -> None:
    """Write the figures as PNG files into an existing folder."""
    bands = [row for row in comparison.rows if row.figure.name not in comparison.real]
    compared = [row for row in comparison.rows if row.figure.name in comparison.real]
    if bands:
        _save(folder / "bow.png", (6.0, 0.5 * len(bands) + 0.9), lambda canvas: _bow(canvas, bands))
    tall = -(-len(compared) // COLUMNS)
    size = (COLUMNS * PANEL_IN[0], tall * PANEL_IN[1] + 0.3)
    _save(folder / "distributions.png", size, lambda canvas: _distributions(canvas, comparison, compared))
    _save(folder / "vehicles.png", (10.4, 3.9), lambda canvas: _vehicles(canvas, comparison))


def _save(path: Path, size_in: tuple[float, float], paint: "Callable[[Canvas], None]") -> None:
    import matplotlib
    from matplotlib.figure import Figure as Canvas

    with matplotlib.rc_context(STYLE):
        canvas = Canvas(figsize=size_in, layout="constrained", facecolor=PAGE)
        paint(canvas)
        canvas.savefig(path, dpi=PIXELS_PER_INCH, format="png", metadata={"Software": None})


def _bow(canvas: "Canvas", rows: list[ComparedRow]) -> None:
    """Draw medians and quartiles of the bow by height, real above simulated."""
    axes = canvas.subplots()
    for n, row in enumerate(rows):
        for summary, color, offset in ((row.real, REAL, -0.14), (row.simulated, SIMULATED, 0.14)):
            _quartile_bar(axes, summary, row.figure.scale, n + offset, color)
    axes.plot([], [], "o-", color=REAL, label="real")
    axes.plot([], [], "o-", color=SIMULATED, label="simulated")
    axes.set_yticks(range(len(rows)), [row.figure.label for row in rows])
    axes.invert_yaxis()
    axes.set_xlabel("sagitta [cm], median and quartiles; positive: the middle stands out")
    axes.legend(loc="best")


def _quartile_bar(axes: "Axes", summary: Summary | None, scale: float, at: float, color: str) -> None:
    if summary is not None:
        axes.plot(scale * np.array(summary.quartiles), [at, at], color=color, linewidth=2.5)
        axes.plot(scale * summary.value, at, "o", color=color)


def _distributions(canvas: "Canvas", comparison: Comparison, rows: list[ComparedRow]) -> None:
    """Draw the cumulative distributions of every figure, real and simulated."""
    grid = canvas.subplots(-(-len(rows) // COLUMNS), COLUMNS, sharey=True, squeeze=False).ravel()
    for axes, row in zip(grid, rows, strict=False):
        name, scale = row.figure.name, row.figure.scale
        sides = [scale * table[name].dropna().to_numpy(np.float64) for table in (comparison.real, comparison.matched)]
        for values, color, label in zip(sides, (REAL, SIMULATED), ("real", "simulated"), strict=True):
            axes.ecdf(values, color=color, label=label) if len(values) else None
        _limit(axes, np.concatenate(sides))
        axes.set_title(f"{row.figure.label}{'' if row.figure.unit == '1' else f' [{row.figure.unit}]'}")
    for axes in grid[len(rows) :]:
        axes.set_visible(False)
    grid[0].legend()
    canvas.supylabel("share of vehicles", color=MUTED, fontsize=9)


def _limit(axes: "Axes", values: Floats) -> None:
    low, high = np.quantile(values, SHOWN_QUANTILES) if len(values) else (0.0, 1.0)
    margin = 0.03 * (high - low) or 1.0
    axes.set_xlim(low - margin, high + margin)


def _vehicles(canvas: "Canvas", comparison: Comparison) -> None:
    """Draw the points of matched vehicles from above, evenly spaced over the ranges of the real ones."""
    grid = canvas.subplots(2, VEHICLES // 2, squeeze=False).ravel()
    shown = None
    for axes, number in zip(grid, _examples(comparison.matched), strict=False):
        shown = plan(axes, comparison.vehicles[number])
    for axes in grid:
        axes.set_visible(bool(axes.collections))
    if shown is not None:
        canvas.colorbar(shown, ax=list(grid), label="height [m]", shrink=0.6)


def _examples(matched: pd.DataFrame) -> list[int]:
    """Return distinct vehicles, each the best match of its real one, by increasing range."""
    best = matched.sort_values("view_distance", kind="stable").drop_duplicates("real_row")
    by_range = best.sort_values("range_m", kind="stable").drop_duplicates("vehicle")["vehicle"].to_numpy()
    picked = np.linspace(0, len(by_range) - 1, min(VEHICLES, len(by_range))).astype(np.int64)
    return [int(number) for number in by_range[picked]]


def plan(axes: "Axes", vehicle: LabelledVehicle) -> "PathCollection":
    """Draw one vehicle in the frame of its box, with the label and the direction to the LIDAR; return the points."""
    half = 0.5 * vehicle.box[3:]
    corners = half * np.array([(1, 1), (-1, 1), (-1, -1), (1, -1), (1, 1)])
    toward = vehicle.lidars_box[0] / vehicle.range_m
    near = np.min((half + 0.2) / np.maximum(np.abs(toward), 1e-6)) * toward
    axes.plot(*corners.T, color=FAINT, linewidth=1.0)
    axes.annotate("", near, near + 0.9 * toward, arrowprops={"arrowstyle": "->", "color": INK})
    axes.set(xlim=(-half[0] - 1.2, half[0] + 1.2), ylim=(-half[1] - 1.2, half[1] + 1.2), aspect="equal")
    axes.grid(visible=False)
    axes.set_title(f"{vehicle.range_m:.0f} m, {vehicle.aspect_deg:.0f}°, {len(vehicle.points_ego)} points")
    x, y = vehicle.points_box.T
    low, high = HEIGHTS_M
    return axes.scatter(x, y, s=5, c=vehicle.points_ego[:, 2], cmap=HEIGHT_COLORS, vmin=low, vmax=high)
