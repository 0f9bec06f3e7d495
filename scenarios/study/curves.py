"""Statistics of a study: means with 95 % confidence intervals, and paired differences between curves.

Every combination of parameters runs with the same seeds (common random numbers), so vehicles and noise are the same in
all of them. Seeds are the independent samples: runs of one seed are correlated and enter as their mean. Intervals of a
mean are Student's t over the seed means; intervals of a difference are Student's t over the seeds' paired differences
(Law 2015, Simulation Modeling and Analysis, sections 10.2 and 11.2). Percentile bootstrap intervals would be too narrow
for few seeds: by a quarter for eight. For binary metrics, such as survival of an id, the interval is Wilson's (1927)
over runs, which has a nonzero width also when all runs agree.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd
import scipy

from scenarios.arrays import Floats
from scenarios.study.worker import BROKEN

CONFIDENCE = 0.95
LEVELS = 12
"""Maximum number of distinct numbers in a column; a column with more is divided into `BINS`."""
BINS = 8


@dataclass(frozen=True, slots=True)
class Estimate:
    """Mean over runs with its confidence interval; NaN if no run has a value."""

    mean: float
    low: float
    high: float
    n: int
    """Number of runs with a value: e.g. a vehicle that is never tracked again has no reacquisition time."""
    runs: int
    """Number of all runs."""


def measured(rows: pd.DataFrame) -> pd.DataFrame:
    """Return the rows of completed runs."""
    return rows[~rows["status"].isin(BROKEN)]


def is_binary(values: pd.Series) -> bool:
    """Return True if a metric (over all rows of a study) is 0 or 1 in every run."""
    return bool(values.dropna().isin((0.0, 1.0)).all())


def estimate(values: pd.Series, seeds: pd.Series, binary: bool) -> Estimate:
    """Return the mean of the values of some runs with its interval; `seeds` holds the seed of each run."""
    known = values.notna()
    number, own = values[known].to_numpy(dtype=np.float64), seeds[known]
    if not len(number):
        return Estimate(math.nan, math.nan, math.nan, 0, len(values))
    low, high = wilson(int(number.sum()), len(number)) if binary else student(_seed_means(number, own))
    return Estimate(float(number.mean()), low, high, len(number), len(values))


def wilson(successes: int, runs: int) -> tuple[float, float]:
    """Return the confidence interval of a proportion (Wilson 1927, J. Am. Statistical Association 22, 209)."""
    interval = scipy.stats.binomtest(successes, runs).proportion_ci(CONFIDENCE, "wilson")
    return float(interval.low), float(interval.high)


def student(values: Floats) -> tuple[float, float]:
    """Return Student's t interval of the mean of independent values (n,); NaN for a single value."""
    if len(values) < 2:
        return math.nan, math.nan
    half = float(scipy.stats.t.ppf(0.5 + 0.5 * CONFIDENCE, len(values) - 1) * scipy.stats.sem(values))
    return float(values.mean()) - half, float(values.mean()) + half


def estimates(rows: pd.DataFrame, metric: str, keys: Sequence[str]) -> pd.DataFrame:
    """Estimate a metric for each combination of the columns `keys`, over all runs of that combination.

    Returns
    -------
    DataFrame
        The columns `keys`, in the order of their levels, and the fields of `Estimate`.
    """
    return _group_estimates(rows[metric], rows["seed"], _groups(rows, keys), is_binary(rows[metric]))


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
    return _group_estimates(change, others["seed"], _groups(rows, keys)[~is_first], binary=False)


def _groups(rows: pd.DataFrame, keys: Sequence[str]) -> pd.DataFrame:
    """Return the level of every run in each of the columns `keys`."""
    return pd.DataFrame({key: levels(rows[key]) for key in keys})


def _group_estimates(values: pd.Series, seeds: pd.Series, groups: pd.DataFrame, binary: bool) -> pd.DataFrame:
    """Estimate each group of runs; `groups` (runs, keys) holds the levels of every run."""
    keys = list(groups)
    found = [
        dict(zip(keys, group, strict=True)) | _fields(estimate(values[members.index], seeds[members.index], binary))
        for group, members in groups.groupby(keys, sort=True, observed=True)
    ]
    return pd.DataFrame(found, columns=[*keys, *Estimate.__slots__]).astype(dict(groups.dtypes))


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


def _seed_means(values: Floats, seeds: pd.Series) -> Floats:
    means: Floats = pd.Series(values).groupby(seeds.to_numpy()).mean().to_numpy()
    return means


def _fields(found: Estimate) -> dict[str, Any]:
    return {name: getattr(found, name) for name in Estimate.__slots__}
