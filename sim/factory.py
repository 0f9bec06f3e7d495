"""Make a traffic source from its configuration, so that the run loop imports no simulator."""

from pathlib import Path

from sim.candidates.moment import Moment
from sim.highway.highway_config import HighwayTraffic
from sim.highway.highway_source import HighwaySource
from sim.openscenario.openscenario_config import OpenScenarioTraffic
from sim.openscenario.openscenario_source import OpenScenarioSource
from sim.process.process_source import AHEAD, ProcessSource
from sim.replay.replay_config import ReplayTraffic
from sim.replay.replay_source import ReplaySource
from sim.scripted.scripted_source import ScriptedSource, ScriptedTraffic
from sim.source import StartReport, TrafficSource
from sim.sumo.sumo_config import SumoTraffic
from sim.sumo.sumo_source import SumoSource
from sim.sumo.survey import SumoSurvey

TrafficConfig = SumoTraffic | HighwayTraffic | ScriptedTraffic | ReplayTraffic | OpenScenarioTraffic


def make_source(config: TrafficConfig, folder: Path, range_m: float) -> TrafficSource:
    """Make the traffic source of a configuration.

    Parameters
    ----------
    config
        The `[traffic]` table of a scenario.
    folder
        Folder that relative paths in `config` start from.
    range_m
        Delivery radius around the ego [m].
    """
    match config:
        case SumoTraffic():
            ahead = 0 if config.ego_control else AHEAD
            return ProcessSource(SumoSource(config, folder, range_m), "SUMO", ahead)
        case HighwayTraffic():
            return HighwaySource(config, folder, range_m)
        case ScriptedTraffic():
            return ScriptedSource(config, folder, range_m)
        case ReplayTraffic():
            return ReplaySource(config, folder, range_m)
        case OpenScenarioTraffic():
            return OpenScenarioSource(config, folder, range_m)


def watch_start(source: TrafficSource | ProcessSource[None, Moment], report: StartReport) -> None:
    """Let a source report the progress of its `reset`; those that start at once report nothing."""
    if isinstance(source, ProcessSource):
        source.report_start = report


def make_survey(config: SumoTraffic, folder: Path) -> ProcessSource[None, Moment]:
    """Make a survey of all vehicles of SUMO traffic, in a process of its own.

    Parameters
    ----------
    config, folder
        As `make_source`.
    """
    return ProcessSource(SumoSurvey(config, folder), "SUMO")
