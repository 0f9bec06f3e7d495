"""Shrinking a finding: whatever can go while the metric still fails, goes. Every step is run with the same seed.

The parameters return to neutral, and the scene loses what it does not need; again and again, until nothing more can go.
"""

from collections.abc import Callable
from itertools import chain, repeat

from scenarios.errors import StudyError
from scenarios.search import reductions
from scenarios.search.evaluator import Bench, Json
from scenarios.search.objective import distance, size
from scenarios.search.optimise import Finding, Make, Tell, spell
from scenarios.study.parameter import Value, Vary
from scenarios.study.study_file import Study

HALVINGS = 5
"""Of the way back to neutral: what is left is at most a thirty-second of it too far."""


def shrink(study: Study, finding: Finding, bench: Bench, make: Make, tell: Tell) -> Json:
    """Return the smallest scenario to which a finding shrinks."""
    parameters, cuts = dict(finding.parameters), list[reductions.Cut]()

    def scene() -> Json:
        return reductions.carry_out(cuts, make(parameters, finding.seed))

    while True:
        before = (dict(parameters), len(cuts))
        for vary in study.vary:
            _calm(vary, parameters, lambda: bench.fails(scene()), tell)
        for cut in (cut for kind in reductions.KINDS for cut in kind(scene())):
            smaller = cut.apply(scene())
            if smaller != scene() and bench.fails(smaller):
                cuts.append(cut)
                tell(cut.what)
        if before == (parameters, len(cuts)):
            break
    tell(f"its size was {finding.size:.3f} and is {size(study.vary, parameters):.3f}")
    return reductions.end(scene(), bench, tell)


def _calm(vary: Vary, parameters: dict[str, Value], fails: Callable[[], bool], tell: Tell) -> None:
    """Bring one of the parameters as near to neutral as it still fails."""
    before = parameters[vary.key]

    def still_fails(value: Value) -> bool:
        parameters[vary.key] = value
        try:
            return fails()
        except StudyError:  # no scene can be staged so
            return False

    parameters[vary.key] = towards_neutral(vary, before, still_fails)
    if parameters[vary.key] != before:
        tell(f"{spell({vary.key: parameters[vary.key]})} is enough" + _was(vary, parameters[vary.key], before))


def towards_neutral(vary: Vary, value: Value, still_fails: Callable[[Value], bool]) -> Value:
    """Return the value nearest to neutral, of those tried, with which it still fails; with `value` it does.

    Of a range, neutral itself is tried, then the way between is halved, in numbers of three digits; of listed values,
    all nearer ones are.
    """
    assert vary.neutral is not None
    if value == vary.neutral or still_fails(vary.neutral):
        return vary.neutral
    if vary.values is not None:
        nearer = [other for other in vary.values if 0.0 < distance(vary, other) < distance(vary, value)]
        nearer.sort(key=lambda other: distance(vary, other))
        return next(filter(still_fails, nearer), value)
    return _halved(float(vary.neutral), float(value), still_fails)


def _halved(passes: float, fails: float, still_fails: Callable[[float], bool]) -> float:
    """Halve what lies between, after the number that fails was itself cut to three digits."""
    for share in chain([1.0], repeat(0.5, HALVINGS)):
        tried = float(f"{passes + share * (fails - passes):.3g}")
        if tried in (passes, fails):
            continue
        if still_fails(tried):
            fails = tried
        elif share < 1.0:
            passes = tried
    return fails


def _was(vary: Vary, value: Value, before: Value) -> str:
    told = spell({"": before}).removeprefix(" = ")
    return f" (it was {told}" + ("; neutral)" if value == vary.neutral else ")")
