"""Survival of track ids against the time hidden, over the occlusions of several runs: regression, table and figure."""

import json
import math
from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd
import scipy

from luxloop.arrays import Bools, Floats, Ints
from luxloop.scenarios.document.document import Answer, Document, Section, Table, json_data
from luxloop.scenarios.document.figure import Figure
from luxloop.scenarios.document.palette import SERIES
from luxloop.scenarios.errors import OutputError
from luxloop.scenarios.files import atomic_file, atomic_folder
from luxloop.scenarios.report.cells import table_of
from luxloop.scenarios.run import run_folder
from luxloop.scenarios.statistics import logistic
from luxloop.scenarios.statistics.intervals import TAIL, Interval, binomial_interval, effective_number
from luxloop.scenarios.statistics.logistic import LogisticFit

if TYPE_CHECKING:
    from matplotlib.figure import Figure as Canvas


SHARES = (0.5, 0.95)
"""Shares of survival whose times are estimated."""
FEWEST_RUNS = 10
"""With fewer runs, vehicles are resampled instead: intervals then do not cover the differences between runs."""
GROUPS = ("hidden_by_kind", "manoeuvre", "kind")
"""Columns whose values have a share of survival each."""


@dataclass(frozen=True, slots=True, eq=False)
class OcclusionSurvival:
    """Regression of survival on the time hidden, and shares by group."""

    table: pd.DataFrame
    """Occlusions of all runs, with the column `run`."""
    clusters: str
    """Resampled units: `runs` or `vehicles`."""
    curve: LogisticFit
    resampled: LogisticFit

    def threshold(self, share: float) -> tuple[float, Interval]:
        """Return the time hidden [s] that a share of ids survives; values outside the observed times are not known."""
        return float(self.curve.value_at(share)[0]), logistic.percentile_interval(self.resampled.value_at(share))

    def band(self, gap_s: Floats) -> tuple[Floats, Floats, Floats]:
        """Return the share of survival (K,) at times hidden (K,) [s] with its lower and upper limits."""
        low, high = np.quantile(self.resampled.share(gap_s), (TAIL, 1.0 - TAIL), axis=0)
        return self.curve.share(gap_s)[0], low, high


def read(folders: list[Path]) -> pd.DataFrame:
    """Return the occlusions of all runs in or below folders, with the columns `run` and `seed`.

    Raises
    ------
    OutputError
        A folder holds no run, or a run has no table of occlusions.
    """
    found: list[Path] = []
    for folder in folders:
        runs = run_folder.found_in(folder)
        if not runs:
            raise OutputError(f"{folder}: no run in it; give folders that luxloop run wrote")
        found += [run for run in runs if run not in found]
    tables = []
    for run in found:
        result = run_folder.read(run)
        if "occlusions" not in result.tables:
            raise OutputError(f"{run}: has no table of occlusions, as runs of an earlier version; run it again")
        tables.append(result.tables["occlusions"].assign(run=str(run), seed=result.seed))
    return pd.concat(tables, ignore_index=True)


def regress(table: pd.DataFrame) -> OcclusionSurvival:
    """Fit the logistic curve of survival over the time hidden.

    Raises
    ------
    OutputError
        There are fewer than two different times.
    """
    if table["hidden_s"].nunique() < 2:
        raise OutputError(f"{len(table)} occlusions in these runs, too few for a curve; give more runs or seeds")
    by_run = table["run"].nunique() >= FEWEST_RUNS
    gap, survived = table["hidden_s"].to_numpy(), table["survived"].to_numpy()
    resampled = logistic.resampled(gap, survived, clusters(table, by_run=by_run))
    return OcclusionSurvival(table, "runs" if by_run else "vehicles", logistic.fit(gap, survived), resampled)


def clusters(table: pd.DataFrame, *, by_run: bool) -> Ints:
    """(n,) index of the run of each occlusion, or of the vehicle in its run."""
    keys = ["run"] if by_run else ["run", "actor_id"]
    index: Ints = table.groupby(keys, sort=False).ngroup().to_numpy()
    return index


def group_shares(found: OcclusionSurvival, column: str) -> pd.DataFrame:
    """Return `level`, `occlusions`, `share`, `low` and `high` for each value of a column, most frequent first."""
    cluster = pd.Series(clusters(found.table, by_run=found.clusters == "runs"), found.table.index)
    rows = []
    for level, members in found.table.groupby(column, observed=True):
        share, (low, high) = clustered_share(
            members["survived"].to_numpy(), pd.factorize(cluster[members.index])[0].astype(np.int64)
        )
        rows.append((level, len(members), share, low, high))
    shares = pd.DataFrame(rows, columns=["level", "occlusions", "share", "low", "high"])
    return shares.sort_values("occlusions", ascending=False, ignore_index=True)


def clustered_share(survived: Bools, cluster: Ints) -> tuple[float, Interval]:
    """Return the share of survivors (n,) and its interval, with the variance between clusters (n,).

    If all agree, or all are of one cluster, each cluster counts as one observation.
    """
    n, count = len(survived), int(cluster.max()) + 1
    share = float(survived.mean())
    residual = np.bincount(cluster, survived - share)
    variance = float(residual @ residual) * count / max(count - 1, 1) / n**2
    number = float(count)
    if 0.0 < share < 1.0 and count > 1:
        few = scipy.stats.t.ppf(TAIL, n - 1) / scipy.stats.t.ppf(TAIL, count - 1)
        number = min(float(effective_number(np.array(share), np.array(variance), few)), float(n))
    low, high = binomial_interval(np.array([share]), np.array([number]))
    return share, (float(low[0]), float(high[0]))


TABLE, DOCUMENT, PICTURE = "occlusions.parquet", "survival.json", "survival"
BINS_S = (0.0, 0.25, 0.5, 0.75, 1.0, 1.5, 2.0, 2.5, 3.0, 4.0, 6.0, 10.0)
"""Edges of the bins whose shares are drawn beside the curve."""
WORDS = {"hidden_by_kind": "hidden by", "manoeuvre": "while hidden, the vehicle", "kind": "class of the vehicle"}


def document(found: OcclusionSurvival) -> Document:
    """Return the shares and times; in the figures for programs, a time beyond the observed ones is null."""
    table, shares = found.table, {column: group_shares(found, column) for column in GROUPS}
    runs, vehicles = table["run"].nunique(), table.groupby(["run", "actor_id"]).ngroups
    answer = Answer(
        f"{table['survived'].mean():.0%} of the ids survive {len(table)} occlusions of {vehicles} vehicles in {runs} "
        f"run{'s' * (runs > 1)}; intervals: 95 %, over {found.clusters}"
    )
    groups = [_group_table(column, rows) for column, rows in shares.items()]
    data = {
        "occlusions": len(table),
        "runs": runs,
        "clusters": found.clusters,
        "hidden_s": [float(table["hidden_s"].min()), float(table["hidden_s"].max())],
        "intercept": float(found.curve.intercept[0]),
        "slope_per_s": float(found.curve.slope[0]),
        "thresholds": [_entry(found, share) for share in SHARES],
        "groups": {
            column: [{**row, "level": str(row["level"])} for row in rows.to_dict("records")]
            for column, rows in shares.items()
        },
    }
    return Document("Survival of ids", answer, [_thresholds(found)], [Section("groups", "Groups", groups)], data)


def write(found: OcclusionSurvival, out: Path, formats: list[str]) -> None:
    """Write table, JSON and figure into a folder, atomically; an earlier one of the same kind is replaced.

    Raises
    ------
    OutputError
        The folder cannot be written, or holds other files.
    """
    with atomic_folder.create(out, "--out", _refuse_other_files) as folder:
        with atomic_file.writing(out):
            found.table.to_parquet(folder / TABLE, index=False)
            text = json.dumps(json_data(document(found)), indent=2, allow_nan=False) + "\n"
            (folder / DOCUMENT).write_text(text, encoding="utf-8")
        figure = Figure(PICTURE, "Share of track ids that survive an occlusion", "", (7.0, 3.6), _painter(found))
        figure.save(folder, list(dict.fromkeys(["png", *formats])))


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


def _group_table(column: str, rows: pd.DataFrame) -> Table:
    table = table_of(f"Survival by: {WORDS[column]}", WORDS[column], "occlusions", "survive", "95 %")
    for row in rows.to_dict("records"):
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
