"""A comparison as JSON."""

import math
from typing import Any

from luxloop.scenarios.compare.compared_metrics import COMPARED_METRICS
from luxloop.scenarios.compare.comparison import LEVEL, Comparison, MetricChange
from luxloop.scenarios.compare.expectation_changes import ExpectationChange
from luxloop.scenarios.compare.run_pair import Pair
from luxloop.scenarios.compare.single_scenarios import ScenarioLoss


def document(comparison: Comparison, base: str, head: str) -> dict[str, Any]:
    """Return a comparison as a JSON document; missing values are null."""
    pairs = comparison.pairs
    return {
        "base": base,
        "head": head,
        "verdict": comparison.verdict,
        "failed": comparison.failed,
        "level": LEVEL,
        "stated_loss": comparison.loss,
        "pairs_measured": comparison.measured,
        "metrics": {change.metric.name: _metric(change) for change in comparison.changes},
        "scenario_losses": [_scenario(loss) for loss in comparison.scenario_losses],
        "expectations": [_expectation(change) for change in comparison.expectation_changes],
        "pairs": [_pair(pair) for pair in pairs.compared],
        "not_compared": [{**key._asdict(), "reason": why} for key, why in pairs.incomparable.items()],
        "newly_incomplete": [key._asdict() for key in pairs.newly_incomplete],
        "only_in_base": [key._asdict() for key in pairs.only_base],
        "only_in_head": [key._asdict() for key in pairs.only_head],
        "notes": pairs.notes,
    }


def _metric(change: MetricChange) -> dict[str, Any]:
    numbers = change.numbers
    return {
        "unit": change.metric.unit,
        "better": change.metric.better,
        "base": _number(numbers.base),
        "head": _number(numbers.head),
        "difference": _number(numbers.difference),
        "interval": [_number(end) for end in numbers.interval],
        "p": _number(numbers.p),
        "margin": _number(change.margin),
        "verdict": change.verdict,
        "where": [{**key._asdict(), "difference": moved} for key, moved in change.where.items()],
    }


def _scenario(loss: ScenarioLoss) -> dict[str, Any]:
    return {
        "scenario": loss.scenario,
        "metric": loss.metric.name,
        "base": _number(loss.base),
        "head": _number(loss.head),
        "p": loss.p,
        "units": loss.units,
    }


def _expectation(change: ExpectationChange) -> dict[str, Any]:
    return {
        **change.key._asdict(),
        "metric": change.name,
        "limit": change.head.limit,
        "base": change.base.value if change.base else None,
        "head": change.head.value,
        "fate": change.fate,
    }


def _pair(pair: Pair) -> dict[str, Any]:
    """Return the metrics of a single pair, for information; the verdict is based on the pooled runs."""
    base, head = (sums.sum(axis=0, keepdims=True) for sums in pair.units())
    return {
        **pair.key._asdict(),
        "identical": pair.identical,
        "same": pair.same,
        "same_truth": pair.same_truth,
        "metrics": {m.name: [_number(m.value(base)[0]), _number(m.value(head)[0])] for m in COMPARED_METRICS},
    }


def _number(value: float) -> float | None:
    return None if math.isnan(value) else float(value)
