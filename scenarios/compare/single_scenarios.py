"""Losses in single scenarios, which are too small in the pooled runs to be found there.

Each scenario, with all its seeds, has an exact one-sided randomisation test of its vehicles, adjusted for all metrics
(single-step max-T, as for the pooled runs), and for all scenarios by Holm 1979, A Simple Sequentially Rejective
Multiple Test Procedure. Scenarios with so few different vehicles that no outcome could be significant are left out of
this correction (Tarone 1990, A Modified Bonferroni Method for Discrete Data). Without it, every scenario without a
change would lower the power of the others.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from luxloop.scenarios.arrays import Floats
from luxloop.scenarios.compare.compared_metrics import COMPARED_METRICS, ComparedMetric
from luxloop.scenarios.compare.exchanges import LossTest, loss_test


@dataclass(frozen=True, slots=True)
class ScenarioLoss:
    """The clearest significant and relevant loss of one scenario."""

    scenario: str
    metric: ComparedMetric
    base: float
    head: float
    p: float
    """P-value adjusted for all metrics and all scenarios."""
    units: int
    """Number of different vehicles, and one for the false tracks."""


def losses(units: Mapping[str, tuple[Floats, Floats]], level: float) -> list[ScenarioLoss]:
    """Find significant and relevant losses in single scenarios, the clearest first.

    Parameters
    ----------
    units
        Sums (U, len(COLUMNS)) of the units in BASE and in HEAD, per scenario.
    level
        Probability of any loss found without a real change.
    """
    tests = {name: test for name, sides in units.items() if (test := loss_test(*sides, COMPARED_METRICS))}
    adjusted = _holm({name: test.smallest_p for name, test in tests.items()}, candidates(tests, level))
    found = [_loss(name, test, adjusted[name]) for name, test in tests.items() if adjusted[name] <= level]
    return sorted(found, key=lambda each: (each.p, each.scenario))


def candidates(tests: Mapping[str, LossTest], level: float) -> set[str]:
    """Return the scenarios for which significance is possible at all (Tarone 1990)."""
    count = 0
    chosen = set(tests)
    while len(chosen) > count:
        count += 1
        chosen = {name for name, test in tests.items() if test.attainable_p <= level / count}
    return chosen


def _holm(smallest: Mapping[str, float], chosen: set[str]) -> dict[str, float]:
    """Return p-values adjusted by Holm's procedure; 1 for scenarios that were not chosen."""
    adjusted, reached = dict.fromkeys(smallest, 1.0), 0.0
    for rank, name in enumerate(sorted(chosen, key=lambda name: smallest[name])):
        reached = max(reached, min(1.0, smallest[name] * (len(chosen) - rank)))
        adjusted[name] = reached
    return adjusted


def _loss(name: str, test: LossTest, p: float) -> ScenarioLoss:
    metric = int(np.argmin(test.relevant_p))
    return ScenarioLoss(
        name, COMPARED_METRICS[metric], float(test.base[metric]), float(test.head[metric]), p, test.units
    )
