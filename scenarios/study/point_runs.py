"""Runs of each point of a curve: those of the lowest, middle and highest value, with links to their folders."""

from pathlib import Path

import pandas as pd

from luxloop.scenarios.report.html.page_tables import Cell, PageTable, Row
from luxloop.scenarios.study.curves import groups
from luxloop.scenarios.study.figures import label, text
from luxloop.scenarios.study.study_file import Curve, Study

EXTREMES = ("lowest", "middle", "highest")


def point_runs(study: Study, rows: pd.DataFrame, curve: Curve, keep_at: str | None) -> PageTable:
    """Return a table with a line per point: its runs of the lowest, the middle and the highest value.

    Parameters
    ----------
    rows
        Rows of completed runs.
    keep_at
        Folder or fsspec URL of the run folders; the cells then link to them.
    """
    head = [*(Cell(label(study, key), False) for key in curve.keys), *(Cell(name, False) for name in EXTREMES)]
    known = rows[rows[curve.metric].notna()].sort_values([curve.metric, "index"], kind="stable")
    lines = []
    if len(known) and curve.keys:
        levels = groups(rows, curve.keys).loc[known.index]  # in the order of the study, as in the other tables
        for level, members in levels.groupby(curve.keys, sort=True, observed=True):
            of_point = known.loc[members.index].to_dict("records")
            chosen = [of_point[0], of_point[len(of_point) // 2], of_point[-1]]
            names = [Cell(text(value), False) for value in level]
            lines.append(Row([*names, *(_cell(run, curve.metric, keep_at) for run in chosen)], ""))
    return PageTable(f"Runs: {label(study, curve.metric)}", head, lines)


def _cell(run: dict[str, object], metric: str, keep_at: str | None) -> Cell:
    """Return value, place in the study and seed of a run, with a link to its folder if that is kept."""
    return Cell(f"{run[metric]:.3g} (run {run['index']}, seed {run['seed']})", False, _link(str(run["key"]), keep_at))


def _link(key: str, keep_at: str | None) -> str:
    if keep_at is None:
        return ""
    folder = f"{keep_at.rstrip('/')}/{key}"
    if "://" in keep_at:
        return folder
    path = Path(folder).absolute()
    return path.as_uri() if path.is_dir() else ""  # the row of an earlier start may have been made without --keep
