"""Draft of a scenario file: its sources, options, content and default limits."""

import math
import os
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from luxloop.scenarios.authoring.ego_survey import WINDOW_S, sensor_range, survey
from luxloop.scenarios.authoring.traffic_input import TrafficInput
from luxloop.scenarios.errors import InputError
from luxloop.scenarios.grading.grading_config import GradingConfig
from luxloop.sim.candidates.candidate_log import CandidateLog
from luxloop.sim.candidates.candidates import Candidates
from luxloop.sim.candidates.want import Want
from luxloop.sim.highway.environment import make
from luxloop.sim.highway.highway_config import MOTORIST
from luxloop.sim.replay.recording import KIND_BY_NAME, ReplayType
from luxloop.sim.replay.recording_files import read_recording
from luxloop.sim.replay.recording_moments import moments
from luxloop.sim.replay.replay_config import ReplayTraffic
from luxloop.sim.scripted.script import KindName
from luxloop.sim.source import TrafficInputError
from luxloop.sim.sumo.sumo_config import SumoTraffic

_Paths = TypeVar("_Paths", str, list[str])


@dataclass(frozen=True, slots=True)
class DraftOptions:
    """Options of a new scenario."""

    out: Path
    """The scenario file."""
    duration_s: float
    seed: int
    want: Want
    ego: str
    """Id of the ego; empty to choose it."""
    begin_s: float | None
    """[s] Start of SUMO's clock."""
    window_s: float
    """[s] Time that is surveyed."""

    def refuse(self, why: str, *names: str) -> None:
        """Refuse options that some traffic has no use for.

        Parameters
        ----------
        why
            End of the message.
        names
            The options: `--ego`, `--begin`, `--want`, `--window`.

        Raises
        ------
        InputError
            One of them is not at its default.
        """
        changed = {
            "--ego": bool(self.ego),
            "--begin": self.begin_s is not None,
            "--want": self.want is not Want.NEIGHBOURS,
            "--window": self.window_s != WINDOW_S,
        }
        given = [name for name in names if changed[name]]
        if given:
            raise InputError(f"{' and '.join(given)}: {why}")

    def moved(self, names: _Paths, folder: Path) -> _Paths:
        """Return file names relative to `folder` as names relative to the scenario file."""
        if isinstance(names, str):
            return os.path.relpath(folder / names, self.out.parent) if names else names
        return [self.moved(name, folder) for name in names]


SCAN_RATE_HZ = 12.5
"""Rate of the default rig."""
SWITCH_PERIOD_S = 5.0
"""[s] Time in which one id switch is tolerated."""


def default_limits(duration_s: float) -> dict[str, dict[str, Any]]:
    """Return the table `[expect]` for a duration [s]."""
    return {
        "sim.ego_collisions": {
            "max": 0,
            "unit": "count",
            "need": "the ground truth is possible: no tracker is right about a vehicle inside the ego",
        },
        "dataset.observations": {
            "min": round(0.5 * SCAN_RATE_HZ * duration_s),
            "unit": "count",
            "need": "a graded vehicle in every second scan on average, else the scene shows little",
        },
        "segmentation.missed_rate": {
            "max": 0.02,
            "unit": "1",
            "need": "a vehicle without a segment is invisible to the planner",
        },
        "track.hota": {
            "min": 0.5,
            "unit": "1",
            "need": "a minimum, below which tracks are useless for driving; the goal for traffic is 0.75",
        },
        "track.id_switches_in_view": {
            "max": math.ceil(duration_s / SWITCH_PERIOD_S),
            "unit": "count",
            "need": f"an id switch restarts a prediction: at most once in {SWITCH_PERIOD_S:g} s",
        },
    }


@dataclass(frozen=True, slots=True)
class Draft:
    """Choice of traffic, ego and window, before it is checked."""

    description: str
    traffic: dict[str, Any]
    """The table `[traffic]`."""
    duration_s: float
    seed: int
    choices: list[str] = field(default_factory=list)
    """Choices with their reasons, a sentence each."""

    def document(self) -> dict[str, Any]:
        """Return the content of the scenario file."""
        return {
            "description": self.description,
            "reason": "Written by luxloop new. Say here where the situation occurs, and which errors it reveals.",
            "seed": self.seed,
            "duration_s": self.duration_s,
            "traffic": self.traffic,
            "expect": default_limits(self.duration_s),
        }


WORDS: dict[str, KindName] = {
    "semi": "trailer-truck",
    "trailer": "trailer-truck",
    "motorcycle": "motorcycle",
    "motorbike": "motorcycle",
    "moped": "motorcycle",
    "bicycle": "bicycle",
    "bike": "bicycle",
    "cyclist": "bicycle",
    "ped": "pedestrian",
    "person": "pedestrian",
    "bus": "bus",
    "coach": "bus",
    "tram": "bus",
    "rail": "bus",
    "train": "bus",
    "truck": "truck",
    "lorry": "truck",
    "delivery": "van",
    "van": "van",
    "emergency": "van",
}
"""Kind by a part of a type's name; the first match counts. Other types are cars."""


class TypeGuesses(Mapping[str, ReplayType]):
    """Mapping from any unknown type to a guess; it remembers the guesses."""

    def __init__(self) -> None:
        self.made: dict[str, ReplayType] = {}

    def __contains__(self, word: object) -> bool:
        """Return True for names that are neither kinds nor SUMO's built-in types."""
        return isinstance(word, str) and word not in KIND_BY_NAME and not word.startswith("DEFAULT_")

    def __getitem__(self, word: str) -> ReplayType:
        if word not in self.made:
            kind: KindName = next((kind for part, kind in WORDS.items() if part in word.lower()), "car")
            self.made[word] = ReplayType(kind)
        return self.made[word]

    def __iter__(self) -> Iterator[str]:
        return iter(self.made)

    def __len__(self) -> int:
        return len(self.made)


def recording_drafts(given: TrafficInput, traffic: ReplayTraffic, options: DraftOptions) -> Iterator[Draft]:
    """Yield drafts, the best candidate first.

    Raises
    ------
    InputError
        The recording has no vehicle that can carry the rig, or not the one that was asked for, or a window was given.
    """
    options.refuse("a recording is surveyed as a whole; leave it out", "--begin", "--window")
    guesses, near_m = TypeGuesses(), GradingConfig().range_max_m
    try:
        recording = read_recording(given.folder / traffic.file, guesses)
        log = CandidateLog(sensor_range(), near_m)
        for moment in moments(recording, traffic.gap_s):
            log.add(moment)
    except TrafficInputError as error:
        raise InputError(f"{given.folder / traffic.file}: {error}") from error
    found = log.candidates()
    rows = [int(row) for row in found.order(options.want, options.duration_s) if not found.bodies[row].rejected]
    if options.ego:
        rows = [row for row in rows if found.bodies[row].name == options.ego]
    if not rows:
        missing = f'no vehicle "{options.ego}"' if options.ego else "no vehicle"
        raise InputError(f"{given.folder / traffic.file}: has {missing} that can carry the rig")
    for place, row in enumerate(rows):
        yield _recording_draft(found, row, place, given, traffic, options, guesses, near_m)


def _recording_draft(
    found: Candidates,
    row: int,
    place: int,
    given: TrafficInput,
    traffic: ReplayTraffic,
    options: DraftOptions,
    guesses: TypeGuesses,
    near_m: float,
) -> Draft:
    body = found.bodies[row]
    start, near = found.busiest_start(row, options.duration_s)
    types = {name: {"kind": guess.kind} for name, guess in guesses.made.items()}
    guessed = ", ".join(f"{name} is a {guess['kind']}" for name, guess in types.items())
    return Draft(
        description=f"The recording {given.name} around the vehicle {body.name}.",
        traffic={
            "kind": "replay",
            "file": options.moved(traffic.file, given.folder),
            "ego": body.name,
            "begin_s": round(start, 3),
            **({"types": types} if types else {}),
        },
        duration_s=options.duration_s,
        seed=options.seed,
        choices=[
            f'Ego: "{body.name}" ({body.vehicle_class}), '
            + ("as asked for" if options.ego else f"number {place + 1} of the candidates by {options.want}")
            + f"; it stays {found.stay_s[row]:.0f} s and drives {found.distance_m[row]:.0f} m.",
            f"Window: from {start:.1f} s of the recording, with {near:.1f} vehicles within {near_m:g} m on average.",
            *([f"Types are guessed from their names, and sizes are those of the kinds: {guessed}."] if types else []),
        ],
    )


MARGIN_S = 2.0
"""[s] A candidate stays for longer than the scenario by this, since the survey has moments of one second."""


def sumo_drafts(given: TrafficInput, traffic: SumoTraffic, options: DraftOptions) -> Iterator[Draft]:
    """Yield drafts, the best candidate first.

    Raises
    ------
    InputError
        No vehicle enters that can carry the rig, or not the one that was asked for.
    """
    if options.begin_s is not None:
        traffic = replace(traffic, begin_s=options.begin_s)
    near_m = GradingConfig().range_max_m
    found = survey(traffic, given.folder, options.seed, options.window_s, sensor_range(), near_m)
    for place, row in enumerate(_sumo_rows(found, given.name, options)):
        yield _sumo_draft(found, row, place, given, traffic, options, near_m)


def _sumo_rows(found: Candidates, name: str, options: DraftOptions) -> list[int]:
    """Return the candidates in their order, or the one that was asked for."""
    if not len(found):
        raise InputError(
            f"{name}: no vehicle enters within {options.window_s:g} s, and people cannot carry the rig; if vehicles "
            "depart later, give --begin shortly before their departure, or a longer --window"
        )
    rows = [int(row) for row in found.order(options.want, options.duration_s + MARGIN_S)]
    if options.ego:
        named = [row for row in rows if found.bodies[row].name == options.ego]
        if not named:
            raise InputError(f"--ego {options.ego}: did not enter within {options.window_s:g} s; see luxloop egos")
        rows = named
    suitable = [row for row in rows if not found.bodies[row].rejected]
    if not suitable:
        classes, counts = np.unique([found.bodies[row].vehicle_class for row in rows], return_counts=True)
        seen = ", ".join(f"{count} {name}" for name, count in zip(classes, counts, strict=True))
        raise InputError(f"{name}: the vehicles that enter within {options.window_s:g} s ({seen}) cannot carry the rig")
    return suitable


def _sumo_draft(
    found: Candidates,
    row: int,
    place: int,
    given: TrafficInput,
    traffic: SumoTraffic,
    options: DraftOptions,
    near_m: float,
) -> Draft:
    body = found.bodies[row]
    start, near = found.busiest_start(row, options.duration_s)
    later = start > found.enters_s[row] + 0.5 * MARGIN_S
    keys = ("config",) if traffic.config else ("net", "routes", "additional")
    table: dict[str, Any] = {
        "kind": "sumo",
        **{key: options.moved(getattr(traffic, key), given.folder) for key in keys},
    }
    table = {key: value for key, value in table.items() if value}
    table |= {"ego": f"vehicle:{body.name}"}
    table |= {"begin_s": options.begin_s} if options.begin_s is not None else {}
    table |= {"max_wait_s": options.window_s} if options.window_s > WINDOW_S else {}
    table |= {"frames_from_s": round(start, 3)} if later else {}
    count = int(found.suitable.sum())
    return Draft(
        description=f"Traffic of {given.name} by SUMO around the vehicle {body.name}.",
        traffic=table,
        duration_s=options.duration_s,
        seed=options.seed,
        choices=[
            f'Ego: vehicle "{body.name}" ({body.vehicle_class}), '
            + (
                "as asked for"
                if options.ego
                else f"number {place + 1} of {count} candidates by {options.want} "
                f"({options.window_s:g} s were surveyed; luxloop egos lists them)"
            )
            + ".",
            f"It stays {found.stay_s[row]:.0f} s, drives {found.distance_m[row]:.0f} m, turns in "
            f"{found.turns[row]:.0%} of the time and stops {found.stops[row]} times; {found.occlusion[row]:.0%} of its "
            "neighbours are behind others.",
            f"Window: from {start:.0f} s on SUMO's clock, {'the busiest of its stay' if later else 'where it enters'}, "
            f"with {near:.1f} vehicles within {near_m:g} m on average.",
        ],
    )


SEEDS = 8
"""Seeds that are tried: in some, the ego crashes soon."""


def highway_drafts(env: str, options: DraftOptions) -> Iterator[Draft]:
    """Yield drafts with one seed after the other.

    Raises
    ------
    InputError
        An ego or a window was asked for.
    TrafficInputError
        There is no such environment.
    """
    options.refuse(
        "an environment of highway-env has its first agent as ego, from its start on; leave it out",
        *("--ego", "--begin", "--want", "--window"),
    )
    environment = make(env, {})
    limited = "other_vehicles_type" in environment.config
    environment.close()
    table: dict[str, Any] = {"kind": "highway-env", "env": env}
    table |= {"config": {"other_vehicles_type": MOTORIST}} if limited else {}
    drivers = (
        "Drivers: Motorist, which turns within the limits of tyres; highway-env's own do not."
        if limited
        else "Drivers: the environment does not let them be chosen."
    )
    for place in range(SEEDS):
        seed = options.seed + place
        yield Draft(
            description=f"highway-env's {env}.",
            traffic=table,
            duration_s=options.duration_s,
            seed=seed,
            choices=["Ego: the first agent, driven like the other vehicles.", drivers, f"Seed {seed}."],
        )
