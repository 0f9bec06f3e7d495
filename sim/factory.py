"""Make a traffic source from its configuration, so that the run loop imports no simulator.

Only the source that is made is imported: together they take a tenth of a second, in both processes of a run.
"""

from pathlib import Path

from luxloop.sim.candidates.moment import Moment
from luxloop.sim.highway.highway_config import HighwayTraffic
from luxloop.sim.openscenario.openscenario_config import OpenScenarioTraffic
from luxloop.sim.process.process_source import AHEAD, Frame_co, ProcessSource, Start_co, SteppedSource
from luxloop.sim.replay.replay_config import ReplayTraffic
from luxloop.sim.scripted.scripted_source import ScriptedSource, ScriptedTraffic
from luxloop.sim.source import TrafficSource
from luxloop.sim.sumo.sumo_config import SumoTraffic

TrafficConfig = SumoTraffic | HighwayTraffic | ScriptedTraffic | ReplayTraffic | OpenScenarioTraffic

NAMES = {"sumo": "SUMO"}
"""Names of simulators in messages, if not the `kind`."""


def make_source(config: TrafficConfig, folder: Path, range_m: float, apart: bool = True) -> TrafficSource:
    """Make the traffic source of a configuration.

    Parameters
    ----------
    config
        The `[traffic]` table of a scenario.
    folder
        Folder that relative paths in `config` start from.
    range_m
        Delivery radius around the ego [m].
    apart
        True to run SUMO in a worker process; False for a source that `run_ahead` takes to one.
    """
    match config:
        case SumoTraffic():
            from luxloop.sim.sumo.sumo_source import SumoSource

            source = SumoSource(config, folder, range_m)
            return ProcessSource(source, NAMES["sumo"], 0 if config.ego_control else AHEAD) if apart else source
        case HighwayTraffic():
            from luxloop.sim.highway.highway_source import HighwaySource

            return HighwaySource(config, folder, range_m)
        case ScriptedTraffic():
            return ScriptedSource(config, folder, range_m)
        case ReplayTraffic():
            from luxloop.sim.replay.replay_source import ReplaySource

            return ReplaySource(config, folder, range_m)
        case OpenScenarioTraffic():
            from luxloop.sim.openscenario.openscenario_source import OpenScenarioSource

            return OpenScenarioSource(config, folder, range_m)


def run_ahead(source: SteppedSource[Start_co, Frame_co], config: TrafficConfig) -> ProcessSource[Start_co, Frame_co]:
    """Run a source and what it feeds, such as LIDARs, in a worker process, a few frames ahead of this one.

    Parameters
    ----------
    source
        The source, not yet reset.
    config
        The `[traffic]` table, which names the simulator in messages.
    """
    return ProcessSource(source, NAMES.get(config.kind, config.kind))


def make_survey(config: SumoTraffic, folder: Path) -> ProcessSource[None, Moment]:
    """Make a survey of all vehicles of SUMO traffic, in a process of its own.

    Parameters
    ----------
    config, folder
        As `make_source`.
    """
    from luxloop.sim.sumo.survey import SumoSurvey

    return ProcessSource(SumoSurvey(config, folder), NAMES["sumo"])
