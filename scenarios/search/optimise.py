"""The hunt: optuna proposes disturbances, the smallest with which the metric fails is kept."""

from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from typing import TYPE_CHECKING, cast

from scenarios.errors import ScenarioError, StudyError
from scenarios.files.scenario import Scenario
from scenarios.run import progress
from scenarios.search.evaluator import Bench, Json
from scenarios.search.initial_trials import ends
from scenarios.search.objective import fails, score, size
from scenarios.study.parameter import Value, Vary
from scenarios.study.study_file import Study

if TYPE_CHECKING:
    import optuna

SAMPLING_SEED = 0
"""Of optuna's sampler: the same study makes the same proposals, today and tomorrow."""

Tell = Callable[[str], None]
"""Is told a line of the story."""

Make = Callable[[dict[str, Value], int], Json]
"""Makes a scenario's document of parameters and a seed."""


@dataclass(frozen=True, slots=True)
class Finding:
    """A disturbance, proposed to fail or found to."""

    parameters: dict[str, Value]
    seed: int
    size: float
    """See `objective.size`."""


def hunt(study: Study, bench: Bench, make: Make, tell: Tell) -> Finding | None:
    """Look for the smallest disturbance with which the metric fails; None if none was met.

    First nothing is disturbed: what fails then needs no search. Then one and two parameters go to the ends of their
    ranges (`tries.ends`). After that a tree-structured Parzen estimator (Bergstra et al. 2011), which has seen all
    that, proposes the parameters, with one of the study's seeds and `at_once` runs at a time: which runs these are
    depends on the answers alone, not on who runs them or in which order they end.

    Raises
    ------
    StudyError
        The undisturbed scenario is none that can be run, or does not show the metric.
    """
    neutral = Finding({vary.key: _neutral(vary) for vary in study.vary}, study.seed_list[0], 0.0)
    if _undisturbed_fails(study, bench, make, neutral):
        tell("it fails with nothing disturbed")
        return neutral
    best: Finding | None = None
    proposals = _proposals()
    for first in ends(study, bench.search.trials):
        proposals.enqueue_trial(first)
    count, at_once = bench.search.trials, bench.search.at_once
    with progress.runs(study.path.stem, count, done=1) as advance:
        for done in range(1, count, at_once):
            trials = [proposals.ask() for _ in range(min(at_once, count - done))]
            proposed = [_propose(trial, study) for trial in trials]
            for trial, one, value in zip(trials, proposed, _values(bench, make, proposed), strict=True):
                proposals.tell(trial, score(bench.search.limit, value, one.size))
                if fails(bench.search.limit, value) and (best is None or one.size < best.size):
                    best = one
                    tell(f"fails at size {one.size:.3f} with {spell(one.parameters)}, seed = {one.seed}")
            advance(len(trials))
    return best


def spell(parameters: dict[str, Value]) -> str:
    """Write parameters in a line."""
    return ", ".join(
        f"{key} = {value:.4g}" if isinstance(value, float) else f"{key} = {value}" for key, value in parameters.items()
    )


def _undisturbed_fails(study: Study, bench: Bench, make: Make, neutral: Finding) -> bool:
    try:
        document = make(neutral.parameters, neutral.seed)
        Scenario.of(document, bench.path)
    except ScenarioError as error:
        raise StudyError(f"{study.path}: with nothing disturbed: {error}") from error
    answer = bench.ask(document)
    if answer.error:
        raise StudyError(f"{study.path}: with nothing disturbed: {answer.error}")
    return fails(bench.search.limit, answer.value)


def _values(bench: Bench, make: Make, proposed: list[Finding]) -> list[float | None]:
    """Run what was proposed; what a staged scene refuses to stage shows nothing."""
    documents: dict[int, Json] = {}
    for n, one in enumerate(proposed):
        with suppress(StudyError):
            documents[n] = make(one.parameters, one.seed)
    answers = dict(zip(documents, bench.ask_all(list(documents.values())), strict=True))
    return [answers[n].value if n in answers else None for n in range(len(proposed))]


def _proposals() -> "optuna.Study":
    import optuna  # slow to import

    optuna.logging.set_verbosity(optuna.logging.WARNING)
    # A liar takes runs that are not back yet for bad ones, and so proposes unlike runs at once.
    sampler = optuna.samplers.TPESampler(seed=SAMPLING_SEED, constant_liar=True)
    return optuna.create_study(sampler=sampler)


def _propose(trial: "optuna.Trial", study: Study) -> Finding:
    parameters = {vary.key: _propose_value(trial, vary) for vary in study.vary}
    seed = trial.suggest_categorical("seed", study.seed_list)
    return Finding(parameters, seed, size(study.vary, parameters))


def _propose_value(trial: "optuna.Trial", vary: Vary) -> Value:
    if vary.values is not None:
        return cast(Value, trial.suggest_categorical(vary.key, vary.values))
    assert vary.low is not None
    assert vary.high is not None
    return trial.suggest_float(vary.key, vary.low, vary.high, log=vary.scale == "log")


def _neutral(vary: Vary) -> Value:
    assert vary.neutral is not None
    return vary.neutral
