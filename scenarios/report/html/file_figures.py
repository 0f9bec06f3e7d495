"""Figures of a grading of files: main metrics by class and range, and the positions of hits and misses."""

from typing import TYPE_CHECKING

import numpy as np

from luxloop.scenarios.document.figure import Figure
from luxloop.scenarios.document.palette import BLUE, FAINT, LINE, RED
from luxloop.scenarios.report.file_document import bands
from luxloop.scenarios.report.html.timelines import timelines
from luxloop.scenarios.report.track_tables import band_label
from luxloop.scenarios.result import Metric, Result

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure as Canvas


def file_figures(result: Result) -> list[Figure]:
    """Return the figures that the columns of the files allow, the most important first."""
    known_times = "time" not in result.config["missing"]
    lines = [timelines(result.tables["truth"], 0.0, title="Tracks of each object")] if known_times else []
    return [main_metrics(result), positions(result), *lines]


def main_metrics(result: Result) -> Figure:
    """Draw HOTA and the share of missed boxes, of all and by class and range, with 95 % intervals."""
    rows = [{}, *bands(result)]
    labels = [band_label(band) if band else "all" for band in rows]
    found = {
        "HOTA": [result.metrics.where("track.hota", **band) for band in rows],
        "missed": [result.metrics.where("track.missed_share", **band) for band in rows],
    }

    def on(canvas: "Canvas") -> None:
        panels = canvas.subplots(1, 2, sharey=True)
        for axes, (name, metrics) in zip(panels, found.items(), strict=True):
            _dots(axes, metrics)
            axes.set(xlim=(-0.02, 1.02), xlabel=name)
            axes.grid(visible=False, axis="y")
        panels[0].set_yticks(range(len(rows)), labels)
        panels[0].set_ylim(len(rows) - 0.5, -0.5)

    caption = "Dots are HOTA and the share of true boxes without a hit; lines are 95 % intervals over objects."
    size = (5.0, 1.0 + 0.3 * max(len(rows), 3))
    return Figure("main-metrics", "Tracks by class and range", caption, size, on)


def positions(result: Result) -> Figure:
    """Draw the places of the true boxes that tracks hit and miss, and of the false boxes."""
    clear = result.metrics.run.clear
    true, tracks = (rows[["x_world_m", "y_world_m"]].to_numpy(np.float64) for rows in (clear.vehicles, clear.tracks))
    about = "about the ego" if "range" not in result.config["missing"] else "in the axes of the files"

    def on(canvas: "Canvas") -> None:
        axes = canvas.subplots()
        axes.plot(*true[clear.is_hit].T, ".", color=FAINT, ms=3, label="hit")
        axes.plot(*true[~clear.is_hit].T, ".", color=RED, ms=4, label="missed")
        axes.plot(*tracks[~clear.hits].T, "x", color=BLUE, ms=4, label="false")
        axes.set(xlabel="x [m]", ylabel="y [m]")
        axes.set_aspect("equal", "datalim")
        canvas.legend(loc="outside upper left", ncols=3)

    return Figure("positions", f"Hits, misses and false boxes, {about}", "Centres of all boxes.", (5.0, 4.4), on)


def _dots(axes: "Axes", metrics: list[Metric]) -> None:
    for row, metric in enumerate(metrics):
        axes.axhline(row, color=LINE, lw=0.4)
        if metric.interval:
            axes.plot(metric.interval, [row, row], color=BLUE, lw=2.0, solid_capstyle="butt")
        if metric.value is not None:
            axes.plot(metric.value, row, "o", color=BLUE, ms=5)
