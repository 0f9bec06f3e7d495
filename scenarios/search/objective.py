"""What a search minimises: how far the parameters are from neutral, among those with which the metric fails."""

import math
from collections.abc import Mapping, Sequence

from scenarios.files.expect import Limit
from scenarios.study.parameter import Value, Vary

NOTHING_SHOWN = 3.0
"""Score of a run that says nothing of the metric: worse than all that do."""


def size(varied: Sequence[Vary], parameters: Mapping[str, Value]) -> float:
    """Return the size of a disturbance, 0 (nothing is disturbed) to 1 (everything as far from neutral as it goes).

    It is the mean over the parameters: a sum of distances, as no other norm, would rather have few large ones than
    many small ones, and the cause of a failure is then easier to see.
    """
    return sum(distance(vary, parameters[vary.key]) for vary in varied) / len(varied)


def distance(vary: Vary, value: Value) -> float:
    """Return how far a value is from neutral, as a share of the longest way from neutral to an end of its range.

    Of texts and truth values, every other one is as far as can be.
    """
    assert vary.neutral is not None
    if value == vary.neutral:
        return 0.0
    ends = vary.values if vary.values is not None else [vary.low, vary.high]
    if any(isinstance(end, str | bool) for end in ends):
        return 1.0
    place = [_place(vary, end) for end in ends if end is not None]
    neutral = _place(vary, vary.neutral)
    return abs(_place(vary, value) - neutral) / max(abs(end - neutral) for end in place)


def _place(vary: Vary, value: Value) -> float:
    return math.log(float(value)) if vary.scale == "log" else float(value)


def fails(limit: Limit, value: float | None) -> bool:
    """Whether a metric breaks its limit; one without a value shows nothing, and an adversary has to show something."""
    return value is not None and not limit.holds(value)


def score(limit: Limit, value: float | None, disturbance: float) -> float:
    """Return what the search minimises: the size of a disturbance that makes the metric fail; more than 1 of others.

    Others are led by the metric's way to its limit, and by their own size: most metrics of a tracker count, so that no
    way is to be seen until they fail, and what is disturbed more is likelier to.
    """
    if value is None:
        return NOTHING_SHOWN
    if fails(limit, value):
        return disturbance
    way = min(abs(end - value) for end in (limit.min, limit.max) if end is not None)
    return 1.0 + 0.5 * (way / (1.0 + way)) + 0.5 * (1.0 - disturbance)
