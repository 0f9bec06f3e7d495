"""Coverage of the intervals of studies, by studies of few seeds drawn from many."""

from typing import NamedTuple

import numpy as np
import pandas as pd
from intervals.populations import Kind

from luxloop.arrays import Floats
from luxloop.scenarios.statistics.intervals import Interval
from luxloop.scenarios.study import survival
from luxloop.scenarios.study.curves import Estimate, estimate


class Coverage(NamedTuple):
    """Share of the drawn samples whose interval contains the truth."""

    truth: float
    share: float
    width: float
    """Median width of the intervals."""


def seed_coverage(rows: pd.DataFrame, kind: Kind, seeds: int, draws: int, rng: np.random.Generator) -> Coverage:
    """Return the coverage of one kind of interval for studies of some seeds, drawn with replacement."""
    values = rows["value"].to_numpy(np.float64)
    values = values[np.isfinite(values)]
    within = (0.0, 1.0) if kind == "share" else None
    found = [
        _shown(estimate(drawn, np.arange(seeds), within), kind) for drawn in rng.choice(values, size=(draws, seeds))
    ]
    return of_intervals(_truth(values, kind), found)


def survival_coverage(seeds: int, runs: int, at_s: float, draws: int, rng: np.random.Generator) -> Coverage:
    """Return the coverage of the band of a survival curve at one time.

    Times are exponential with mean 1 s, censored between 0.5 and 3 s; half of the runs of a seed have the same one.
    """
    found = []
    for _ in range(draws):
        own = np.where(
            rng.random((runs, seeds)) < 0.5, rng.exponential(size=seeds), rng.exponential(size=(runs, seeds))
        )
        limit = rng.uniform(0.5, 3.0, (runs, seeds))
        time, reached = np.minimum(own, limit).ravel(), (own <= limit).ravel()
        curve = survival.curve(time, reached, np.tile(np.arange(seeds), runs).astype(np.float64))
        k = int(np.searchsorted(curve.at, at_s, side="right")) - 1
        found.append((float(curve.low[k]), float(curve.high[k])) if k >= 0 else curve.start)
    return of_intervals(float(np.exp(-at_s)), found)


def of_intervals(truth: float, intervals: list[Interval]) -> Coverage:
    """Return the coverage of some intervals."""
    low, high = np.array(intervals).T
    inside = (low <= truth + 1e-9) & (truth - 1e-9 <= high)
    return Coverage(truth, float(inside.mean()), float(np.median(high - low)))


def _shown(found: Estimate, kind: Kind) -> Interval:
    return (found.any_low, found.any_high) if kind == "seeds with any" else (found.low, found.high)


def _truth(values: Floats, kind: Kind) -> float:
    if kind == "seeds with any":
        return float((values != 0.0).mean())
    return float(values.mean() if kind == "share" else np.median(values))
