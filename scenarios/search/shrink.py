"""Reduction of a failing disturbance to a smaller scenario that still fails; every step runs with the same seed.

Parameters return towards neutral, and unnecessary elements of the scene are removed, until no step succeeds.
"""

from collections.abc import Callable
from itertools import chain, repeat

from luxloop.scenarios.errors import StudyError
from luxloop.scenarios.search import reductions
from luxloop.scenarios.search.evaluator import Evaluator, Json, Notify
from luxloop.scenarios.search.objective import distance, size
from luxloop.scenarios.search.optimise import Disturbance, Make, as_text
from luxloop.scenarios.study.parameter import Parameter, Value
from luxloop.scenarios.study.study_file import Study

HALVINGS = 5
"""Number of bisections towards neutral: the remaining excess is at most 1/32 of the interval."""


class Budget:
    """Limit of the runs of a reduction; beyond it no further step succeeds.

    Parameters
    ----------
    evaluator
        Metric, limit and tracker.
    runs
        Maximum number of runs; None for no limit.
    """

    def __init__(self, evaluator: Evaluator, runs: int | None = None) -> None:
        self._evaluator = evaluator
        self._left = runs
        self.exceeded = False
        """True if a step was left out."""

    def fails(self, document: Json) -> bool:
        """Return True if the metric violates its limit in a scenario, False without a run if none is left."""
        if self._left == 0:
            self.exceeded = True
            return False
        if self._left is not None:
            self._left -= 1
        return self._evaluator.fails(document)


def shrink(
    study: Study, disturbance: Disturbance, evaluator: Evaluator, make: Make, notify: Notify, runs: int | None = None
) -> Json:
    """Return the smallest scenario found by reducing a failing disturbance.

    Parameters
    ----------
    study
        Study with the varied parameters and their neutral values.
    disturbance
        Failing disturbance.
    evaluator
        Metric, limit and tracker.
    make
        Makes a scenario document from parameters and a seed.
    notify
        Receives a line of text for every successful step.
    runs
        Maximum number of runs; None for no limit.
    """
    budget = Budget(evaluator, runs)
    parameters, applied = dict(disturbance.parameters), list[reductions.Reduction]()

    def scene() -> Json:
        return reductions.apply_all(applied, make(parameters, disturbance.seed))

    while True:
        before = (dict(parameters), len(applied))
        for parameter in study.vary:
            _reduce_parameter(parameter, parameters, lambda: budget.fails(scene()), notify)
        for reduction in (reduction for kind in reductions.KINDS for reduction in kind(scene())):
            smaller = reduction.apply(scene())
            if smaller != scene() and budget.fails(smaller):
                applied.append(reduction)
                notify(reduction.what)
        if before == (parameters, len(applied)):
            break
    notify(f"size reduced from {disturbance.size:.3f} to {size(study.vary, parameters):.3f}")
    shorter = reductions.shorten(scene(), evaluator, notify, budget.fails)
    if budget.exceeded:
        notify(f"stopped after {runs} runs of reduction ([search] reduction_runs); a smaller case may exist")
    return shorter


def _reduce_parameter(
    parameter: Parameter, parameters: dict[str, Value], fails: Callable[[], bool], notify: Notify
) -> None:
    """Move one parameter as close to neutral as the failure allows."""
    key = parameter.key
    before = parameters[key]

    def still_fails(value: Value) -> bool:
        parameters[key] = value
        try:
            return fails()
        except StudyError:  # the scene function rejects the value
            return False

    parameters[key] = towards_neutral(parameter, before, still_fails)
    if parameters[key] != before:
        notify(f"{as_text({key: parameters[key]})} is enough" + _reduced_from(parameter, parameters[key], before))


def towards_neutral(parameter: Parameter, value: Value, still_fails: Callable[[Value], bool]) -> Value:
    """Return the value nearest to neutral, of those tried, that still fails; `value` itself fails.

    Neutral is tried first. A range is then bisected with values of three significant digits; of listed values, all
    those nearer to neutral are tried.
    """
    assert parameter.neutral is not None
    if value == parameter.neutral or still_fails(parameter.neutral):
        return parameter.neutral
    if parameter.values is not None:
        nearer = [other for other in parameter.values if 0.0 < distance(parameter, other) < distance(parameter, value)]
        nearer.sort(key=lambda other: distance(parameter, other))
        return next(filter(still_fails, nearer), value)
    return _bisect(float(parameter.neutral), float(value), still_fails)


def _bisect(passes: float, fails: float, still_fails: Callable[[float], bool]) -> float:
    """Bisect between a value that passes and one that fails; the latter is first rounded to three digits."""
    for share in chain([1.0], repeat(0.5, HALVINGS)):
        tried = float(f"{passes + share * (fails - passes):.3g}")
        if tried in (passes, fails):
            continue
        if still_fails(tried):
            fails = tried
        elif share < 1.0:
            passes = tried
    return fails


def _reduced_from(parameter: Parameter, value: Value, before: Value) -> str:
    old = as_text({"": before}).removeprefix(" = ")
    return f" (it was {old}" + ("; neutral)" if value == parameter.neutral else ")")
