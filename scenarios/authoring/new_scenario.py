"""A new scenario file from traffic of any kind."""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import islice
from pathlib import Path

from luxloop.scenarios.authoring.draft import Draft
from luxloop.scenarios.authoring.draft_highway import highway_drafts
from luxloop.scenarios.authoring.draft_options import DraftOptions
from luxloop.scenarios.authoring.draft_recording import recording_drafts
from luxloop.scenarios.authoring.draft_sumo import sumo_drafts
from luxloop.scenarios.authoring.rehearsal import Rehearsal, rehearse
from luxloop.scenarios.authoring.scenario_text import scenario_text
from luxloop.scenarios.authoring.traffic_input import read_input, refuse_scenario
from luxloop.scenarios.errors import InputError, OutputError
from luxloop.scenarios.files import atomic_file
from luxloop.scenarios.files.scenario import Scenario
from luxloop.sim.highway.highway_config import HighwayTraffic
from luxloop.sim.source import SimulatorFailedError
from luxloop.sim.sumo.sumo_config import SumoTraffic

TRIED = 8
"""Drafts that are rehearsed at most."""
ENOUGH = 1.0
"""Mean number of vehicles within the range of grading that is enough."""
SHORTEST_S = 3.0
"""[s] Shorter windows are refused."""
REMEDIES = {
    "sumo": "add traffic, or give a longer --window or another --begin",
    "highway-env": "write a scenario file with more vehicles in traffic.config",
    "replay": "choose another recording",
}
"""Remedies for traffic without neighbours, by its kind."""


def write_scenario(source: str, routes: Sequence[Path], options: DraftOptions, *, force: bool = False) -> list[str]:
    """Write a scenario file and return what was chosen and why, a sentence each.

    Parameters
    ----------
    source, routes
        As `luxloop.scenarios.authoring.traffic_input.read_input`.
    options
        Options of the scenario.
    force
        Replace an existing file.

    Raises
    ------
    InputError
        The source is unknown, or has no window with vehicles around an ego.
    OutputError
        The file exists already or is a folder, or its folder does not exist.
    TrafficError
        The traffic cannot start, or fails.
    """
    _require_new(options.out, force)
    best: tuple[Draft, Rehearsal] | None = None
    tried = 0
    for draft in islice(_drafts(source, routes, options), TRIED):
        rehearsal = _rehearsed(draft, options.out)
        if rehearsal is None:
            continue
        tried += 1
        if best is None or _score(rehearsal) > _score(best[1]):
            best = draft, rehearsal
        if rehearsal.complete and rehearsal.near >= ENOUGH:
            break
    if best is None:
        raise InputError(f"{source}: no candidate for the ego could be simulated; see luxloop egos")
    draft, rehearsal = best
    _require_worth(source, draft.traffic["kind"], rehearsal, tried)
    duration = draft.duration_s if rehearsal.complete else rehearsal.duration_s
    choices = [*draft.choices, _checked(rehearsal, duration)]
    document = replace(draft, duration_s=duration).document()
    comments = [
        f"Written by: luxloop new {source}",
        *choices,
        "The limits under [expect] are generic defaults, not results: adapt them to the purpose of this scenario.",
    ]
    Scenario.of(document, options.out)
    with atomic_file.create(options.out) as path:
        path.write_text(scenario_text(document, comments), encoding="utf-8")
    return choices


def _require_new(out: Path, force: bool) -> None:
    if out.suffix != ".toml":
        raise OutputError(f"--out {out}: a scenario file must end in .toml")
    if not out.parent.is_dir():
        raise OutputError(f"--out {out}: its folder does not exist")
    if out.is_dir():
        raise OutputError(f"--out {out}: is a folder; name the file to write")
    if out.exists() and not force:
        raise OutputError(f"--out {out}: exists already; give another name, or --force")


def _drafts(source: str, routes: Sequence[Path], options: DraftOptions) -> Iterator[Draft]:
    """Yield drafts of any kind of traffic, the best first."""
    refuse_scenario(source)
    given = read_input(source, routes)
    match given.traffic:
        case SumoTraffic() as traffic:
            left_out = [f"Left out: {name}." for name in given.left_out]
            for draft in sumo_drafts(given, traffic, options):
                yield replace(draft, choices=[*draft.choices, *left_out])
        case HighwayTraffic() as traffic:
            yield from highway_drafts(traffic.env, options)
        case traffic:
            yield from recording_drafts(given, traffic, options)


def _rehearsed(draft: Draft, out: Path) -> Rehearsal | None:
    """Return the rehearsal of a draft, None if the simulator failed."""
    try:
        return rehearse(Scenario.of(draft.document(), out))
    except SimulatorFailedError:
        return None


def _score(rehearsal: Rehearsal) -> tuple[bool, float]:
    """Return how good a rehearsal is: first that there are enough vehicles, then for how long."""
    return rehearsal.near >= ENOUGH, rehearsal.frames * min(rehearsal.near, ENOUGH)


def _require_worth(source: str, kind: str, rehearsal: Rehearsal, tried: int) -> None:
    """Refuse a window without vehicles, or one that is too short."""
    if rehearsal.near == 0:
        raise InputError(
            f"{source}: no vehicle comes within the range of grading of the ego (choices of ego and window: {tried}), "
            f"so that nothing could be graded; {REMEDIES[kind]}"
        )
    if rehearsal.duration_s < SHORTEST_S:
        raise InputError(f"{source}: no ego drives for {SHORTEST_S:g} s; the longest ended so: {rehearsal.end}")


def _checked(rehearsal: Rehearsal, duration_s: float) -> str:
    """Return the sentence on the check of the window."""
    few = "" if rehearsal.near >= ENOUGH else ", which is few: the limit of observations may fail"
    short = "" if rehearsal.complete else f" It is shorter than asked for, since {rehearsal.end.rstrip('.')}."
    return (
        f"Checked by playing the traffic once: {duration_s:g} s with {rehearsal.near:.1f} vehicles in the range of "
        f"grading on average{few}.{short}"
    )
