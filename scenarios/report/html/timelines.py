"""Figure of timelines: for each vehicle, the track that follows it over time."""

from collections.abc import Iterator
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
import pandas as pd

from luxloop.scenarios.document.figure import Figure, note
from luxloop.scenarios.document.palette import BLUE, FAINT, INK, LINE, MUTED, PAGE, RED, TEXT_SERIES
from luxloop.scenarios.grading.worst_frames import vehicle_names
from luxloop.scenarios.report.file_document import bands
from luxloop.scenarios.report.run_tables import band_label
from luxloop.scenarios.result import Metric, Result

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure as Canvas
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch


VEHICLES = 30
"""Largest number of lines in the figure."""
LABEL_SHARE = 0.02
"""Least duration of a period with a label, as a share of the run."""

MISSED, HIDDEN, OUT = -1, -2, -3
"""States of a vehicle without a track: graded, hidden, and not graded for another reason (few points, out of range)."""


class Period(NamedTuple):
    """Time interval with a constant state of a vehicle."""

    begin_s: float
    end_s: float
    state: int
    """Id of the track, or `MISSED`, `HIDDEN`, `OUT`."""


def timelines(
    truth: pd.DataFrame,
    hidden_fraction_max: float,
    name: str = "timelines",
    title: str = "Tracks of each vehicle",
) -> Figure:
    """Draw a line for each of the vehicles graded the longest, in the order of appearance.

    Parameters
    ----------
    truth
        The truth table.
    hidden_fraction_max
        As in `GradingConfig`.
    name, title
        Anchor and title of the figure.
    """
    graded = truth[truth["graded"]]
    seen = graded.groupby("actor_id")["time_s"].agg(["size", "min"])
    chosen = seen.sort_values("size", ascending=False, kind="stable").head(VEHICLES).sort_values("min", kind="stable")
    rows = truth.groupby("actor_id")
    names = vehicle_names(truth)
    lines = {int(actor): list(periods(rows.get_group(actor), hidden_fraction_max)) for actor in chosen.index}

    def on(canvas: "Canvas") -> None:
        axes = canvas.subplots()
        span_s = float(truth["time_s"].max()) if len(truth) else 1.0
        for row, line in enumerate(lines.values()):
            _draw(axes, row, line, LABEL_SHARE * span_s)
        if not lines:
            note(axes, "no vehicle was graded")
        axes.set(xlabel="time [s]", ylabel="vehicle", xlim=(0, max(span_s, 0.1)), ylim=(len(lines) - 0.4, -0.6))
        axes.set_yticks(range(len(lines)), [names[actor] for actor in lines], fontsize=7.5)
        axes.grid(visible=False, axis="y")
        canvas.legend(handles=_legend(), loc="outside upper left", ncols=5)

    shown = f"{len(lines)} of {len(seen)} vehicles, those graded the longest"
    caption = f"{shown}. A bar is a graded vehicle; its colour and number show the track that follows it."
    return Figure(name, title, caption, (10.0, 0.9 + 0.22 * max(len(lines), 3)), on, wide=True)


def periods(vehicle: pd.DataFrame, hidden_fraction_max: float) -> Iterator[Period]:
    """Split one vehicle's rows, from the first graded row to the last, at changes of its state."""
    rows = vehicle.sort_values("frame", kind="stable")
    seen = np.flatnonzero(rows["graded"])
    rows = rows.iloc[seen[0] : seen[-1] + 1]
    dark = (rows["visible_fraction"] <= hidden_fraction_max) & (rows["hits_alone"] > 0)
    followed = np.maximum(rows["track_id"].to_numpy(), MISSED)
    state = np.where(rows["graded"], followed, np.where(dark, HIDDEN, OUT))
    frame, time = rows["frame"].to_numpy(), rows["time_s"].to_numpy()
    step = float(np.median(np.diff(time))) if len(time) > 1 else 0.0
    cuts = np.flatnonzero((np.diff(state) != 0) | (np.diff(frame) != 1)) + 1
    for part in np.split(np.arange(len(state)), cuts):
        yield Period(float(time[part[0]]), float(time[part[-1]]) + step, int(state[part[0]]))


def _draw(axes: "Axes", row: int, line: list[Period], label_s: float) -> None:
    before = MISSED
    for begin, end, state in line:
        across = (begin, end - begin)
        if state >= 0:
            axes.broken_barh([across], (row - 0.36, 0.72), facecolor=TEXT_SERIES[state % len(TEXT_SERIES)])
            if end - begin > label_s:
                axes.text(begin + 0.2 * label_s, row, str(state), color=PAGE, fontsize=7, va="center", clip_on=True)
            if before not in (MISSED, state):
                axes.plot(begin, row - 0.36, "v", color=INK, mec=PAGE, mew=0.6, ms=6, clip_on=False)
            before = state
        elif state == MISSED:
            axes.broken_barh([across], (row - 0.36, 0.72), facecolor="none", edgecolor=RED, linewidth=1.2)
        else:
            color, width = (FAINT, 3.2) if state == HIDDEN else (MUTED, 0.6)
            axes.plot([begin, end], [row, row], color=color, lw=width, solid_capstyle="butt")


def _legend() -> "list[Patch | Line2D]":
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    return [
        Patch(facecolor=TEXT_SERIES[0], label="followed (colour and number: track)"),
        Patch(facecolor="none", edgecolor=RED, linewidth=1.2, label="graded, no track"),
        Line2D([], [], color=FAINT, lw=3.2, label="hidden"),
        Line2D([], [], color=MUTED, lw=0.6, label="too few points, or out of range"),
        Line2D([], [], color=INK, marker="v", lw=0, ms=6, label="id switch"),
    ]


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
