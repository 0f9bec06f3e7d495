"""Single seeds behind the points of a curve, and warnings about them."""

from collections.abc import Sequence

import pandas as pd

from luxloop.scenarios.statistics.seed_warnings import few_seeds, is_dominated
from luxloop.scenarios.study.curves import groups
from luxloop.scenarios.study.seed_estimate import is_binary


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
