"""Cuts: each takes one sort of thing out of a scenario, as far as it still fails."""

import copy
from collections.abc import Callable
from dataclasses import fields
from pathlib import Path

from scenarios import device, loop
from scenarios.result import Result
from scenarios.scenario import Scenario
from scenarios.search.bench import Bench, Json
from scenarios.worst import WorstFrame, worst_frames
from sensor_model.noise.config import NoiseConfig

StillFails = Callable[[Json, str], bool]
"""Whether a smaller scenario still fails; the text says what was taken out."""

ANYWHERE = Path("scenario.toml")
"""Of a scenario whose files are not looked at."""

FRAMES_TRIED = 5
"""Of the frames in which the metric is worst, for the end."""


def actors(document: Json, still_fails: StillFails) -> Json:
    """Drop actors of a script one by one."""
    return _without_items(document, "actor", still_fails)


def obstacles(document: Json, still_fails: StillFails) -> Json:
    """Drop obstacles one by one."""
    return _without_items(document, "obstacle", still_fails)


def noise(document: Json, still_fails: StillFails) -> Json:
    """Switch all noise off, or else kind by kind."""
    settings = Scenario.of(document, ANYWHERE).noise
    on = [field.name for field in fields(NoiseConfig) if getattr(settings, field.name).enabled]
    if not on:
        return document
    if len(on) > 1 and still_fails(silent := _without_noise(document, on), "without any noise"):
        return silent
    for kind in on:
        smaller = _without_noise(document, [kind])
        if still_fails(smaller, f"without noise.{kind}"):
            document = smaller
    return document


def end(document: Json, bench: Bench, still_fails: StillFails) -> Json:
    """End a scenario with the first of the metric's worst frames that is enough for it to fail.

    Never with another one: a run that ends before a track comes back looks as if it had been lost.
    """
    for worst in sorted(worst_frames(_played(document, bench), bench.search.metric, FRAMES_TRIED)):
        if worst.frame == 0:
            continue
        duration_s = round((worst.frame + 1) * worst.time_s / worst.frame, 3)
        smaller = {**document, "duration_s": duration_s}
        if duration_s < document["duration_s"] and still_fails(smaller, f"ends at {duration_s:g} s"):
            return smaller
    return document


def failing_frame(document: Json, bench: Bench) -> WorstFrame | None:
    """Run a scenario and return the frame in which the metric is worst; None of a metric that has no frames."""
    return next(iter(worst_frames(_played(document, bench), bench.search.metric, count=1)), None)


def _played(document: Json, bench: Bench) -> Result:
    return loop.run(Scenario.of(document, bench.path), device.load(bench.tracker))


def _without_items(document: Json, kind: str, still_fails: StillFails) -> Json:
    """Go through a list of the traffic from its end: what is dropped then moves nothing that is still to be tried."""
    for index in reversed(range(len(document["traffic"].get(kind, [])))):
        smaller = copy.deepcopy(document)
        item = smaller["traffic"][kind].pop(index)
        if still_fails(smaller, f"without {kind} {item.get('name') or index}"):
            document = smaller
    return document


def _without_noise(document: Json, kinds: list[str]) -> Json:
    return {**document, "noise": {**document.get("noise", {}), **{kind: {"enabled": False} for kind in kinds}}}
