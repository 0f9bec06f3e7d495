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
from luxloop.scenarios.authoring.graded_draft import GradedDraft, grade
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
OTHER_CHOICE = {
    "sumo": "choose another --ego, --want, --begin or --window, or repair the traffic",
    "highway-env": "choose another --seed or environment",
    "replay": "choose another --ego or recording",
}
"""Remedies for traffic in which limits fail, by its kind."""


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
        The source is unknown, or has no window with vehicles around an ego in which the limits of the file hold.
    OutputError
        The file exists already or is a folder, or its folder does not exist.
    TrafficError
        The traffic cannot start, or fails.
    """
    _require_new(options.out, force)
    chosen = _first_that_holds(source, _drafts(source, routes, options), options.out)
    document = chosen.draft.document()
    comments = [
        f"Written by: luxloop new {source}",
        *chosen.draft.choices,
        "The limits under [expect] are generic defaults: adapt them to the purpose of this scenario.",
    ]
    with atomic_file.create(options.out) as path:
        path.write_text(scenario_text(document, comments), encoding="utf-8")
    return chosen.draft.choices


def _first_that_holds(source: str, drafts: Iterator[Draft], out: Path) -> GradedDraft:
    """Return the first draft whose own limits hold.

    Raises
    ------
    InputError
        There is none.
    """
    graded: list[GradedDraft] = []
    for draft, rehearsal in _worthwhile(source, drafts, out):
        graded.append(grade(draft, rehearsal, out))
        if not graded[-1].failed:
            return graded[-1]
    best = min(graded, key=lambda one: len(one.failed))
    raise InputError(
        f"{source}: the limits that the file would have fail in all {len(graded)} choices of ego and window, in the "
        f"best one {', '.join(best.failed)}; {OTHER_CHOICE[best.draft.traffic['kind']]}"
    )


def _worthwhile(source: str, drafts: Iterator[Draft], out: Path) -> Iterator[tuple[Draft, Rehearsal]]:
    """Yield drafts with their rehearsals: those with enough vehicles for the whole duration, then others.

    Raises
    ------
    InputError
        No draft can be simulated, has a vehicle near the ego, or lasts for long enough.
    """
    others: list[tuple[Draft, Rehearsal]] = []
    yielded = False
    for draft in islice(drafts, TRIED):
        rehearsal = _rehearsed(draft, out)
        if rehearsal and rehearsal.complete and rehearsal.near >= ENOUGH:
            yielded = True
            yield draft, rehearsal
        elif rehearsal:
            others.append((draft, rehearsal))
    if not (yielded or others):
        raise InputError(f"{source}: no candidate for the ego could be simulated; see luxloop egos")
    others.sort(key=lambda one: _score(one[1]), reverse=True)
    if not yielded:
        draft, rehearsal = others[0]
        _require_worth(source, draft.traffic["kind"], rehearsal, len(others))
    yield from (one for one in others if one[1].near > 0 and one[1].duration_s >= SHORTEST_S)


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
            for draft in sumo_drafts(given, traffic, options):
                yield replace(draft, choices=[*draft.choices, *given.said_of_left_out()])
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
