"""Figure and table of a survival curve: the share of runs in which the target has reached a stage of emergence."""

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from luxloop.scenarios.arrays import Floats
from luxloop.scenarios.document.figure import Figure, note
from luxloop.scenarios.document.palette import SERIES
from luxloop.scenarios.metrics.definitions import STAGES, SURVIVAL, survival_measure
from luxloop.scenarios.statistics.intervals import few_seeds
from luxloop.scenarios.study import survival
from luxloop.scenarios.study.figures import MARKERS, PANEL_IN, WIDE_IN, label, text
from luxloop.scenarios.study.study_file import Curve, Study
from luxloop.scenarios.study.survival import SurvivalCurve

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure as Canvas

Group = tuple[object, pd.DataFrame]
LINES = ("-", "--", ":", "-.")
BAND = 0.15
"""Opacity of the intervals."""
AXES = {
    "time_s": "time since the start [s]",
    "delay_s": "time since the first beam [s]",
    "meeting_m": "ego's distance to the meeting point [m]",
    "meeting_s": "time until the ego is at the meeting point [s]",
}
"""Label of the horizontal axis, by measure."""
WORDS = {
    "first_beam": "with a returned beam",
    "enough_points": "with enough points",
    "tentative": "with a track",
    "confirmed": "with a confirmed track",
    "located": "located",
}
"""Label of the vertical axis, by stage."""


def survival_picture(study: Study, rows: pd.DataFrame, curve: Curve, name: str) -> Figure:
    """Return the figure of a `[[curve]]` with `kind = "survival"`; parameters as for `figures.picture`."""
    found = survival.samples(rows, curve.metric, curve.keys)
    panels = list(groups(found, curve.panels))
    stage, measure = survival_measure(curve.metric) or ("", "")

    def paint(canvas: "Canvas") -> None:
        if found.empty:
            note(canvas.subplots(), "no run has a value")
            return
        span = _span(found["time"].to_numpy(), SURVIVAL[measure])
        grid = canvas.subplots(1, len(panels), sharey=True, sharex=True, squeeze=False)[0]
        for axes, (level, shown) in zip(grid, panels, strict=True):
            _panel(axes, shown, curve.by, span, SURVIVAL[measure])
            axes.set_xlabel(AXES[measure])
            if curve.panels:
                axes.set_title(f"{label(study, curve.panels)}: {text(level)}")
        grid[0].set_ylim(-0.02, 1.02)
        grid[0].set_ylabel(f"share of runs {WORDS[stage]}")
        grid[0].set_xlim(*(np.array(span) * (-1.0 if SURVIVAL[measure] else 1.0)))
        if curve.by:
            handles, names = grid[0].get_legend_handles_labels()
            canvas.legend(handles, names, title=label(study, curve.by), loc="outside right upper")

    title = curve.title or f"Share of runs {WORDS[stage]}"
    size = (1.6 + PANEL_IN[0] * max(1, len(panels)), PANEL_IN[1])
    return Figure(name, title, _caption(study, curve, stage, len(rows) - len(found)), size, paint, size[0] > WIDE_IN)


def groups(found: pd.DataFrame, key: str | None) -> Iterator[Group]:
    """Yield the levels of a column of `survival.samples` with their rows; all rows at once without a column."""
    if key is None:
        yield "", found
    else:
        yield from found.groupby(key, sort=True, observed=True)


def curve_of(found: pd.DataFrame) -> SurvivalCurve:
    """Return the curve of some rows of `survival.samples`."""
    return survival.curve(found["time"].to_numpy(), found["reached"].to_numpy(), found["seed"].to_numpy())


def _panel(axes: "Axes", found: pd.DataFrame, by: str | None, span: tuple[float, float], falls: bool) -> None:
    """Draw one curve per level of `by` over the times `span`, with a mark at every censored run."""
    for n, (level, shown) in enumerate(groups(found, by)):
        one, color = curve_of(shown), SERIES[n % len(SERIES)]
        end = span[1] if shown["reached"].all() else float(shown["time"].max())
        x = np.concatenate([span[:1], one.at, [end]]) * (-1.0 if falls else 1.0)
        share, low, high = (
            1.0 - np.concatenate([[start], values, values[-1:] if len(values) else [start]])
            for start, values in ((1.0, one.share), (one.start[0], one.low), (one.start[1], one.high))
        )
        axes.step(x, share, where="post", color=color, ls=LINES[n % len(LINES)], label=text(level))
        axes.fill_between(x, low, high, step="post", color=color, alpha=BAND, lw=0)
        censored = shown.loc[~shown["reached"], "time"].to_numpy()
        at = -censored if falls else censored
        axes.plot(at, 1.0 - _share_at(one, censored), MARKERS[n % len(MARKERS)], color=color, mfc="none", ms=5)


def _span(time: Floats, falls: bool) -> tuple[float, float]:
    """Return the begin and the end of the axis: all times with a margin; one that does not fall begins at 0."""
    begin, end = float(time.min()), float(time.max())
    margin = 0.05 * (end - begin) or 0.1
    return (begin - margin if falls else 0.0), end + margin


def _share_at(one: SurvivalCurve, time: Floats) -> Floats:
    """(N,) share of the curve just after each time (N,)."""
    share: Floats = np.append(1.0, one.share)[np.searchsorted(one.at, time, side="right")]
    return share


def _caption(study: Study, curve: Curve, stage: str, without: int) -> str:
    rest = [label(study, parameter.key) for parameter in study.vary if parameter.key not in curve.keys]
    over = f" and over {', '.join(rest)}" if rest else ""
    parts = [
        f"Share of runs {WORDS[stage]} ({STAGES[stage]}), Kaplan-Meier over {len(study.seed_list)} seeds{over}",
        "bands show the 95 % confidence interval",
        "hollow marks: runs that never reach it, censored at their end",
    ]
    if few := few_seeds(len(study.seed_list)):
        parts.append(few)
    if without:
        parts.append(f"{without} runs without a value (no beam, or no meeting point) are not in the curves")
    return "; ".join(parts) + "."
