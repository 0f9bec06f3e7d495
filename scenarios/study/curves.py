"""Statistics of a study: estimates with 95 % intervals over seeds, and paired differences between curves.

Every combination of parameters runs with the same seeds (common random numbers), so vehicles and noise are the same in
all of them. Two curves are therefore compared by the differences of each seed (Law 2015, Simulation Modeling and
Analysis, section 11.2), which have the same kinds of intervals as the curves.

Runs of one seed are correlated. They enter as their mean, and the seeds are the independent samples. A metric that is 0
or 1 in every run is a share of runs: its mean over seeds has an interval. All other metrics have heavy tails: a few
seeds rarely contain the rare large values that dominate a mean, and no interval of a mean holds what it states. The
median over seeds has one that does.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd

from luxloop.arrays import Bools, Floats, Ints
from luxloop.scenarios.statistics.intervals import (
    Interval,
    bounded_mean_interval,
    few_seeds,
    is_dominated,
    median_interval,
)
from luxloop.scenarios.study.worker import BROKEN

NONE: Interval = (math.nan, math.nan)


@dataclass(frozen=True, slots=True)
class Estimate:
    """Figure over seeds with its 95 % interval; NaN if no run has a value."""

    value: float
    """Share of runs, averaged over seeds, or median over seeds."""
    low: float
    """NaN for too few seeds."""
    high: float
    mean: float
    """Mean over seeds, which has no interval of its own unless it is the value."""
    n: int
    """Number of runs with a value: e.g. a vehicle that is never tracked again has no reacquisition time."""
    runs: int
    """Number of all runs."""
    seeds: int
    """Number of seeds with a value."""
    share_any: float
    """Share of seeds with a value other than 0."""
    any_low: float
    any_high: float

    def fields(self) -> dict[str, Any]:
        """Return the fields by name."""
        return {name: getattr(self, name) for name in self.__slots__}


def is_binary(values: pd.Series) -> bool:
    """Return True if a metric (over all rows of a study) is 0 or 1 in every run."""
    return bool(values.dropna().isin((0.0, 1.0)).all())


def estimate(values: Floats, seeds: Ints, within: Interval | None) -> Estimate:
    """Return the estimate of the values of some runs.

    Parameters
    ----------
    values
        (n,) NaN for a run without a value.
    seeds
        (n,) seed of each run.
    within
        Range of the values of a share, (0, 1), or of a difference of shares, (-1, 1); None for a median.
    """
    known = np.isfinite(values)
    if not known.any():
        return Estimate(math.nan, *NONE, math.nan, 0, len(values), 0, math.nan, *NONE)
    of_seed = seed_means(values[known], seeds[known])
    mean = float(of_seed.mean())
    value, interval = (
        (float(np.median(of_seed)), median_interval(of_seed) or NONE)
        if within is None
        else (mean, bounded_mean_interval(of_seed, *within))
    )
    other = of_seed != 0.0
    return Estimate(
        value, *interval, mean, int(known.sum()), len(values), len(of_seed), float(other.mean()), *share_interval(other)
    )


def share_interval(found: Bools) -> Interval:
    """Return the interval of the share of seeds (n,) in which something is found."""
    return bounded_mean_interval(found.astype(np.float64))


def seed_means(values: Floats, seeds: Ints) -> Floats:
    """(S,) mean of the values (n,) of each seed, in ascending order of the seeds."""
    _, row = np.unique(seeds, return_inverse=True)
    means: Floats = np.bincount(row, values) / np.bincount(row)
    return means


LEVELS = 12
"""Maximum number of distinct numbers in a column; a column with more is divided into `BINS`."""
BINS = 8


def measured(rows: pd.DataFrame) -> pd.DataFrame:
    """Return the rows of completed runs."""
    return rows[~rows["status"].isin(BROKEN)]


def estimates(rows: pd.DataFrame, metric: str, keys: Sequence[str]) -> pd.DataFrame:
    """Estimate a metric for each combination of the columns `keys`, over all runs of that combination.

    Returns
    -------
    DataFrame
        The columns `keys`, in the order of their levels, and the fields of `Estimate`.
    """
    within = (0.0, 1.0) if is_binary(rows[metric]) else None
    return _group_estimates(rows[metric], rows["seed"], groups(rows, keys), within)


def differences(rows: pd.DataFrame, metric: str, keys: Sequence[str], by: str, pairs: Sequence[str]) -> pd.DataFrame:
    """Estimate the paired differences of a metric from the first level of `by`.

    Parameters
    ----------
    rows, metric, keys
        As for `estimates`; `by` is one of `keys`.
    pairs
        All parameters of the study: two runs are a pair if they differ in `by` only.

    Returns
    -------
    DataFrame
        As for `estimates`, for all levels of `by` except the first; `n` counts pairs in which both runs have a value.
    """
    level = levels(rows[by])
    is_first = level == level.cat.categories[0]
    shared = ["seed", *(key for key in pairs if key != by)]
    base, others = rows[is_first].set_index(shared)[metric], rows[~is_first]
    change = others[metric] - base.reindex(pd.MultiIndex.from_frame(others[shared])).to_numpy()
    within = (-1.0, 1.0) if is_binary(rows[metric]) else None
    return _group_estimates(change, others["seed"], groups(rows, keys)[~is_first], within)


def groups(rows: pd.DataFrame, keys: Sequence[str]) -> pd.DataFrame:
    """Return the level of every run in each of the columns `keys`."""
    return pd.DataFrame({key: levels(rows[key]) for key in keys})


def _group_estimates(values: pd.Series, seeds: pd.Series, group: pd.DataFrame, within: Interval | None) -> pd.DataFrame:
    """Estimate each group of runs; `group` (runs, keys) holds the levels of every run."""
    keys = list(group)
    number = values.astype("float64")
    found = [
        dict(zip(keys, level, strict=True))
        | estimate(number[members.index].to_numpy(), seeds[members.index].to_numpy(), within).fields()
        for level, members in group.groupby(keys, sort=True, observed=True)
    ]
    return pd.DataFrame(found, columns=[*keys, *Estimate.__slots__]).astype(dict(group.dtypes))


def levels(column: pd.Series) -> pd.Series:
    """Return a column as an ordered category.

    Numbers are sorted; texts keep the order of the study. A column with more than `LEVELS` numbers is divided into
    quantile bins, each represented by its median.
    """
    if not pd.api.types.is_numeric_dtype(column):
        return pd.Series(pd.Categorical(column, pd.unique(column), ordered=True), column.index)
    number = column
    if column.nunique() > LEVELS:
        quantile_bin = pd.qcut(column, BINS, labels=False, duplicates="drop")
        number = column.groupby(quantile_bin).transform(lambda members: float(f"{members.median():.3g}"))
    return pd.Series(pd.Categorical(number, sorted(number.dropna().unique()), ordered=True), column.index)


def seed_dots(rows: pd.DataFrame, metric: str, keys: Sequence[str]) -> pd.DataFrame:
    """Return the mean over the runs of each seed, for each combination of the columns `keys`.

    Returns
    -------
    DataFrame
        The columns `keys`, `seed` and `value`.
    """
    of = groups(rows, keys).assign(seed=rows["seed"], value=rows[metric].astype("float64"))
    return of.groupby([*keys, "seed"], sort=True, observed=True)["value"].mean().dropna().reset_index()


def seed_warnings(rows: pd.DataFrame, metric: str, keys: Sequence[str]) -> list[str]:
    """Return the warnings about a curve: few seeds, and points whose sum is mostly that of one seed."""
    dots = seed_dots(rows, metric, keys)
    if dots.empty:
        return []
    of_point = dots.groupby(list(keys), sort=True, observed=True)["value"]
    few = few_seeds(int(dots["seed"].nunique()))
    dominated = 0 if is_binary(rows[metric]) else sum(is_dominated(values.to_numpy()) for _, values in of_point)
    one = f"in {dominated} of {of_point.ngroups} points one seed has more than half of the sum over seeds"
    return [*([few] if few else []), *([one] if dominated else [])]
