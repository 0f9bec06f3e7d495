"""Tables beneath the figures of a study: numbers of curves and of survival curves, and the runs of each point."""

import math
from pathlib import Path
from typing import Any, Literal

import pandas as pd

from luxloop.scenarios.document.document import Span, Table
from luxloop.scenarios.metrics.definitions import SURVIVAL, survival_measure
from luxloop.scenarios.statistics.intervals import FEWEST_SEEDS
from luxloop.scenarios.study import survival, survival_picture
from luxloop.scenarios.study.curves import groups, is_binary
from luxloop.scenarios.study.figures import label, text
from luxloop.scenarios.study.study_file import Curve, Study

Kind = Literal["share", "count", "quantity"]


def kind_of(rows: pd.DataFrame, metric: str, unit: str) -> Kind:
    """Return the kind of a metric: a share of runs, a count, or any other quantity."""
    if is_binary(rows[metric]):
        return "share"
    return "count" if unit == "count" else "quantity"


def estimate_head(kind: Kind) -> list[str]:
    """Return the names of the columns."""
    if kind == "share":
        return ["share", "95 %", "runs"]
    return ["median", "95 %", "mean", *(["seeds with any", "95 %"] if kind == "count" else []), "runs"]


def estimate_cells(row: dict[str, Any], kind: Kind) -> list[str]:
    """Return the cells of the fields of an `Estimate`."""
    known = row["n"] > 0
    cells = interval_cells(row)
    if kind != "share":
        cells.append(f"{row['mean']:.3g}" if known else "-")
    if kind == "count":
        cells += [f"{row['share_any']:.0%}", _any(row)] if known else ["-", ""]
    return [*cells, f"{row['n']:g}" if row["n"] == row["runs"] else f"{row['n']:g} of {row['runs']:g}"]


def interval_cells(row: dict[str, Any]) -> list[str]:
    """Return the figure and its interval."""
    if not row["n"]:
        return ["-", ""]
    has_interval = row["low"] == row["low"]
    ends = f"{row['low']:.3g} to {row['high']:.3g}" if has_interval else f"fewer than {FEWEST_SEEDS} seeds"
    return [f"{row['value']:.3g}", ends]


def _any(row: dict[str, Any]) -> str:
    """Return the interval of the share of seeds with a value other than 0, in percent."""
    if row["share_any"] == 0.0:
        return f"at most {row['any_high']:.0%}"
    return f"{row['any_low']:.0%} to {row['any_high']:.0%}"


def survival_lines(study: Study, rows: pd.DataFrame, curve: Curve) -> tuple[list[str], list[list[str]]]:
    """Return the head of the table, and a line per curve."""
    found = survival.samples(rows, curve.metric, curve.keys)
    measure = (survival_measure(curve.metric) or ("", ""))[1]
    head = [*(label(study, key) for key in curve.keys), "runs", "reached", "median", "95 %"]
    lines = []
    for panel, in_panel in survival_picture.groups(found, curve.panels):
        first: pd.DataFrame | None = None
        for level, shown in survival_picture.groups(in_panel, curve.by):
            names = [text(value) for key, value in ((curve.panels, panel), (curve.by, level)) if key is not None]
            line = [*names, str(len(shown)), str(int(shown["reached"].sum())), *_median(shown, SURVIVAL[measure])]
            if curve.by:
                line.append("" if first is None else _p_value(survival.log_rank(first, shown)))
            first = shown if first is None else first
            lines.append(line)
    return [*head, *(["log-rank p against the first"] if curve.by else [])], lines


def _median(shown: pd.DataFrame, falls: bool) -> list[str]:
    """Return the median and its interval as text, in the order of the measure."""
    middle, *ends = survival.median(survival_picture.curve_of(shown))
    interval = "one seed" if shown["seed"].nunique() < 2 else " to ".join(_value(end, falls) for end in ends)
    return [_value(middle, falls), interval]


def _value(time: float, falls: bool) -> str:
    return "never" if math.isinf(time) else f"{-time if falls else time:.3g}"


def _p_value(p: float) -> str:
    return "-" if math.isnan(p) else "< 0.001" if p < 0.001 else f"{p:.3f}"


EXTREMES = ("lowest", "middle", "highest")


def point_runs(study: Study, rows: pd.DataFrame, curve: Curve, keep_at: str | None) -> Table:
    """Return a table with a line per point: its runs of the lowest, the middle and the highest value.

    Parameters
    ----------
    rows
        Rows of completed runs.
    keep_at
        Folder or fsspec URL of the run folders; the cells then link to them.
    """
    table = Table(f"Runs: {label(study, curve.metric)}")
    for name in (*(label(study, key) for key in curve.keys), *EXTREMES):
        table.add_column(name)
    known = rows[rows[curve.metric].notna()].sort_values([curve.metric, "index"], kind="stable")
    if len(known) and curve.keys:
        levels = groups(rows, curve.keys).loc[known.index]  # in the order of the study, as in the other tables
        for level, members in levels.groupby(curve.keys, sort=True, observed=True):
            of_point = known.loc[members.index].to_dict("records")
            chosen = [of_point[0], of_point[len(of_point) // 2], of_point[-1]]
            table.add_row(*map(text, level), *(_cell(run, curve.metric, keep_at) for run in chosen))
    return table


def _cell(run: dict[str, object], metric: str, keep_at: str | None) -> Span:
    """Return value, place in the study and seed of a run, with a link to its folder if that is kept."""
    shown = f"{run[metric]:.3g} (run {run['index']}, seed {run['seed']})"
    return Span(shown, link=_link(str(run["key"]), keep_at))


def _link(key: str, keep_at: str | None) -> str:
    if keep_at is None:
        return ""
    folder = f"{keep_at.rstrip('/')}/{key}"
    if "://" in keep_at:
        return folder
    path = Path(folder).absolute()
    return path.as_uri() if path.is_dir() else ""  # the row of an earlier start may have been made without --keep
