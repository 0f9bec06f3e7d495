"""Traffic by an OpenSCENARIO file."""

import math
import os
from contextlib import suppress
from pathlib import Path

import numpy as np

from luxloop import elementwise
from luxloop.sim.frame_builder import FrameBuilder
from luxloop.sim.input_files import missing_file
from luxloop.sim.kinematics import RawFrame, origin_near, wrap_angle
from luxloop.sim.opendrive.road_network import RoadNetwork, read_network
from luxloop.sim.openscenario.openscenario_config import OpenScenarioTraffic
from luxloop.sim.openscenario.storyboard import Storyboard, TrajectoryAction
from luxloop.sim.openscenario.storyboard_elements import read_storyboard
from luxloop.sim.openscenario.storyboard_run import StoryboardRun
from luxloop.sim.physical.layer import PhysicalTruth
from luxloop.sim.roster import Member, Roster
from luxloop.sim.source import EgoCommand, SimulatorFailedError, TrafficEndedError, TrafficInputError
from luxloop.sim.world import Obstacles, WorldFrame

LOOKED_AT_S = 60.0
"""[s] Events that do not start within this time of the storyboard are a warning."""
MARGIN = 30.0
"""[m] Margin beyond the delivery radius, so that bodies are in steady motion when they enter it."""


class OpenScenarioSource:
    """Source that runs a storyboard.

    Parameters
    ----------
    config
        The file, and the entity that carries the rig.
    folder
        Folder of the scenario file.
    range_m
        Delivery radius around the ego [m].
    """

    def __init__(self, config: OpenScenarioTraffic, folder: Path, range_m: float):
        self.dt = config.dt_s
        self.origin = np.zeros(2)
        self.warnings: tuple[str, ...] = ()
        self.ego_name = config.ego
        self._config = config
        self._folder = folder
        self._range = range_m
        self._steps = math.ceil(config.dt_s / config.step_s - 1e-9)
        self._files: tuple[Storyboard, RoadNetwork] | None = None
        self._layer: PhysicalTruth | None = None

    def reset(self, seed: int) -> Obstacles:
        """Read the files once, and place all entities. See `TrafficSource.reset`."""
        board, network = self._files or self._read()
        if self._config.ego not in board.entities:
            raise TrafficInputError(
                f'{self._config.file}: ego = "{self._config.ego}" is no entity; use one of {", ".join(board.entities)}'
            )
        if self._files is None:
            self._files, self.warnings = (board, network), self._idle_events(board, network)
        self._run = StoryboardRun(board, network)
        order = [self._config.ego, *(name for name in board.entities if name != self._config.ego)]
        roster = Roster(seed)
        entities = [board.entities[name] for name in order]
        self._members = {one.name: roster.add(one.name, one.kind, one.size, one.name) for one in entities}
        self.origin = origin_near(np.array(self._run.travellers[self._config.ego].centre[:2]))
        # Bodies that roll behind their fronts cannot reverse: if one of them does, all are only smoothed.
        rolling = not any(isinstance(one, TrajectoryAction) and one.reverses for _, one, _ in board.all_actions())
        self._layer = PhysicalTruth(self.dt, self._config.physical, rolling=rolling)
        config = self._config
        self._frame_builder = FrameBuilder(self.dt, self._range, config.modes, suspension=config.suspension)
        self._pushed, self._end = 0, ""
        return Obstacles.from_polygons([], [])

    def step(self) -> WorldFrame:
        """Return the next frame. See `TrafficSource.step`."""
        if (layer := self._layer) is None:
            raise SimulatorFailedError("the storyboard is not running: call reset before step")
        if (settled := layer.next(lambda: self._advance(layer))) is None:
            raise TrafficEndedError(f"{self._config.file}: {self._end}")
        return self._frame_builder.frame(*settled)

    def apply(self, command: EgoCommand) -> None:
        """Reject the command, since the storyboard moves the ego. See `TrafficSource.apply`."""
        raise TrafficInputError(f'an OpenSCENARIO storyboard accepts no {command}; use kind = "sumo"')

    def close(self) -> None:
        """Stop the storyboard."""
        self._layer = None

    def _read(self) -> tuple[Storyboard, RoadNetwork]:
        path = self._folder / self._config.file
        if not os.path.isfile(path):  # noqa: PTH113  Path.is_file raises for a name that is too long
            raise TrafficInputError(f"{self._config.file}: {missing_file(path)}")
        board, roads = read_storyboard(path, self._config.parameters)
        return board, read_network(roads)

    def _idle_events(self, board: Storyboard, network: RoadNetwork) -> tuple[str, ...]:
        """Run the storyboard to its end, and return a warning of the events that never start."""
        run = StoryboardRun(board, network)
        with suppress(TrafficInputError):  # the run of the frames says it
            while run.time < LOOKED_AT_S and not run.stopped and self._config.ego in run.travellers:
                run.advance(self.dt / self._steps)
        if names := ", ".join(run.never_started()):
            return (
                f"{self._config.file}: events that do not start until {run.time:.1f} s: {names}; check their triggers",
            )
        return ()

    def _advance(self, layer: PhysicalTruth) -> None:
        """Push the next raw frame, or end the run after the ego or the storyboard."""
        run, time = self._run, self._pushed * self.dt
        if self._pushed:
            try:
                for _ in range(self._steps):
                    run.advance(self.dt / self._steps)
            except TrafficInputError as error:  # a lane change to a lane that does not exist there
                raise SimulatorFailedError(str(error)) from error
        if self._config.ego not in run.travellers:
            self._end = f'ego "{self._config.ego}" reached the end of its road before {time:.2f} s'
        elif run.stopped:
            self._end = f"the StopTrigger ended the storyboard before {time:.2f} s"
        if self._end:
            layer.end()
            return
        layer.push(self._raw_frame())
        self._pushed += 1

    def _raw_frame(self) -> RawFrame:
        """Return all entities near the ego."""
        travellers = self._run.travellers
        pose = np.array([travellers[name].centre for name in self._names()])
        pose[:, :2] -= self.origin
        pose[:, 2] = wrap_angle(pose[:, 2])
        speed = np.array([travellers[name].speed for name in self._names()])
        near = elementwise.hypot(*(pose[:, :2] - pose[0, :2]).T) <= self._range + MARGIN
        members: list[Member] = [self._members[name] for name in self._names()]
        return RawFrame([one for one, kept in zip(members, near, strict=True) if kept], pose[near], speed[near])

    def _names(self) -> list[str]:
        """Return the entities that are still on the roads, the ego first."""
        return [name for name in self._members if name in self._run.travellers]
