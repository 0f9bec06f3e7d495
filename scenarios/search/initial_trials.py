"""What a search tries first: one parameter at the end of its range, then two.

Most failures of software take one condition or two that meet (Kuhn, Wallace and Gallo 2004, IEEE Transactions on
Software Engineering 30, 418), and disturbances of one or two parameters are the smallest there are.
"""

from itertools import combinations, product

from scenarios.search.objective import size
from scenarios.study.parameter import Value, Vary
from scenarios.study.study_file import Study

SHARE = 0.5
"""Of the trials of a search, at most; the others are the sampler's."""


def ends(study: Study, trials: int) -> list[dict[str, Value]]:
    """Return parameters with one at an end and the others neutral, then with two, each the least disturbed first."""
    neutral = {vary.key: vary.neutral for vary in study.vary if vary.neutral is not None}
    of_each = [[{vary.key: end} for end in _ends(vary)] for vary in study.vary]
    ones = [one for some in of_each for one in some]
    twos = [a | b for some, others in combinations(of_each, 2) for a, b in product(some, others)]
    tries = [
        neutral | disturbed
        for group in (ones, twos)
        for disturbed in sorted(group, key=lambda disturbed: size(study.vary, neutral | disturbed))
    ]
    return tries[: int(SHARE * trials)]


def _ends(vary: Vary) -> list[Value]:
    """Ends of a range of numbers; all of a list of words. Neutral is none of them."""
    ends: list[Value | None] = [vary.low, vary.high]
    if vary.values is not None:
        words = any(isinstance(value, str | bool) for value in vary.values)
        ends = list(vary.values) if words else [min(vary.values), max(vary.values)]
    return [end for end in ends if end is not None and end != vary.neutral]
