"""Cuts: each takes one thing out of a scenario, which may then still fail."""

import copy
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, fields
from functools import partial
from pathlib import Path

from scenarios.files.scenario import Scenario
from scenarios.grading.worst_frames import WorstFrame, worst_frames
from scenarios.result import Result
from scenarios.run import device, loop
from scenarios.search.evaluator import Bench, Json
from scenarios.search.optimise import Tell
from sensor_model.noise.noise_config import NoiseConfig

ANYWHERE = Path("scenario.toml")
"""Of a scenario whose files are not looked at."""

FRAMES_TRIED = 5
"""Of the frames in which the metric is worst, for the end."""


@dataclass(frozen=True, slots=True)
class Cut:
    """One thing that a scenario can lose."""

    what: str
    """For people."""
    apply: Callable[[Json], Json]
    """Returns the scenario without it."""


def carry_out(cuts: Iterable[Cut], document: Json) -> Json:
    """Return a scenario without what was cut, in the order of the cuts."""
    for cut in cuts:
        document = cut.apply(document)
    return document


def actors(document: Json) -> Iterator[Cut]:
    """Actors of a script, one by one."""
    yield from _items(document, "actor")


def obstacles(document: Json) -> Iterator[Cut]:
    """Obstacles of a script, one by one."""
    yield from _items(document, "obstacle")


def noise(document: Json) -> Iterator[Cut]:
    """All noise that is on, then kind by kind."""
    settings = Scenario.of(document, ANYWHERE).noise
    on = [field.name for field in fields(NoiseConfig) if getattr(settings, field.name).enabled]
    if len(on) > 1:
        yield Cut("without any noise", partial(_without_noise, on))
    for kind in on:
        yield Cut(f"without noise.{kind}", partial(_without_noise, [kind]))


KINDS = (actors, obstacles, noise)
"""In the order in which they are tried."""


def end(document: Json, bench: Bench, tell: Tell) -> Json:
    """End a scenario with the first of the metric's worst frames that is enough for it to fail.

    Never with another one: a run that ends before a track comes back looks as if it had been lost.
    """
    for worst in sorted(worst_frames(_played(document, bench), bench.search.metric, FRAMES_TRIED)):
        if worst.frame == 0:
            continue
        duration_s = round((worst.frame + 1) * worst.time_s / worst.frame, 3)
        smaller = {**document, "duration_s": duration_s}
        if duration_s < document["duration_s"] and bench.fails(smaller):
            tell(f"ends at {duration_s:g} s")
            return smaller
    return document


def failing_frame(document: Json, bench: Bench) -> WorstFrame | None:
    """Run a scenario and return the frame in which the metric is worst; None of a metric that has no frames."""
    return next(iter(worst_frames(_played(document, bench), bench.search.metric, count=1)), None)


def _played(document: Json, bench: Bench) -> Result:
    return loop.run(Scenario.of(document, bench.path), device.load(bench.tracker))


def _items(document: Json, kind: str) -> Iterator[Cut]:
    """Go through a list of the traffic from its end: what is dropped then moves nothing that is still to be tried."""
    items = document["traffic"].get(kind, [])
    for index in reversed(range(len(items))):
        yield Cut(f"without {kind} {items[index].get('name') or index}", partial(_without_item, kind, index))


def _without_item(kind: str, index: int, document: Json) -> Json:
    smaller = copy.deepcopy(document)
    smaller["traffic"][kind].pop(index)
    return smaller


def _without_noise(kinds: list[str], document: Json) -> Json:
    """Switch kinds off; one that is off already stays as it is, however it is written."""
    settings = Scenario.of(document, ANYWHERE).noise
    off = {kind: {"enabled": False} for kind in kinds if getattr(settings, kind).enabled}
    return {**document, "noise": {**document.get("noise", {}), **off}} if off else document
