"""Survey of SUMO traffic for `luxloop egos` and `luxloop new`, and the table of candidates."""

from collections.abc import Iterator, Sequence
from contextlib import closing
from dataclasses import dataclass, replace
from difflib import get_close_matches
from pathlib import Path
from typing import Any

from luxloop.scenarios.authoring.traffic_input import is_unknown, read_input
from luxloop.scenarios.document.document import Answer, Block, Document, Paragraph, Section, Style, Table, code
from luxloop.scenarios.errors import InputError
from luxloop.scenarios.files import shipped
from luxloop.scenarios.files.scenario import DEFAULT_SEED, RigChoice, Scenario
from luxloop.scenarios.grading.grading_config import GradingConfig
from luxloop.scenarios.report.cells import counted
from luxloop.scenarios.run import progress
from luxloop.sensor_model.rig.rig import load_rig
from luxloop.sim.candidates.candidate_log import CandidateLog
from luxloop.sim.candidates.candidates import Candidates, Moment
from luxloop.sim.candidates.want import Want
from luxloop.sim.factory import make_survey
from luxloop.sim.highway.environment import environments
from luxloop.sim.process.process_source import ProcessSource
from luxloop.sim.source import TrafficEndedError, watch_start
from luxloop.sim.sumo.sumo_config import SumoTraffic

WINDOW_S = 300.0
"""[s] Default time that is surveyed, which is the default of `traffic.max_wait_s`."""


def survey(traffic: SumoTraffic, folder: Path, seed: int, window_s: float, range_m: float, near_m: float) -> Candidates:
    """Return the candidates for the ego in SUMO traffic, which runs once, in a process of its own.

    Parameters
    ----------
    traffic, folder
        As `luxloop.sim.factory.make_source`.
    seed
        Seed of the traffic.
    window_s
        Simulated time [s].
    range_m, near_m
        Sensor range and range of grading [m].

    Raises
    ------
    TrafficError
        The input is invalid, or SUMO failed.
    """
    log = CandidateLog(range_m, near_m)
    with closing(make_survey(traffic, folder)) as source:
        with progress.start("survey") as report:
            watch_start(source, report)
            source.reset(seed)
        count = max(1, round(window_s / source.dt))
        for moment in progress.steps("survey", count, f"moments of {source.dt:g} s", _moments(source, count)):
            log.add(moment)
    return log.candidates()


def _moments(source: ProcessSource[None, Moment], count: int) -> Iterator[Moment]:
    """Yield moments until the traffic ends."""
    for _ in range(count):
        try:
            yield source.step()
        except TrafficEndedError:
            return


DEFAULT_RIG = RigChoice(name="srx_six_lux")


@dataclass(frozen=True, slots=True)
class SourceSurvey:
    """Candidates for the ego in the traffic that a user names."""

    candidates: Candidates
    sensor_range_m: float
    grading_range_m: float
    left_out: list[str]
    """A sentence about each file of the traffic that was not taken."""


def sensor_range(rig: RigChoice = DEFAULT_RIG, folder: Path = Path()) -> float:
    """Return the longest range of the LIDARs of a rig [m].

    Raises
    ------
    RigError
        There is no such rig.
    """
    return max(mount.model.range_max_m for mount in load_rig(str(rig), folder).mounts)


def survey_source(
    source: str, routes: Sequence[Path], begin_s: float | None, window_s: float, seed: int | None
) -> SourceSurvey:
    """Survey the traffic of a source.

    Parameters
    ----------
    source
        The traffic as in `luxloop.scenarios.authoring.traffic_input`, or a scenario.
    routes
        Route files of a net, or folders of them.
    begin_s
        Start of SUMO's clock [s], None for the default.
    window_s
        Simulated time [s].
    seed
        Seed of the traffic, None for the default.

    Raises
    ------
    InputError
        It is no SUMO traffic.
    TrafficError
        The input is invalid, or SUMO failed.
    """
    if source.endswith(".toml") or source in shipped.paths():
        if routes:
            raise InputError(f"--routes {routes[0]}: {source} is a scenario and names its own routes; leave it out")
        scenario = Scenario.load(shipped.find(source))
        traffic, folder, name = scenario.traffic, scenario.folder, scenario.name
        ranges = sensor_range(scenario.rig, folder), scenario.grading.range_max_m
        seed, left_out = scenario.seed if seed is None else seed, []
    else:
        found = read_input(source, routes)
        traffic, folder, name = found.traffic, found.folder, found.name
        ranges, left_out = (sensor_range(), GradingConfig().range_max_m), found.said_of_left_out()
    if is_unknown(traffic):
        close = get_close_matches(source, [*shipped.paths(), *environments()], n=3, cutoff=0.4)
        hint = f"did you mean {', '.join(close)}?" if close else "luxloop list has the scenarios"
        raise InputError(f"{source}: no such file, scenario or environment of highway-env; {hint}")
    if not isinstance(traffic, SumoTraffic):
        raise InputError(
            f"{name}: only SUMO's traffic has candidates for the ego, this is {traffic.kind}; the ego of highway-env "
            "is its first agent, and luxloop new chooses that of a recording"
        )
    if begin_s is not None:
        traffic = replace(traffic, begin_s=begin_s)
    candidates = survey(traffic, folder, DEFAULT_SEED if seed is None else seed, window_s, *ranges)
    return SourceSurvey(candidates, *ranges, left_out)


NOTE = (
    "Other vehicles are counted in two ranges. + after a stay: still there at the end of the survey. "
    "Occluded: share of near vehicles behind another one, seen from above."
)
UNITS = {
    "enters_s": "s", "stay_s": "s", "distance_m": "m", "neighbours": "1", "near": "1", "turns": "1", "stops": "count",
    "occlusion": "1",
}  # fmt: skip
"""Columns with units."""
WANTED_COLUMN = {
    Want.NEIGHBOURS: "near", Want.TURNS: "turns", Want.STOPS: "stops", Want.OCCLUSION: "occlusion", Want.LONG: "stay_s"
}  # fmt: skip


def candidates_document(survey: SourceSurvey, rows: list[int], want: Want, source: str) -> Document:
    """Return the candidates `rows` of a source, in this order, and how to take the first of them."""
    found = survey.candidates
    rejected = int((~found.suitable).sum())
    more = f", {rejected} of which cannot carry the rig" if rejected else ""
    blocks: list[Block] = [_table(survey, rows, want), Paragraph(NOTE, "dim")] if rows else []
    blocks += map(Paragraph, survey.left_out)
    if rows and not found.bodies[rows[0]].rejected:
        ego = f'ego = "vehicle:{found.bodies[rows[0]].name}"'
        blocks.append(Paragraph(("For a scenario: ", code(f"{ego}, or luxloop new {source} --out FILE.toml"))))
    answer = Answer(f"{counted(len(found), 'vehicle')} entered{more}")
    return Document(f"Candidates of {source}", answer, [], [Section("candidates", "Candidates", blocks)])


def _table(survey: SourceSurvey, rows: list[int], want: Want) -> Table:
    sensor_m, grading_m = survey.sensor_range_m, survey.grading_range_m
    heads = {
        "ego": "vehicle", "class": "class", "enters_s": "enters\n[s]", "stay_s": "stays\n[s]",
        "distance_m": "drives\n[m]",
        "neighbours": f"in\n{sensor_m:g} m", "near": f"in\n{grading_m:g} m", "turns": "turns\n[%]", "stops": "stops",
        "occlusion": "occluded\n[%]", "suitable": "ego?",
    }  # fmt: skip
    table = Table("")
    for name, head in heads.items():
        words = name in ("ego", "class", "suitable")
        style: Style = "bold" if name in (WANTED_COLUMN[want], "ego") else ""
        table.add_column(head, justify="left" if words else "right", style=style, no_wrap=True)
    for row in rows:
        table.add_row(*_cells(document(survey.candidates, row)))
    return table


def document(found: Candidates, row: int) -> dict[str, Any]:
    """Return a candidate for `--json`."""
    body = found.bodies[row]
    figures = {name: round(float(getattr(found, name)[row]), 3) for name in UNITS}
    return {
        "ego": body.name,
        "class": body.vehicle_class,
        "suitable": not body.rejected,
        **figures,
        "stops": int(found.stops[row]),
        "leaves": bool(found.leaves[row]),
    }


def _cells(entry: dict[str, Any]) -> list[str]:
    more = "" if entry["leaves"] else "+"
    return [
        entry["ego"],
        entry["class"],
        f"{entry['enters_s']:.0f}",
        f"{entry['stay_s']:.0f}{more}",
        f"{entry['distance_m']:.0f}",
        f"{entry['neighbours']:.1f}",
        f"{entry['near']:.1f}",
        f"{100 * entry['turns']:.0f}",
        f"{entry['stops']}",
        f"{100 * entry['occlusion']:.0f}",
        "yes" if entry["suitable"] else "no",
    ]
