"""Paired differences, and that of GOSPA, which is no ratio of sums over vehicles: runs are its clusters."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from luxloop.scenarios.arrays import Floats
from luxloop.scenarios.compare.digest import Key
from luxloop.scenarios.compare.resampling import difference_interval
from luxloop.scenarios.compare.sides import Side
from luxloop.scenarios.run import run_folder
from luxloop.scenarios.statistics.intervals import Interval

GOSPA = "track.gospa_m"


@dataclass(frozen=True, slots=True)
class PairedDifference:
    """Difference of a metric to the shipped tracker, over the runs that both finished."""

    difference: float
    interval: Interval
    """95 % interval; NaN without one."""
    better: bool
    """True if the tracker is better than the shipped one."""

    @property
    def clear(self) -> bool:
        """True if the interval does not contain 0."""
        return self.interval[0] > 0.0 or self.interval[1] < 0.0


def gospa_sums(side: Side) -> dict[Key, Floats]:
    """Return sum of GOSPA [m] and number of frames of each run."""
    found: dict[Key, Floats] = {}
    for key in side.runs:
        metric = run_folder.read(side.path / f"{key.scenario}-seed{key.seed}").metrics[GOSPA]
        if metric.value is not None:
            found[key] = np.array([metric.value * metric.n, metric.n])
    return found


def mean_gospa(sums: Sequence[Floats]) -> float:
    """Return the mean over all frames of some runs [m]; NaN without one."""
    total = np.sum(sums, axis=0) if sums else np.zeros(2)
    return float(total[0] / total[1]) if total[1] else math.nan


def gospa_difference(of_base: Mapping[Key, Floats], of_head: Mapping[Key, Floats]) -> PairedDifference:
    """Return the difference of the means over frames, with an interval that leaves out one run after the other."""
    common = [key for key in of_head if key in of_base]
    base, head = [of_base[key] for key in common], [of_head[key] for key in common]
    difference = mean_gospa(head) - mean_gospa(base)
    kept = [[k for k in range(len(head)) if k != run] for run in range(len(head))]
    rest = [mean_gospa([head[k] for k in runs]) - mean_gospa([base[k] for k in runs]) for runs in kept]
    weight = np.array([float(each[1]) for each in head])
    interval = difference_interval(difference, np.array(rest), weight)
    return PairedDifference(difference, interval, difference < 0.0)
