"""Survival statistics of emergence over the runs of a study: Kaplan-Meier curves, medians, log-rank tests.

A run in which the target never reaches a stage is censored at the last frame with the target, and never left out. Runs
of one seed are correlated, so the variance is that between seeds (Williams 1995, Biometrics 51, 1037). The interval is
the exact binomial one with the effective number of runs by that variance (Korn and Graubard 1998, Survey Methodology
24, 193); without any event, or if all runs have one, the seeds count. It stays within 0 and 1.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd
import scipy

from luxloop.arrays import Bools, Floats
from luxloop.scenarios.document.figure import Figure, note
from luxloop.scenarios.document.palette import SERIES
from luxloop.scenarios.metrics.definitions import END, STAGES, SURVIVAL, survival_measure
from luxloop.scenarios.statistics.intervals import binomial_interval, effective_number, few_seeds
from luxloop.scenarios.study.curves import levels
from luxloop.scenarios.study.figures import MARKERS, PANEL_IN, WIDE_IN, label, text
from luxloop.scenarios.study.study_file import Curve, Study

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure as Canvas


@dataclass(frozen=True, slots=True, eq=False)
class SurvivalCurve:
    """Share of runs that have not reached a stage, with its confidence interval, at the K times of events."""

    at: Floats
    """(K,) times of events in ascending order; falling measures are negative."""
    share: Floats
    """(K,) share of runs without the event just after that time."""
    low: Floats
    """(K,)"""
    high: Floats
    """(K,)"""
    start: tuple[float, float]
    """Interval of the share before the first event, which is 1."""


def survival_columns(stage: str, measure: str) -> tuple[str, str]:
    """Return the metrics that the curve of a stage needs beside its own: whether it is reached, and the end."""
    return f"emergence.reached{{stage={stage}}}", f"emergence.{measure}{{stage={END}}}"


def samples(rows: pd.DataFrame, metric: str, keys: Sequence[str]) -> pd.DataFrame:
    """Return `time`, `reached`, `seed` and the levels of the columns `keys` of every run with a value.

    `time` is negative for measures that fall, such as the distance to the meeting point. A run that does not reach the
    stage has the value at its end; without one (no beam, no meeting point) it has no row.
    """
    found = survival_measure(metric)
    assert found is not None
    stage, measure = found
    of_reached, of_end = survival_columns(stage, measure)
    reached = rows[of_reached] == 1.0
    time = rows[metric].where(reached, rows[of_end])
    table = pd.DataFrame({key: levels(rows[key]) for key in keys})
    table = table.assign(time=-time if SURVIVAL[measure] else time, reached=reached, seed=rows["seed"])
    return table[table["time"].notna()]


def curve(time: Floats, reached: Bools, seed: Floats) -> SurvivalCurve:
    """Return the Kaplan-Meier curve of the runs (N,) with intervals from the differences between seeds."""
    at = np.unique(time[reached])
    events = (time[:, None] == at) & reached[:, None]
    at_risk = time[:, None] >= at
    deaths, risk = events.sum(axis=0), at_risk.sum(axis=0)
    hazard = deaths / risk
    share = np.cumprod(1.0 - hazard)
    # Influence of each run on the logarithm of the share; for independent runs its sum of squares is Greenwood's.
    influence = np.cumsum((events - at_risk * hazard) / np.maximum(risk - deaths, 1), axis=1)
    seeds, index = np.unique(seed, return_inverse=True)
    sums = np.zeros((len(seeds), len(at)))
    np.add.at(sums, index, influence)
    variance = share**2 * (sums**2).sum(axis=0) * len(seeds) / max(len(seeds) - 1, 1)
    seeds_at_risk = np.array([len(np.unique(seed[row])) for row in at_risk.T], dtype=np.float64)
    effective = _effective_runs(share, variance, len(time), len(seeds), seeds_at_risk)
    low, high = binomial_interval(share, effective)
    first = binomial_interval(np.ones(1), np.array([float(len(seeds))]))
    return SurvivalCurve(at, share, low, high, (float(first[0][0]), 1.0))


def _effective_runs(share: Floats, variance: Floats, runs: int, seeds: int, seeds_at_risk: Floats) -> Floats:
    """(K,) number of independent runs with the same variance of the share, from 1 to the number of runs."""
    if seeds < 2:
        return np.full(len(share), np.nan)
    few = float(scipy.stats.t.ppf(0.975, runs - 1) / scipy.stats.t.ppf(0.975, seeds - 1))
    number = np.clip(effective_number(share, variance, few), 1.0, runs)
    certain = (share <= 0.0) | (share >= 1.0)
    return np.where(certain, seeds_at_risk, number)


def median(found: SurvivalCurve) -> tuple[float, float, float]:
    """Return the median with its interval (Brookmeyer and Crowley 1982); infinite where half never reach the stage."""

    def first_below_half(share: Floats) -> float:
        below = np.flatnonzero(share <= 0.5)
        return float(found.at[below[0]]) if len(below) else math.inf

    return first_below_half(found.share), first_below_half(found.low), first_below_half(found.high)


def log_rank(one: pd.DataFrame, other: pd.DataFrame) -> float:
    """Return the p-value of the log-rank test (Mantel 1966) that two groups of `samples` have the same distribution.

    It takes runs as independent. NaN without any event in either group.
    """
    if not len(one) or not len(other) or not (one["reached"].any() or other["reached"].any()):
        return math.nan
    data = [
        scipy.stats.CensoredData.right_censored(group["time"].to_numpy(), ~group["reached"].to_numpy())
        for group in (one, other)
    ]
    return float(scipy.stats.logrank(*data).pvalue)


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
    found = samples(rows, curve.metric, curve.keys)
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
    """Yield the levels of a column of `samples` with their rows; all rows at once without a column."""
    if key is None:
        yield "", found
    else:
        yield from found.groupby(key, sort=True, observed=True)


def curve_of(found: pd.DataFrame) -> SurvivalCurve:
    """Return the curve of some rows of `samples`."""
    return curve(found["time"].to_numpy(), found["reached"].to_numpy(), found["seed"].to_numpy())


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
