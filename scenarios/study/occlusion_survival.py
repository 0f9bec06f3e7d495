"""Survival of track ids against the time hidden, over the occlusions of several runs."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd
import scipy

from luxloop.scenarios.arrays import Bools, Floats, Ints
from luxloop.scenarios.errors import OutputError
from luxloop.scenarios.run import run_folder
from luxloop.scenarios.statistics import logistic
from luxloop.scenarios.statistics.confidence import TAIL, Interval
from luxloop.scenarios.statistics.effective_binomial import binomial_interval, effective_number
from luxloop.scenarios.statistics.logistic import LogisticFit

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
