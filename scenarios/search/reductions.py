"""Reductions of a scenario: each removes one element, after which the metric may still fail."""

import copy
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

from luxloop.scenarios.files.scenario import Scenario
from luxloop.scenarios.grading.worst_frames import WorstFrame, worst_frames
from luxloop.scenarios.metrics.given_figures import restricted
from luxloop.scenarios.run import device, loop
from luxloop.scenarios.search.evaluator import Evaluator, Json, Notify
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
    of_actors = restricted(result.metrics.run, own.selection.filters).tables
    return worst_frames(replace(result, tables=dict(of_actors)), own.of, count)


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
