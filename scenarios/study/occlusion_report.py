"""Survival of track ids against the time hidden as text, JSON, figure and folder."""

import json
import math
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from rich.console import Group
from rich.table import Table
from rich.text import Text

from luxloop.scenarios.errors import OutputError
from luxloop.scenarios.files import atomic_folder
from luxloop.scenarios.report import figure_files
from luxloop.scenarios.report.cells import table_of
from luxloop.scenarios.report.figure_files import FigureFile
from luxloop.scenarios.report.html.palette import SERIES
from luxloop.scenarios.statistics.confidence import Interval
from luxloop.scenarios.study.occlusion_survival import GROUPS, SHARES, OcclusionSurvival, group_shares

if TYPE_CHECKING:
    from matplotlib.figure import Figure as Canvas

TABLE, DOCUMENT, PICTURE = "occlusions.parquet", "survival.json", "survival"
BINS_S = (0.0, 0.25, 0.5, 0.75, 1.0, 1.5, 2.0, 2.5, 3.0, 4.0, 6.0, 10.0)
"""Edges of the bins whose shares are drawn beside the curve."""
WORDS = {"hidden_by_kind": "hidden by", "manoeuvre": "while hidden, the vehicle", "kind": "class of the vehicle"}


def report(found: OcclusionSurvival) -> Group:
    """Return the printed tables."""
    table = found.table
    vehicles = table.groupby(["run", "actor_id"]).ngroups
    head = Text(
        f"{len(table)} occlusions of {vehicles} vehicles in {table['run'].nunique()} runs; "
        f"{table['survived'].mean():.0%} of the ids survive. Intervals: 95 %, over {found.clusters}."
    )
    groups = [_group_table(found, column) for column in GROUPS]
    return Group(head, Text(), _thresholds(found), Text(), *(part for one in groups for part in (one, Text())))


def document(found: OcclusionSurvival) -> dict[str, Any]:
    """Return the figures as JSON; a threshold beyond the observed times is null."""
    gaps = found.table["hidden_s"]
    shares = {column: group_shares(found, column).to_dict("records") for column in GROUPS}
    return {
        "occlusions": len(found.table),
        "runs": found.table["run"].nunique(),
        "clusters": found.clusters,
        "hidden_s": [float(gaps.min()), float(gaps.max())],
        "intercept": float(found.curve.intercept[0]),
        "slope_per_s": float(found.curve.slope[0]),
        "thresholds": [_entry(found, share) for share in SHARES],
        "groups": {column: [{**row, "level": str(row["level"])} for row in rows] for column, rows in shares.items()},
    }


def write(found: OcclusionSurvival, out: Path, formats: list[str]) -> None:
    """Write table, JSON and figure into a folder, atomically; an earlier one of the same kind is replaced.

    Raises
    ------
    OutputError
        The folder cannot be written, or holds other files.
    """
    with atomic_folder.create(out, "--out", _refuse_other_files) as folder:
        try:
            found.table.to_parquet(folder / TABLE, index=False)
            text = json.dumps(document(found), indent=2, allow_nan=False) + "\n"
            (folder / DOCUMENT).write_text(text, encoding="utf-8")
        except OSError as error:
            raise atomic_folder.cannot_write(out, "--out", error) from error
        figure = FigureFile(PICTURE, "Share of track ids that survive an occlusion", (7.0, 3.6), _painter(found))
        figure_files.save(figure, folder, list(dict.fromkeys(["png", *formats])))


def _refuse_other_files(out: Path) -> None:
    if out.exists() and not (out / DOCUMENT).is_file():
        raise OutputError(f"{out}: already exists and holds no earlier results; choose another folder with --out")


def _entry(found: OcclusionSurvival, share: float) -> dict[str, Any]:
    """Return the time hidden of a share and its limits; null beyond the observed times."""
    value, (low, high) = found.threshold(share)
    ends = (float(found.table["hidden_s"].min()), float(found.table["hidden_s"].max()))
    return {"share": share, "hidden_s": _known(value, ends), "low": _known(low, ends), "high": _known(high, ends)}


def _known(number: float, ends: Interval) -> float | None:
    return number if math.isfinite(number) and ends[0] <= number <= ends[1] else None


def _thresholds(found: OcclusionSurvival) -> Table:
    table = table_of("Time hidden that a share of the ids survives, logistic regression", "share", "hidden [s]", "95 %")
    ends = (float(found.table["hidden_s"].min()), float(found.table["hidden_s"].max()))
    for share in SHARES:
        value, interval = found.threshold(share)
        limits = " to ".join(_cell(number, ends) for number in interval)
        table.add_row(f"{share:.0%}", _cell(value, ends), limits)
    return table


def _cell(number: float, ends: Interval) -> str:
    """Return a time as text; beyond the observed times, only on which side it is."""
    if number < ends[0]:
        return f"< {ends[0]:.2f}"
    return f"> {ends[1]:.2f}" if number > ends[1] else f"{number:.2f}"


def _group_table(found: OcclusionSurvival, column: str) -> Table:
    table = table_of(f"Survival by: {WORDS[column]}", WORDS[column], "occlusions", "survive", "95 %")
    for row in group_shares(found, column).to_dict("records"):
        limits = f"{row['low']:.0%} to {row['high']:.0%}"
        table.add_row(str(row["level"]), str(row["occlusions"]), f"{row['share']:.0%}", limits)
    return table


def _painter(found: OcclusionSurvival) -> "Callable[[Canvas], None]":
    """Return a function that draws the curve with its band, and the share and number of occlusions by bin."""
    gap, survived = found.table["hidden_s"].to_numpy(), found.table["survived"].to_numpy()

    def paint(canvas: "Canvas") -> None:
        axes = canvas.subplots()
        at = np.linspace(0.0, gap.max(), 200)
        share, low, high = found.band(at)
        axes.fill_between(at, low, high, color=SERIES[0], alpha=0.15, linewidth=0)
        axes.plot(at, share, color=SERIES[0])
        for first, last in pairwise(BINS_S):
            members = (gap > first) & (gap <= last)
            if members.any():
                point = (gap[members].mean(), survived[members].mean())
                axes.plot(*point, "o", color=SERIES[0])
                axes.annotate(f"{members.sum()}", point, (0, 6), fontsize=7, textcoords="offset points", ha="center")
        axes.set_ylim(-0.05, 1.12)
        axes.set_xlabel("time hidden [s]")
        axes.set_ylabel("share of surviving ids")

    return paint
