"""Estimates from the runs of some seeds: a share with an exact interval, or a median with one of order statistics.

Runs of one seed are correlated. They enter as their mean, and the seeds are the independent samples. A metric that is 0
or 1 in every run is a share of runs: its mean over seeds has an interval. All other metrics have heavy tails: a few
seeds rarely contain the rare large values that dominate a mean, and no interval of a mean holds what it states. The
median over seeds has one that does.
"""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd

from luxloop.scenarios.arrays import Bools, Floats, Ints
from luxloop.scenarios.statistics.bounded_mean import bounded_mean_interval
from luxloop.scenarios.statistics.confidence import Interval
from luxloop.scenarios.statistics.median_interval import median_interval

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
