"""Survival statistics of emergence over the runs of a study: Kaplan-Meier curves, medians, log-rank tests.

A run in which the target never reaches a stage is censored at the last frame with the target, and never left out. Runs
of one seed are correlated, so the variance is that between seeds (Williams 1995, Biometrics 51, 1037). The interval is
the exact binomial one with the effective number of runs by that variance (Korn and Graubard 1998, Survey Methodology
24, 193); without any event, or if all runs have one, the seeds count. It stays within 0 and 1.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd
import scipy

from luxloop.scenarios.arrays import Bools, Floats
from luxloop.scenarios.metrics.definitions import END, SURVIVAL, survival_measure
from luxloop.scenarios.statistics.intervals import binomial_interval, effective_number
from luxloop.scenarios.study.curves import levels


@dataclass(frozen=True, slots=True, eq=False)
class SurvivalCurve:
    """Share of runs that have not reached a stage, with its confidence interval, at the K times of events."""

    at: Floats
    """(K,) times of events in ascending order; falling measures are negative."""
    share: Floats
    """(K,) share of runs without the event just after that time."""
    low: Floats
    """(K,)"""
    high: Floats
    """(K,)"""
    start: tuple[float, float]
    """Interval of the share before the first event, which is 1."""


def survival_columns(stage: str, measure: str) -> tuple[str, str]:
    """Return the metrics that the curve of a stage needs beside its own: whether it is reached, and the end."""
    return f"emergence.reached{{stage={stage}}}", f"emergence.{measure}{{stage={END}}}"


def samples(rows: pd.DataFrame, metric: str, keys: Sequence[str]) -> pd.DataFrame:
    """Return `time`, `reached`, `seed` and the levels of the columns `keys` of every run with a value.

    `time` is negative for measures that fall, such as the distance to the meeting point. A run that does not reach the
    stage has the value at its end; without one (no beam, no meeting point) it has no row.
    """
    found = survival_measure(metric)
    assert found is not None
    stage, measure = found
    of_reached, of_end = survival_columns(stage, measure)
    reached = rows[of_reached] == 1.0
    time = rows[metric].where(reached, rows[of_end])
    table = pd.DataFrame({key: levels(rows[key]) for key in keys})
    table = table.assign(time=-time if SURVIVAL[measure] else time, reached=reached, seed=rows["seed"])
    return table[table["time"].notna()]


def curve(time: Floats, reached: Bools, seed: Floats) -> SurvivalCurve:
    """Return the Kaplan-Meier curve of the runs (N,) with intervals from the differences between seeds."""
    at = np.unique(time[reached])
    events = (time[:, None] == at) & reached[:, None]
    at_risk = time[:, None] >= at
    deaths, risk = events.sum(axis=0), at_risk.sum(axis=0)
    hazard = deaths / risk
    share = np.cumprod(1.0 - hazard)
    # Influence of each run on the logarithm of the share; for independent runs its sum of squares is Greenwood's.
    influence = np.cumsum((events - at_risk * hazard) / np.maximum(risk - deaths, 1), axis=1)
    seeds, index = np.unique(seed, return_inverse=True)
    sums = np.zeros((len(seeds), len(at)))
    np.add.at(sums, index, influence)
    variance = share**2 * (sums**2).sum(axis=0) * len(seeds) / max(len(seeds) - 1, 1)
    seeds_at_risk = np.array([len(np.unique(seed[row])) for row in at_risk.T], dtype=np.float64)
    effective = _effective_runs(share, variance, len(time), len(seeds), seeds_at_risk)
    low, high = binomial_interval(share, effective)
    first = binomial_interval(np.ones(1), np.array([float(len(seeds))]))
    return SurvivalCurve(at, share, low, high, (float(first[0][0]), 1.0))


def _effective_runs(share: Floats, variance: Floats, runs: int, seeds: int, seeds_at_risk: Floats) -> Floats:
    """(K,) number of independent runs with the same variance of the share, from 1 to the number of runs."""
    if seeds < 2:
        return np.full(len(share), np.nan)
    few = float(scipy.stats.t.ppf(0.975, runs - 1) / scipy.stats.t.ppf(0.975, seeds - 1))
    number = np.clip(effective_number(share, variance, few), 1.0, runs)
    certain = (share <= 0.0) | (share >= 1.0)
    return np.where(certain, seeds_at_risk, number)


def median(found: SurvivalCurve) -> tuple[float, float, float]:
    """Return the median with its interval (Brookmeyer and Crowley 1982); infinite where half never reach the stage."""

    def first_below_half(share: Floats) -> float:
        below = np.flatnonzero(share <= 0.5)
        return float(found.at[below[0]]) if len(below) else math.inf

    return first_below_half(found.share), first_below_half(found.low), first_below_half(found.high)


def log_rank(one: pd.DataFrame, other: pd.DataFrame) -> float:
    """Return the p-value of the log-rank test (Mantel 1966) that two groups of `samples` have the same distribution.

    It takes runs as independent. NaN without any event in either group.
    """
    if not len(one) or not len(other) or not (one["reached"].any() or other["reached"].any()):
        return math.nan
    data = [
        scipy.stats.CensoredData.right_censored(group["time"].to_numpy(), ~group["reached"].to_numpy())
        for group in (one, other)
    ]
    return float(scipy.stats.logrank(*data).pvalue)
