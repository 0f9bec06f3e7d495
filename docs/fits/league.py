"""Comparison of the selection with every candidate in groups of observations, with intervals over vehicles."""

from typing import NamedTuple

import numpy as np
import pandas as pd
from fits.observations import groups

from luxloop.scenarios.statistics.intervals import Interval
from luxloop.scenarios.statistics.jackknife import ANY, ratio_interval
from luxloop.tracker.records import METHODS

CRITERIA = tuple(method for method in METHODS if method != "refined")
"""Candidates of the comparison; `refined` is fitted from them, and mostly equals `best`."""
FEWEST = 20
"""Observations of a group that is compared."""


class Difference(NamedTuple):
    """Mean absolute error of the selection minus that of a candidate [deg]."""

    method: str
    mean: float
    interval: Interval | None
    """95 %, over vehicles; None with too few of them."""


class Standing(NamedTuple):
    """Errors in one group of observations."""

    scenario: str
    group: str
    n: int
    vehicles: int
    means: dict[str, float]
    """Mean absolute heading error of each of `METHODS`, `best` and `oracle` [deg]; NaN without a rectangle."""
    differences: list[Difference]
    """From each candidate, the one with the least error first."""

    @property
    def losses(self) -> list[Difference]:
        """Candidates with less error than the selection, by more than the interval."""
        return [one for one in self.differences if one.interval is not None and one.interval[0] > 0.0]

    @property
    def verdict(self) -> str:
        """`wins`, `ties` or `loses` against the candidate with the least error; `too few vehicles` for an interval."""
        if self.losses:
            return "loses"
        interval = self.differences[0].interval
        if interval is None:
            return "too few vehicles"
        return "wins" if interval[1] < 0.0 else "ties"


def compare(observed: pd.DataFrame) -> tuple[list[Standing], list[Standing]]:
    """Return the groups over all runs, and those of each scenario."""
    apart = [one for name, rows in observed.groupby("scenario") for one in standings(rows, str(name))]
    return standings(observed, "all"), apart


def standings(observed: pd.DataFrame, scenario: str) -> list[Standing]:
    """Compare in all observations, and in those of each view and band that has enough."""
    return [_standing(scenario, name, group) for name, group in groups(observed) if len(group) >= FEWEST]


def _standing(scenario: str, name: str, group: pd.DataFrame) -> Standing:
    compared = [_difference(method, group) for method in CRITERIA if group[method].notna().any()]
    return Standing(
        scenario=scenario,
        group=name,
        n=len(group),
        vehicles=group["vehicle"].nunique(),
        means={method: float(group[method].mean()) for method in (*METHODS, "best", "oracle")},
        differences=sorted(compared, key=lambda one: -one.mean),
    )


def _difference(method: str, group: pd.DataFrame) -> Difference:
    """Compare over the observations that have a rectangle of both."""
    both = group[group[method].notna()]
    gap, vehicle = (both["best"] - both[method]).to_numpy(), both["vehicle"].to_numpy()
    return Difference(method, float(gap.mean()), ratio_interval(vehicle, gap, np.ones(len(gap)), ANY))
