"""A new scenario file from traffic of any kind."""

import json
import re
import textwrap
import tomllib
from collections.abc import Iterable, Iterator, Sequence
from contextlib import closing
from dataclasses import dataclass, replace
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np

from luxloop.scenarios.authoring.draft import Draft, DraftOptions, highway_drafts, recording_drafts, sumo_drafts
from luxloop.scenarios.authoring.ego_survey import sensor_range
from luxloop.scenarios.authoring.traffic_input import read_input, refuse_scenario
from luxloop.scenarios.errors import InputError, OutputError
from luxloop.scenarios.files import atomic_file
from luxloop.scenarios.files.expect import Check, check
from luxloop.scenarios.files.scenario import Scenario
from luxloop.scenarios.report.cells import value_of
from luxloop.scenarios.run import device, loop, progress
from luxloop.sim.factory import make_source
from luxloop.sim.highway.highway_config import HighwayTraffic
from luxloop.sim.source import SimulatorFailedError, TrafficEndedError, watch_start
from luxloop.sim.sumo.sumo_config import SumoTraffic
from luxloop.sim.world import VEHICLE_KINDS, WorldFrame

WIDTH = 118
"""Characters of a comment line."""
_BARE = re.compile(r"[A-Za-z0-9_-]+")


def scenario_text(document: dict[str, Any], comments: Iterable[str]) -> str:
    """Return a scenario file with comments at its head.

    Parameters
    ----------
    document
        Content: values, and tables of values.
    comments
        Paragraphs.
    """
    lines = [f"# {line}" for comment in comments for line in textwrap.wrap(" ".join(comment.split()), WIDTH)]
    tables = {key: value for key, value in document.items() if isinstance(value, dict)}
    lines += [f"{_key(key)} = {_value(value)}" for key, value in document.items() if key not in tables]
    for name, table in tables.items():
        lines += ["", f"[{_key(name)}]", *(f"{_key(key)} = {_value(value)}" for key, value in table.items())]
    text = "\n".join(lines) + "\n"
    assert tomllib.loads(text) == document
    return text


def _key(name: str) -> str:
    return name if _BARE.fullmatch(name) else _string(name)


def _value(value: Any) -> str:
    """Return a value in TOML."""
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{_key(key)} = {_value(item)}" for key, item in value.items()) + " }"
    if isinstance(value, list):
        return "[" + ", ".join(map(_value, value)) + "]"
    return _string(value) if isinstance(value, str) else json.dumps(value)


def _string(text: str) -> str:
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")


_KINDS = np.array(sorted(VEHICLE_KINDS))


@dataclass(frozen=True, slots=True)
class Rehearsal:
    """Course of the traffic of a draft."""

    frames: int
    """Frames until the end."""
    duration_s: float
    """[s] Their duration, rounded down to 0.1 s."""
    near: float
    """Mean number of vehicles within the range of grading."""
    end: str
    """Reason why it ended early; empty if it did not."""
    is_hit: bool = False
    """True if it ended by a collision of the ego, which a shorter run would not show."""

    @property
    def complete(self) -> bool:
        """True if it lasted for the duration of the draft."""
        return not self.end


def rehearse(scenario: Scenario) -> Rehearsal:
    """Play the traffic of a scenario once.

    Raises
    ------
    TrafficError
        The traffic cannot start, or fails.
    """
    near, end, is_hit = [], "", False
    with closing(make_source(scenario.traffic, scenario.folder, sensor_range(scenario.rig, scenario.folder))) as source:
        with progress.start("rehearsal") as report:
            watch_start(source, report)
            source.reset(scenario.seed)
        count = max(1, round(scenario.duration_s / source.dt))
        try:
            for _ in progress.frames(count, source.dt, "rehearsal"):
                near.append(_near(source.step(), scenario.grading.range_max_m))
        except TrafficEndedError as error:
            end, is_hit = str(error), bool(error.collisions)
        seconds = len(near) * source.dt
    mean = float(np.mean(near)) if near else 0.0
    return Rehearsal(len(near), np.floor(10 * seconds + 1e-6) / 10, mean, end, is_hit)


def _near(frame: WorldFrame, range_m: float) -> int:
    offset = frame.actors.pose_world[:, :2] - frame.ego.pose_world[:2]
    near = np.hypot(*offset.T) <= range_m
    return int((near & np.isin(frame.actors.kind, _KINDS)).sum())


@dataclass(frozen=True, slots=True)
class GradedDraft:
    """Draft with the limits that fail in its run."""

    draft: Draft
    """With its final duration, and a sentence on the check."""
    failed: list[str]
    """Limits that fail, with metric, value and limit; also an early end."""


def grade(draft: Draft, rehearsal: Rehearsal, out: Path) -> GradedDraft:
    """Run a draft with the shipped tracker, as long as its traffic lasts, and grade it as `luxloop run` does.

    Raises
    ------
    TrafficError
        The traffic cannot start, or fails.
    """
    if rehearsal.is_hit:
        return GradedDraft(draft, [f"sim.ego_collisions = 1, limit <= 0 ({rehearsal.end})"])
    draft = draft if rehearsal.complete else replace(draft, duration_s=rehearsal.duration_s)
    scenario = Scenario.of(draft.document(), out)
    result = loop.run(scenario, device.load(device.SHIPPED))
    checks = check(result.metrics, scenario.expect, result.config["device"])
    failed = [_line(each) for each in checks if each.outcome == "failed"]
    if not result.complete:
        failed.append(f"its duration ({result.ended_early})")
    return GradedDraft(replace(draft, choices=[*draft.choices, _sentence(draft, rehearsal, checks)]), failed)


def _line(failed: Check) -> str:
    value = failed.metric.value
    shown = value_of(failed.metric) if value is None else f"{value:.4g}"  # three digits may equal the limit
    return f"{failed.name} = {shown}, limit {failed.limit}"


def _sentence(draft: Draft, rehearsal: Rehearsal, checks: list[Check]) -> str:
    """Return the sentence on the check of a draft whose limits hold."""
    values = ", ".join(f"{each.name} {value_of(each.metric)}" for each in checks)
    short = "" if rehearsal.complete else f" It is shorter than asked for, since {rehearsal.end.rstrip('.')}."
    return (
        f"Checked by a run of the shipped tracker: {draft.duration_s:g} s with {rehearsal.near:.1f} vehicles in the "
        f"range of grading on average; all limits hold ({values}).{short}"
    )


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
