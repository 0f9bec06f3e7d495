"""Drafts of scenarios from recordings."""

from collections.abc import Iterator

from luxloop.scenarios.authoring.draft import Draft
from luxloop.scenarios.authoring.draft_options import DraftOptions
from luxloop.scenarios.authoring.ego_survey import sensor_range
from luxloop.scenarios.authoring.traffic_input import TrafficInput
from luxloop.scenarios.authoring.type_guesses import TypeGuesses
from luxloop.scenarios.errors import InputError
from luxloop.scenarios.grading.grading_config import GradingConfig
from luxloop.sim.candidates.candidate_log import CandidateLog
from luxloop.sim.candidates.candidates import Candidates
from luxloop.sim.replay.recording_files import read_recording
from luxloop.sim.replay.recording_moments import moments
from luxloop.sim.replay.replay_config import ReplayTraffic
from luxloop.sim.source import TrafficInputError


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
        yield _draft(found, row, place, given, traffic, options, guesses, near_m)


def _draft(
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
