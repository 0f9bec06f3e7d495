"""Objective of a search: the size of the disturbance, among the disturbances with which the metric fails."""

import math
from collections.abc import Mapping, Sequence

from luxloop.scenarios.files.expect import Limit
from luxloop.scenarios.study.parameter import Parameter, Value

NO_VALUE_SCORE = 3.0
"""Score of a run in which the metric has no value: worse than all others."""


def size(varied: Sequence[Parameter], values: Mapping[str, Value]) -> float:
    """Return the size of a disturbance, 0 (all parameters neutral) to 1 (all as far from neutral as possible).

    The size is the mean distance over the parameters. This norm (L1) favours few large disturbances over many small
    ones, so that the cause of a failure is easier to see.
    """
    return sum(distance(parameter, values[parameter.key]) for parameter in varied) / len(varied)


def distance(parameter: Parameter, value: Value) -> float:
    """Return the distance of a value from neutral, relative to the farther end of the range.

    For texts and booleans, every value other than neutral has the distance 1.
    """
    assert parameter.neutral is not None
    if value == parameter.neutral:
        return 0.0
    ends = parameter.values if parameter.values is not None else [parameter.low, parameter.high]
    if any(isinstance(end, str | bool) for end in ends):
        return 1.0
    positions = [_position(parameter, end) for end in ends if end is not None]
    neutral = _position(parameter, parameter.neutral)
    return abs(_position(parameter, value) - neutral) / max(abs(end - neutral) for end in positions)


def _position(parameter: Parameter, value: Value) -> float:
    return math.log(float(value)) if parameter.scale == "log" else float(value)


def fails(limit: Limit, value: float | None) -> bool:
    """Return True if a metric violates its limit; a metric without a value is not a failure."""
    return value is not None and not limit.holds(value)


def score(limit: Limit, value: float | None, disturbance: float) -> float:
    """Return the score that the search minimises: the size of a disturbance that fails; more than 1 for all others.

    The others are scored by the metric's distance to its limit, and by their size: most tracking metrics are counts,
    which are constant until they fail, and larger disturbances are more likely to fail.
    """
    if value is None:
        return NO_VALUE_SCORE
    if fails(limit, value):
        return disturbance
    margin = min(abs(end - value) for end in (limit.min, limit.max) if end is not None)
    return 1.0 + 0.5 * (margin / (1.0 + margin)) + 0.5 * (1.0 - disturbance)
