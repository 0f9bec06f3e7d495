"""What happened to each vehicle: a line of time, and the track that followed it."""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure as Canvas
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from scenarios.report.html.palette import FAINT, INK, LINE, PAGE, RED, SERIES
from scenarios.report.html.svg_figure import Figure, draw, note

VEHICLES = 30
"""Most lines in the figure."""
NAMED_S = 0.02
"""Share of the run that a stretch must last to have the track's number written on it."""

ALONE, HIDDEN, OUT = -1, -2, -3
"""What a vehicle is instead of followed by a track: graded without one, hidden, or seen too little to be graded."""


class Stretch(NamedTuple):
    """Time in which nothing changes."""

    begin_s: float
    end_s: float
    state: int
    """Number of the track, or `ALONE`, `HIDDEN`, `OUT`."""


def timelines(truth: pd.DataFrame, hidden_fraction_max: float) -> Figure:
    """One line for each of the vehicles that were graded the longest, in the order in which they appear.

    Parameters
    ----------
    truth
        The table.
    hidden_fraction_max
        As in the grading's config.
    """
    graded = truth[truth["graded"]]
    seen = graded.groupby("actor_id")["time_s"].agg(["size", "min"])
    chosen = seen.sort_values("size", ascending=False, kind="stable").head(VEHICLES).sort_values("min", kind="stable")
    rows = truth.groupby("actor_id")
    lines = {int(actor): list(stretches(rows.get_group(actor), hidden_fraction_max)) for actor in chosen.index}

    def on(canvas: Canvas) -> None:
        axes = canvas.subplots()
        span_s = float(truth["time_s"].max()) if len(truth) else 1.0
        for row, line in enumerate(lines.values()):
            _draw(axes, row, line, NAMED_S * span_s)
        if not lines:
            note(axes, "no vehicle was graded")
        axes.set(xlabel="time [s]", ylabel="vehicle", xlim=(0, max(span_s, 0.1)), ylim=(len(lines) - 0.4, -0.6))
        axes.set_yticks(range(len(lines)), [str(actor) for actor in lines], fontsize=7.5)
        axes.grid(visible=False, axis="y")
        canvas.legend(handles=_legend(), loc="outside upper left", ncols=5)

    shown = f"{len(lines)} of {len(seen)} vehicles, those that were graded the longest"
    caption = f"{shown}. A bar is a graded vehicle; its colour and number are the track that follows it."
    return draw("timelines", "Tracks of each vehicle", caption, (12.0, 0.9 + 0.22 * max(len(lines), 3)), on, wide=True)


def stretches(vehicle: pd.DataFrame, hidden_fraction_max: float) -> Iterator[Stretch]:
    """Cut one vehicle's rows, from its first graded one to its last, where its state changes."""
    rows = vehicle.sort_values("frame", kind="stable")
    seen = np.flatnonzero(rows["graded"])
    rows = rows.iloc[seen[0] : seen[-1] + 1]
    dark = (rows["visible_fraction"] <= hidden_fraction_max) & (rows["hits_alone"] > 0)
    followed = np.maximum(rows["track_id"].to_numpy(), ALONE)
    state = np.where(rows["graded"], followed, np.where(dark, HIDDEN, OUT))
    frame, time = rows["frame"].to_numpy(), rows["time_s"].to_numpy()
    step = float(np.median(np.diff(time))) if len(time) > 1 else 0.0
    cuts = np.flatnonzero((np.diff(state) != 0) | (np.diff(frame) != 1)) + 1
    for part in np.split(np.arange(len(state)), cuts):
        yield Stretch(float(time[part[0]]), float(time[part[-1]]) + step, int(state[part[0]]))


def _draw(axes: Axes, row: int, line: list[Stretch], named_s: float) -> None:
    before = ALONE
    for begin, end, state in line:
        across = (begin, end - begin)
        if state >= 0:
            axes.broken_barh([across], (row - 0.36, 0.72), facecolor=SERIES[state % len(SERIES)])
            if end - begin > named_s:
                axes.text(begin + 0.2 * named_s, row, str(state), color=PAGE, fontsize=7, va="center", clip_on=True)
            if before not in (ALONE, state):
                axes.plot(begin, row - 0.36, "v", color=INK, mec=PAGE, mew=0.6, ms=6, clip_on=False)
            before = state
        elif state == ALONE:
            axes.broken_barh([across], (row - 0.36, 0.72), facecolor="none", edgecolor=RED, linewidth=1.2)
        else:
            color, width = (FAINT, 3.2) if state == HIDDEN else (LINE, 1.0)
            axes.plot([begin, end], [row, row], color=color, lw=width, solid_capstyle="butt")


def _legend() -> list[Patch | Line2D]:
    return [
        Patch(facecolor=SERIES[0], label="followed (colour and number: track)"),
        Patch(facecolor="none", edgecolor=RED, linewidth=1.2, label="graded, no track"),
        Line2D([], [], color=FAINT, lw=3.2, label="hidden"),
        Line2D([], [], color=LINE, lw=1.0, label="too few points, or far"),
        Line2D([], [], color=INK, marker="v", lw=0, ms=6, label="id switch"),
    ]
