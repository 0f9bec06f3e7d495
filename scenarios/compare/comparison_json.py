"""A comparison as JSON."""

import math
from typing import Any

from scenarios.compare.compared_metrics import COMPARED_METRICS
from scenarios.compare.comparison import LEVEL, Change, Comparison, Fall
from scenarios.compare.run_pairs import Pair


def document(comparison: Comparison, base: str, head: str) -> dict[str, Any]:
    """Everything that a comparison says; null stands for what was not measured."""
    pairs = comparison.pairs
    return {
        "base": base,
        "head": head,
        "verdict": comparison.verdict,
        "failed": comparison.failed,
        "level": LEVEL,
        "metrics": {change.headline.name: _metric(change) for change in comparison.changes},
        "expectations": [_fall(fall) for fall in comparison.falls],
        "pairs": [_pair(pair) for pair in pairs.compared],
        "not_compared": [{**key._asdict(), "reason": why} for key, why in pairs.unlike.items()],
        "newly_incomplete": [key._asdict() for key in pairs.newly_incomplete],
        "only_in_base": [key._asdict() for key in pairs.only_base],
        "only_in_head": [key._asdict() for key in pairs.only_head],
        "notes": pairs.notes,
    }


def _metric(change: Change) -> dict[str, Any]:
    numbers = change.numbers
    return {
        "unit": change.headline.unit,
        "better": change.headline.better,
        "base": _number(numbers.base),
        "head": _number(numbers.head),
        "difference": _number(numbers.difference),
        "interval": [_number(end) for end in numbers.interval],
        "p": _number(numbers.p),
        "margin": _number(change.margin),
        "verdict": change.verdict,
        "where": [{**key._asdict(), "difference": moved} for key, moved in change.where.items()],
    }


def _fall(fall: Fall) -> dict[str, Any]:
    return {
        **fall.key._asdict(),
        "metric": fall.name,
        "limit": fall.head.limit,
        "base": fall.base.value if fall.base else None,
        "head": fall.head.value,
        "fate": fall.fate,
    }


def _pair(pair: Pair) -> dict[str, Any]:
    """One pair of runs with its own values: to look at, not to judge by."""
    base, head = (sums.sum(axis=0, keepdims=True) for sums in pair.units())
    return {
        **pair.key._asdict(),
        "identical": pair.identical,
        "same_truth": pair.same_truth,
        "metrics": {h.name: [_number(h.value(base)[0]), _number(h.value(head)[0])] for h in COMPARED_METRICS},
    }


def _number(value: float) -> float | None:
    return None if math.isnan(value) else float(value)
