"""Statistics of a study: estimates with 95 % intervals over seeds, and paired differences between curves.

Every combination of parameters runs with the same seeds (common random numbers), so vehicles and noise are the same in
all of them. Two curves are therefore compared by the differences of each seed (Law 2015, Simulation Modeling and
Analysis, section 11.2), which have the same kinds of intervals as the curves (`luxloop.scenarios.study.seed_estimate`).
"""

from collections.abc import Sequence

import pandas as pd

from luxloop.scenarios.statistics.confidence import Interval
from luxloop.scenarios.statistics.seed_warnings import few_seeds, is_dominated
from luxloop.scenarios.study.seed_estimate import Estimate, estimate, is_binary
from luxloop.scenarios.study.worker import BROKEN

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
