"""Reduction of a failing disturbance to a smaller scenario that still fails; every step runs with the same seed.

Parameters return towards neutral, and unnecessary elements of the scene are removed, until no step succeeds.
"""

import copy
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from functools import partial
from itertools import chain, repeat
from pathlib import Path

from luxloop.scenarios.errors import StudyError
from luxloop.scenarios.files.scenario import Scenario
from luxloop.scenarios.grading.worst_frames import WorstFrame, worst_frames, worst_of_run
from luxloop.scenarios.run import device, loop
from luxloop.scenarios.search.evaluator import Evaluator, Json, Notify, distance, size
from luxloop.scenarios.search.optimise import Disturbance, Make, as_text
from luxloop.scenarios.study.parameter import Parameter, Value
from luxloop.scenarios.study.study_file import Study
from luxloop.sensor_model.noise.noise_config import KINDS as KINDS_OF_NOISE

NO_PATH = Path("scenario.toml")
"""Path of a scenario whose files are not read."""

FRAMES_TRIED = 5
"""Number of worst frames that are tried as the last frame."""


@dataclass(frozen=True, slots=True)
class Reduction:
    """Removal of one element of a scenario."""

    what: str
    """Description for the progress output."""
    apply: Callable[[Json], Json]
    """Returns the scenario without the element."""


def apply_all(reductions: Iterable[Reduction], document: Json) -> Json:
    """Return a scenario with all reductions applied in order."""
    for reduction in reductions:
        document = reduction.apply(document)
    return document


def actors(document: Json) -> Iterator[Reduction]:
    """Yield the removal of each scripted actor."""
    yield from _items(document, "actor")


def obstacles(document: Json) -> Iterator[Reduction]:
    """Yield the removal of each scripted obstacle."""
    yield from _items(document, "obstacle")


def noise(document: Json) -> Iterator[Reduction]:
    """Yield the removal of all enabled noise, then of each kind of noise."""
    settings = Scenario.of(document, NO_PATH).noise
    on = [kind for kind in KINDS_OF_NOISE if getattr(settings, kind).enabled]
    if len(on) > 1:
        yield Reduction("without any noise", partial(_without_noise, on))
    for kind in on:
        yield Reduction(f"without noise.{kind}", partial(_without_noise, [kind]))


KINDS = (actors, obstacles, noise)
"""Kinds of reductions in the order in which they are tried."""


def shorten(document: Json, evaluator: Evaluator, notify: Notify, fails: Callable[[Json], bool] | None = None) -> Json:
    """Return a scenario that ends with the earliest of the metric's worst frames after which it still fails.

    Other frames are not tried: a run that ends before a track is reacquired would look as if the track were lost.

    Parameters
    ----------
    document
        Failing scenario.
    evaluator
        Metric, limit and tracker.
    notify
        Receives a line of text for a successful step.
    fails
        Whether the metric violates its limit in a scenario; default: `evaluator.fails`.
    """
    fails = fails or evaluator.fails
    for worst in sorted(_worst_frames(document, evaluator, FRAMES_TRIED)):
        if worst.frame == 0:
            continue
        duration_s = round((worst.frame + 1) * worst.time_s / worst.frame, 3)
        shorter = {**document, "duration_s": duration_s}
        if duration_s < document["duration_s"] and fails(shorter):
            notify(f"ends at {duration_s:g} s")
            return shorter
    return document


def worst_frame(document: Json, evaluator: Evaluator) -> WorstFrame | None:
    """Run a scenario and return the metric's worst frame; None for a metric without values per frame."""
    return next(iter(_worst_frames(document, evaluator, count=1)), None)


def _worst_frames(document: Json, evaluator: Evaluator, count: int) -> list[WorstFrame]:
    """Run a scenario and return the worst frames of the metric; those of its actors for a metric over some actors."""
    scenario, name = Scenario.of(document, evaluator.path), evaluator.search.metric
    result = loop.run(scenario, device.load(evaluator.tracker))
    own = next((metric for metric in scenario.metric if metric.name == name and metric.of), None)
    if own is None:
        return worst_frames(result, name, count)
    return worst_of_run(result.metrics.run, own.selection, count)


def _items(document: Json, kind: str) -> Iterator[Reduction]:
    """Yield the removal of each list item, last first, so that indices of the remaining items stay valid."""
    items = document["traffic"].get(kind, [])
    for index in reversed(range(len(items))):
        yield Reduction(f"without {kind} {items[index].get('name') or index}", partial(_without_item, kind, index))


def _without_item(kind: str, index: int, document: Json) -> Json:
    smaller = copy.deepcopy(document)
    smaller["traffic"][kind].pop(index)
    return smaller


def _without_noise(kinds: list[str], document: Json) -> Json:
    """Disable kinds of noise; the document is unchanged if they are disabled already."""
    settings = Scenario.of(document, NO_PATH).noise
    off = {kind: {"enabled": False} for kind in kinds if getattr(settings, kind).enabled}
    return {**document, "noise": {**document.get("noise", {}), **off}} if off else document


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
    parameters, applied = dict(disturbance.parameters), list[Reduction]()

    def scene() -> Json:
        return apply_all(applied, make(parameters, disturbance.seed))

    while True:
        before = (dict(parameters), len(applied))
        for parameter in study.vary:
            _reduce_parameter(parameter, parameters, lambda: budget.fails(scene()), notify)
        for reduction in (reduction for kind in KINDS for reduction in kind(scene())):
            smaller = reduction.apply(scene())
            if smaller != scene() and budget.fails(smaller):
                applied.append(reduction)
                notify(reduction.what)
        if before == (parameters, len(applied)):
            break
    notify(f"size reduced from {disturbance.size:.3f} to {size(study.vary, parameters):.3f}")
    shorter = shorten(scene(), evaluator, notify, budget.fails)
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
