"""What the rows of a study say: means with 95 % intervals, and paired differences between curves.

Every combination of parameters runs with the same seeds, so that the same car, noise and chance meets them all (common
random numbers). Seeds are the independent draws; the runs of one seed are not, and count as one by their mean.
Intervals of a mean are Student's over the seeds' means, and those of a difference Student's over the seeds'
differences, run against run (Law 2015, Simulation Modeling and Analysis, sections 10.2 and 11.2). With the few seeds
that one can afford, percentiles of a bootstrap would be too narrow, by a quarter with eight seeds. Where every run is a
yes or a no, as whether an id survived, the interval is Wilson's (1927), over runs: it has a width where all agree.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd
from scipy import stats

from scenarios.arrays import Floats
from scenarios.study.worker import BROKEN

CONFIDENCE = 0.95
LEVELS = 12
"""A column with more different numbers than that is divided into `BINS`."""
BINS = 8


@dataclass(frozen=True, slots=True)
class Estimate:
    """A mean over runs; NaN where there is nothing to tell."""

    mean: float
    low: float
    high: float
    n: int
    """Runs that have a value: a car that is never found again has no time until it is."""
    runs: int
    """All runs."""


def measured(rows: pd.DataFrame) -> pd.DataFrame:
    """Rows of runs that came to their end."""
    return rows[~rows["status"].isin(BROKEN)]


def is_yes_or_no(values: pd.Series) -> bool:
    """Whether a metric (over all rows of a study) is 0 or 1 in every run."""
    return bool(values.dropna().isin((0.0, 1.0)).all())


def estimate(values: pd.Series, seeds: pd.Series, yes_or_no: bool) -> Estimate:
    """Mean of the values of some runs, which have these seeds, with its interval."""
    known = values.notna()
    number, own = values[known].to_numpy(dtype=np.float64), seeds[known]
    if not len(number):
        return Estimate(math.nan, math.nan, math.nan, 0, len(values))
    low, high = wilson(int(number.sum()), len(number)) if yes_or_no else student(_by_seed(number, own))
    return Estimate(float(number.mean()), low, high, len(number), len(values))


def wilson(yes: int, runs: int) -> tuple[float, float]:
    """Interval of a share (Wilson 1927, Journal of the American Statistical Association 22, 209)."""
    interval = stats.binomtest(yes, runs).proportion_ci(CONFIDENCE, "wilson")
    return float(interval.low), float(interval.high)


def student(values: Floats) -> tuple[float, float]:
    """Interval of the mean of independent values (n,); NaN of a single one."""
    if len(values) < 2:
        return math.nan, math.nan
    half = float(stats.t.ppf(0.5 + 0.5 * CONFIDENCE, len(values) - 1) * stats.sem(values))
    return float(values.mean()) - half, float(values.mean()) + half


def estimates(rows: pd.DataFrame, metric: str, keys: Sequence[str]) -> pd.DataFrame:
    """Estimate a metric for each combination of the columns `keys`, over all runs that have it.

    Returns
    -------
    DataFrame
        The columns `keys`, in the order of their levels, and the fields of `Estimate`.
    """
    return _of_each(rows[metric], rows["seed"], _places(rows, keys), is_yes_or_no(rows[metric]))


def differences(rows: pd.DataFrame, metric: str, keys: Sequence[str], by: str, pairs: Sequence[str]) -> pd.DataFrame:
    """Estimate how much a metric differs from that of the first level of `by`, run against run.

    Parameters
    ----------
    rows, metric, keys
        As of `estimates`; `by` is one of `keys`.
    pairs
        All parameters of the study: two runs are a pair if only `by` tells them apart.

    Returns
    -------
    DataFrame
        As of `estimates`, for all levels of `by` but the first; `n` counts pairs in which both runs have a value.
    """
    level = levels(rows[by])
    is_first = level == level.cat.categories[0]
    alike = ["seed", *(key for key in pairs if key != by)]
    base, others = rows[is_first].set_index(alike)[metric], rows[~is_first]
    change = others[metric] - base.reindex(pd.MultiIndex.from_frame(others[alike])).to_numpy()
    return _of_each(change, others["seed"], _places(rows, keys)[~is_first], yes_or_no=False)


def _places(rows: pd.DataFrame, keys: Sequence[str]) -> pd.DataFrame:
    return pd.DataFrame({key: levels(rows[key]) for key in keys})


def _of_each(values: pd.Series, seeds: pd.Series, places: pd.DataFrame, yes_or_no: bool) -> pd.DataFrame:
    """Estimate each place: a row of the levels `places` (runs, keys), however many runs have it."""
    keys = list(places)
    found = [
        dict(zip(keys, place, strict=True)) | _fields(estimate(values[group.index], seeds[group.index], yes_or_no))
        for place, group in places.groupby(keys, sort=True, observed=True)
    ]
    return pd.DataFrame(found, columns=[*keys, *Estimate.__slots__]).astype(dict(places.dtypes))


def levels(column: pd.Series) -> pd.Series:
    """Return what is drawn separately, as an ordered category.

    Numbers are in their order, words in the study's. Too many numbers are divided into bins of equally many runs, each
    known by the number of its middle run.
    """
    if not pd.api.types.is_numeric_dtype(column):
        return pd.Series(pd.Categorical(column, pd.unique(column), ordered=True), column.index)
    number = column
    if column.nunique() > LEVELS:
        place = pd.qcut(column, BINS, labels=False, duplicates="drop")
        number = column.groupby(place).transform(lambda inside: float(f"{inside.median():.3g}"))
    return pd.Series(pd.Categorical(number, sorted(number.dropna().unique()), ordered=True), column.index)


def _by_seed(values: Floats, seeds: pd.Series) -> Floats:
    means: Floats = pd.Series(values).groupby(seeds.to_numpy()).mean().to_numpy()
    return means


def _fields(found: Estimate) -> dict[str, Any]:
    return {name: getattr(found, name) for name in Estimate.__slots__}
