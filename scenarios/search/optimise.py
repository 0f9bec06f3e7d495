"""Optimisation of the disturbance: optuna proposes trials; the smallest one that fails is kept.

Most software failures are triggered by one condition or by two together (Kuhn, Wallace and Gallo 2004, IEEE
Transactions on Software Engineering 30, 418), and disturbances of one or two parameters are the smallest ones.
"""

from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from itertools import combinations, product
from typing import TYPE_CHECKING, cast

from luxloop.scenarios.errors import ScenarioError, StudyError
from luxloop.scenarios.exit_codes import INTERNAL_ERROR
from luxloop.scenarios.files.scenario import Scenario
from luxloop.scenarios.run import progress
from luxloop.scenarios.search.evaluator import Evaluator, Json, Notify, fails, score, size
from luxloop.scenarios.study.parameter import Parameter, Value
from luxloop.scenarios.study.study_file import Study

if TYPE_CHECKING:
    import optuna


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


SAMPLING_SEED = 0
"""Seed of optuna's sampler; fixed, so that a study always gets the same proposals."""

Make = Callable[[dict[str, Value], int], Json]
"""Makes a scenario document from parameters and a seed."""


@dataclass(frozen=True, slots=True)
class Disturbance:
    """A combination of parameters and a seed."""

    parameters: dict[str, Value]
    seed: int
    size: float
    """See `evaluator.size`."""


def optimise(study: Study, evaluator: Evaluator, make: Make, notify: Notify) -> Disturbance | None:
    """Find the smallest disturbance with which the metric fails; None if no trial fails.

    The first trial is undisturbed: if it fails, no search is needed. The next ones set one or two parameters to the
    ends of their ranges (`initial_trials`). Then a tree-structured Parzen estimator (Bergstra et al. 2011) that has
    seen all of them proposes the parameters and one of the study's seeds, in batches of `at_once`. The proposals depend
    on the evaluations only, not on the number of workers or the order in which runs end.

    Raises
    ------
    StudyError
        The undisturbed scenario cannot run, or has no value of the metric.
    """
    neutral = Disturbance({parameter.key: _neutral(parameter) for parameter in study.vary}, study.seed_list[0], 0.0)
    if _undisturbed_fails(study, evaluator, make, neutral):
        notify("the undisturbed scenario fails")
        return neutral
    best: Disturbance | None = None
    sampler = _sampler()
    for parameters in initial_trials(study, evaluator.search.trials):
        sampler.enqueue_trial(parameters)
    count, at_once = evaluator.search.trials, evaluator.search.at_once
    with progress.runs(study.path.stem, count, done=1) as advance:
        for done in range(1, count, at_once):
            trials = [sampler.ask() for _ in range(min(at_once, count - done))]
            proposed = [_propose(trial, study) for trial in trials]
            for trial, one, value in zip(trials, proposed, _values(evaluator, make, proposed), strict=True):
                sampler.tell(trial, score(evaluator.search.limit, value, one.size))
                if fails(evaluator.search.limit, value) and (best is None or one.size < best.size):
                    best = one
                    notify(f"fails at size {one.size:.3f} with {as_text(one.parameters)}, seed = {one.seed}")
            advance(len(trials))
    return best


def as_text(parameters: dict[str, Value]) -> str:
    """Return parameters as one line of text."""
    return ", ".join(
        f"{key} = {value:.4g}" if isinstance(value, float) else f"{key} = {value}" for key, value in parameters.items()
    )


def _undisturbed_fails(study: Study, evaluator: Evaluator, make: Make, neutral: Disturbance) -> bool:
    try:
        document = make(neutral.parameters, neutral.seed)
        Scenario.of(document, evaluator.path)
    except ScenarioError as error:
        raise StudyError(f"{study.path}: with nothing disturbed: {error}") from error
    evaluation = evaluator.evaluate(document)
    if evaluation.error.startswith(INTERNAL_ERROR):
        raise RuntimeError(f"{study.path}: with nothing disturbed: {evaluation.error}")
    if evaluation.error:
        raise StudyError(f"{study.path}: with nothing disturbed: {evaluation.error}")
    return fails(evaluator.search.limit, evaluation.value)


def _values(evaluator: Evaluator, make: Make, proposed: list[Disturbance]) -> list[float | None]:
    """Return the metric of each proposal; None if the scene function rejects the parameters."""
    documents: dict[int, Json] = {}
    for n, one in enumerate(proposed):
        with suppress(StudyError):
            documents[n] = make(one.parameters, one.seed)
    evaluations = dict(zip(documents, evaluator.evaluate_all(list(documents.values())), strict=True))
    return [evaluations[n].value if n in evaluations else None for n in range(len(proposed))]


def _sampler() -> "optuna.Study":
    import optuna  # slow to import, and optional

    optuna.logging.set_verbosity(optuna.logging.WARNING)
    # The constant liar assumes a bad score for pending trials, so that a batch contains different proposals.
    sampler = optuna.samplers.TPESampler(seed=SAMPLING_SEED, constant_liar=True)
    return optuna.create_study(sampler=sampler)


def _propose(trial: "optuna.Trial", study: Study) -> Disturbance:
    parameters = {parameter.key: _propose_value(trial, parameter) for parameter in study.vary}
    seed = trial.suggest_categorical("seed", study.seed_list)
    return Disturbance(parameters, seed, size(study.vary, parameters))


def _propose_value(trial: "optuna.Trial", parameter: Parameter) -> Value:
    if parameter.values is not None:
        return cast(Value, trial.suggest_categorical(parameter.key, parameter.values))
    assert parameter.low is not None
    assert parameter.high is not None
    return trial.suggest_float(parameter.key, parameter.low, parameter.high, log=parameter.scale == "log")


def _neutral(parameter: Parameter) -> Value:
    assert parameter.neutral is not None
    return parameter.neutral
