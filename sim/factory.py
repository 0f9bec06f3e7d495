"""Make a traffic source from its configuration, so that the run loop imports no simulator.

Only the source that is made is imported: together they take a tenth of a second, in both processes of a run.
"""

import dataclasses
from pathlib import Path
from typing import Any, Protocol

from luxloop.plugins import PluginGroup
from luxloop.sim.candidates.candidates import Moment
from luxloop.sim.highway.highway_config import HighwayTraffic
from luxloop.sim.process.process_source import AHEAD, Frame_co, ProcessSource, Start_co, SteppedSource
from luxloop.sim.replay.replay_config import ReplayTraffic
from luxloop.sim.scripted.scripted_source import ScriptedTraffic
from luxloop.sim.source import TrafficSource
from luxloop.sim.sumo.sumo_config import SumoTraffic

NAMES = {"sumo": "SUMO"}
"""Names of simulators in messages, if not the `kind`."""


class TrafficConfig(Protocol):
    """`[traffic]` table of a scenario: a frozen dataclass whose fields are its keys."""

    @property
    def kind(self) -> str:
        """Name of the entry point; its type is a `Literal` of this name, which is its default."""
        ...

    def make_source(self, folder: Path, range_m: float) -> TrafficSource:
        """Make the traffic source, and import its simulator not before.

        Parameters
        ----------
        folder
            Folder that relative paths in the table start from.
        range_m
            Delivery radius around the ego [m].
        """
        ...


def _wanted(name: str, found: Any) -> str:
    fields = {field.name: field.default for field in dataclasses.fields(found)} if _is_dataclass(found) else {}
    is_config = fields.get("kind") == name and callable(getattr(found, "make_source", None))
    return "" if is_config else f'a frozen dataclass with kind = "{name}" and a method make_source'


def _is_dataclass(found: Any) -> bool:
    return isinstance(found, type) and dataclasses.is_dataclass(found)


KINDS = PluginGroup(
    "luxloop.traffic",
    _wanted,
    core={
        "sumo": SumoTraffic, "highway-env": HighwayTraffic, "scripted": ScriptedTraffic, "replay": ReplayTraffic,
    },
)  # fmt: skip
"""Dataclasses of `[traffic]` tables by `kind`, each a `TrafficConfig`."""


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
    source = config.make_source(folder, range_m)
    if apart and isinstance(config, SumoTraffic):
        return ProcessSource(source, NAMES["sumo"], 0 if config.ego_control else AHEAD)
    return source


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
