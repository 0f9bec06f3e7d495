"""Initial trials of a search: one parameter at an end of its range, then two.

Most software failures are triggered by one condition or by two together (Kuhn, Wallace and Gallo 2004, IEEE
Transactions on Software Engineering 30, 418), and disturbances of one or two parameters are the smallest ones.
"""

from itertools import combinations, product

from luxloop.scenarios.search.objective import size
from luxloop.scenarios.study.parameter import Parameter, Value
from luxloop.scenarios.study.study_file import Study

SHARE = 0.5
"""Maximum share of the trials of a search; the sampler proposes the others."""


def initial_trials(study: Study, trials: int) -> list[dict[str, Value]]:
    """Return parameters with one at an end and the others neutral, then with two; both sorted by size."""
    neutral = {parameter.key: parameter.neutral for parameter in study.vary if parameter.neutral is not None}
    by_parameter = [[{parameter.key: end} for end in _ends(parameter)] for parameter in study.vary]
    singles = [single for some in by_parameter for single in some]
    pairs = [a | b for some, others in combinations(by_parameter, 2) for a, b in product(some, others)]
    found = [
        neutral | disturbed
        for group in (singles, pairs)
        for disturbed in sorted(group, key=lambda disturbed: size(study.vary, neutral | disturbed))
    ]
    return found[: int(SHARE * trials)]


def _ends(parameter: Parameter) -> list[Value]:
    """Return the ends of a range or of listed numbers, or all listed texts; without the neutral value."""
    ends: list[Value | None] = [parameter.low, parameter.high]
    if parameter.values is not None:
        texts = any(isinstance(value, str | bool) for value in parameter.values)
        ends = list(parameter.values) if texts else [min(parameter.values), max(parameter.values)]
    return [end for end in ends if end is not None and end != parameter.neutral]
