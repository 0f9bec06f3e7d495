"""Survey of SUMO traffic with a progress bar."""

from collections.abc import Iterator
from contextlib import closing
from pathlib import Path

from luxloop.scenarios.run import progress
from luxloop.sim.candidates.candidate_log import CandidateLog
from luxloop.sim.candidates.candidates import Candidates
from luxloop.sim.candidates.moment import Moment
from luxloop.sim.factory import make_survey
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
