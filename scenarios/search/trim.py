"""Cuts: each takes one sort of thing out of a scenario, as far as it still fails."""

import copy
from collections.abc import Callable
from dataclasses import fields
from pathlib import Path

from scenarios import device, loop
from scenarios.scenario import Scenario
from scenarios.search.bench import Bench, Json
from scenarios.worst import WorstFrame, worst_frames
from sensor_model.noise.config import NoiseConfig

StillFails = Callable[[Json, str], bool]
"""Whether a smaller scenario still fails; the text says what was taken out."""

Cut = Callable[[Json, StillFails], Json]

ANYWHERE = Path("scenario.toml")
"""Of a scenario whose files are not looked at."""

CUTS_OF_THE_END = 4
"""Ends tried between the worst frame and the last one, if the worst is not enough."""


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


def end(bench: Bench) -> Cut:
    """Return the cut that ends a scenario with the metric's worst frame, or as soon after it as it still fails."""

    def cut(document: Json, still_fails: StillFails) -> Json:
        worst = failing_frame(document, bench)
        if worst is None or worst.frame == 0:
            return document
        dt_s = worst.time_s / worst.frame
        enough, too_few = round(document["duration_s"] / dt_s), worst.frame
        tried = worst.frame + 1
        for _ in range(CUTS_OF_THE_END):
            if not too_few < tried < enough:
                break
            smaller = {**document, "duration_s": round(tried * dt_s, 3)}
            if still_fails(smaller, f"ends at {smaller['duration_s']:g} s"):
                document, enough = smaller, tried
            else:
                too_few = tried
            tried = (too_few + enough) // 2
        return document

    return cut


def failing_frame(document: Json, bench: Bench) -> WorstFrame | None:
    """Run a scenario and return the frame in which the metric is worst; None of a metric that has no frames."""
    result = loop.run(Scenario.of(document, bench.path), device.load(bench.tracker))
    return next(iter(worst_frames(result, bench.search.metric, count=1)), None)


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
