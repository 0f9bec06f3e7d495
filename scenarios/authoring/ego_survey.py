"""Survey of SUMO traffic, for `luxloop egos` and `luxloop new`."""

from collections.abc import Iterator, Sequence
from contextlib import closing
from dataclasses import replace
from difflib import get_close_matches
from pathlib import Path

from luxloop.scenarios.authoring.traffic_input import is_unknown, read_input
from luxloop.scenarios.errors import InputError
from luxloop.scenarios.files import shipped
from luxloop.scenarios.files.scenario import DEFAULT_SEED, RigChoice, Scenario
from luxloop.scenarios.grading.grading_config import GradingConfig
from luxloop.scenarios.run import progress
from luxloop.sensor_model.rig.rig import load_rig
from luxloop.sim.candidates.candidate_log import CandidateLog
from luxloop.sim.candidates.candidates import Candidates
from luxloop.sim.candidates.moment import Moment
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
) -> tuple[Candidates, tuple[float, float]]:
    """Return the candidates for the ego, and sensor range and range of grading [m].

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
        seed = scenario.seed if seed is None else seed
    else:
        found = read_input(source, routes)
        traffic, folder, name = found.traffic, found.folder, found.name
        ranges = sensor_range(), GradingConfig().range_max_m
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
    return survey(traffic, folder, DEFAULT_SEED if seed is None else seed, window_s, *ranges), ranges
