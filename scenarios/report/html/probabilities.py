"""Figure of the model probabilities over time, with the true mode of the vehicle."""

from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from luxloop.scenarios.document.figure import Figure, note
from luxloop.scenarios.document.palette import BLUE, GREEN, ORANGE, PURPLE, RED, SKY
from luxloop.scenarios.grading.frame_tables import models_of
from luxloop.scenarios.grading.worst_frames import vehicle_names
from luxloop.tracker.records import MODEL_NAMES, MODELS

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure as Canvas

VEHICLES = 4
"""Number of vehicles shown."""
COLORS = dict(zip(MODEL_NAMES, (ORANGE, BLUE, GREEN, PURPLE, RED, SKY), strict=True))
STRIP = (-0.2, -0.06)
"""Lower and upper edge of the strip with the true mode, below the probabilities."""
FRAMES_MIN = 12
"""Least number of frames in which a shown vehicle is followed."""


def model_probabilities(tracks: pd.DataFrame, truth: pd.DataFrame) -> Figure:
    """Draw the model probabilities over time, for the vehicles with most changes of the true mode."""
    judged = tracks[tracks["judged"]].sort_values(["actor_id", "frame"], kind="stable")
    chosen = most_mode_changes(judged)
    names = vehicle_names(truth)
    colors = {model: COLORS[model] for model in models_of(tracks)}

    def on(canvas: "Canvas") -> None:
        from matplotlib.lines import Line2D
        from matplotlib.patches import Patch

        rows = canvas.subplots(max(len(chosen), 1), 1, sharex=True, sharey=True, squeeze=False)[:, 0]
        for axes, actor in zip(rows, chosen, strict=False):
            _draw(axes, judged[judged["actor_id"] == actor])
            axes.set_title(f"vehicle {names[actor]}", fontsize=8)
        if not chosen:
            note(rows[0], "no confirmed track followed a graded vehicle for long")
        rows[-1].set(xlabel="time [s]", ylim=(STRIP[0] - 0.02, 1.02))
        lines = [Line2D([], [], color=color, label=f"probability of {model}") for model, color in colors.items()]
        patches = [Patch(facecolor=COLORS[mode], label=f"truly {mode}") for mode in MODELS]
        canvas.legend(handles=[*lines, *patches], loc="outside upper left", ncols=4)

    caption = (
        "Equation (12), for the vehicles with most changes of the true mode; strip and background show the true mode."
    )
    size = (10.0, 0.9 + 1.25 * max(len(chosen), 1))
    return Figure("probabilities", "Probability of each motion model", caption, size, on, wide=True)


def most_mode_changes(judged: pd.DataFrame) -> list[int]:
    """Return the vehicles with most changes of the true mode; of equal numbers, those followed longer come first."""
    mode = judged["true_mode"].cat.codes
    same = judged["actor_id"].eq(judged["actor_id"].shift())
    events = judged.assign(change=same & mode.ne(mode.shift())).groupby("actor_id")["change"].agg(["sum", "size"])
    ranked = events[events["size"] >= FRAMES_MIN].sort_values(["sum", "size"], ascending=False, kind="stable")
    return [int(actor) for actor in ranked.index[:VEHICLES]]


def _draw(axes: "Axes", rows: pd.DataFrame) -> None:
    time, mode = rows["time_s"].to_numpy(), rows["true_mode"].to_numpy()
    step = float(np.median(np.diff(time)))
    gaps = np.flatnonzero(np.diff(time) > 1.5 * step) + 1
    for part in np.split(np.arange(len(time)), gaps):
        for model, color in COLORS.items():
            if f"probability_{model}" not in rows:
                continue
            axes.plot(time[part], rows[f"probability_{model}"].to_numpy()[part], color=color, lw=1.3)
    changes = np.union1d(np.flatnonzero(mode[1:] != mode[:-1]) + 1, gaps)
    for part in np.split(np.arange(len(time)), changes):
        begin, end, color = time[part[0]], time[part[-1]] + step, COLORS[mode[part[0]]]
        axes.axvspan(begin, end, color=color, alpha=0.22, lw=0)
        axes.fill_between([begin, end], *STRIP, color=color, lw=0)
