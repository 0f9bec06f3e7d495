"""Traffic by SUMO, run in this process through libsumo."""

import math
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any

from luxloop.arrays import Floats
from luxloop.sim.frame_builder import FrameBuilder
from luxloop.sim.physical.layer import PhysicalTruth
from luxloop.sim.roster import Roster
from luxloop.sim.source import (
    EgoCommand,
    SimulatorFailedError,
    StartReport,
    StartStatus,
    TrafficEndedError,
    TrafficInputError,
    ignore_status,
)
from luxloop.sim.sumo.ego import EgoControl
from luxloop.sim.sumo.ego_choice import await_busy_ego, await_ego, best_ego
from luxloop.sim.sumo.error_messages import one_line
from luxloop.sim.sumo.input_checks import is_left_hand
from luxloop.sim.sumo.net_terrain import net_terrain
from luxloop.sim.sumo.parking import parked_cars
from luxloop.sim.sumo.reader import SumoReader
from luxloop.sim.sumo.roadside import static_obstacles
from luxloop.sim.sumo.session import SumoSession
from luxloop.sim.sumo.sumo_config import SumoTraffic
from luxloop.sim.world import Obstacles, WorldFrame

EARLY = 1e-6
"""[s] Tolerance of SUMO's clock."""


class SumoSource:
    """A SUMO simulation, centred on an ego vehicle.

    libsumo holds one simulation per process: `close` one source before `reset` of another.

    Parameters
    ----------
    config
        Traffic to simulate.
    folder
        Folder of the scenario file.
    range_m
        Delivery radius around the ego [m].
    """

    origin: Floats
    warnings: tuple[str, ...] = ()

    def __init__(self, config: SumoTraffic, folder: Path, range_m: float):
        self.dt = config.dt_s
        self._config = config
        self._folder = folder
        self._range = range_m
        self.ego_name = ""
        self.report_start: StartReport = ignore_status
        """Receives the progress of `reset`."""
        self._session = SumoSession(config, folder)
        self._sumo: Any = None
        self._control: EgoControl | None = None

    def reset(self, seed: int) -> Obstacles:
        """Start SUMO and run it until the ego enters. See `TrafficSource.reset`."""
        self.close()
        ego = self._config.ego
        if ego.partition(":")[0] == "best":
            ego = f"vehicle:{best_ego(self._config, self._folder, seed, self._range, self.report_start)}"
        libsumo = self._sumo = self._session.start(seed, self.report_start)
        try:
            return self._set_up(ego, seed)
        except (libsumo.TraCIException, libsumo.FatalTraCIError) as error:
            wrong = self._session.input_error(str(error))
            self.close()
            raise wrong from error
        except BaseException:
            self.close()
            raise

    def step(self) -> WorldFrame:
        """Advance SUMO until the next frame is final. See `TrafficSource.step`."""
        if self._sumo is None:
            raise SimulatorFailedError("SUMO is not running: call reset before step")
        if (settled := self._layer.next(self._advance)) is None:
            raise TrafficEndedError(self._end, self._reader.collisions)
        return self._frame_builder.frame(*settled)

    def apply(self, command: EgoCommand) -> None:
        """Command the ego's speed and lane. See `TrafficSource.apply`."""
        if self._control is None:
            raise TrafficInputError("this ego takes no commands: set traffic.ego_control = true and call reset first")
        if not self._end:
            with self._in_mid_run():
                self._control.apply(command)

    def close(self) -> None:
        """End the simulation if it is running."""
        self._session.close()
        self._sumo = self._control = None

    def _set_up(self, ego: str, seed: int) -> Obstacles:
        """Run SUMO until the first frame, push it and return the obstacles."""
        sumo, config = self._sumo, self._config
        obstacles = static_obstacles(sumo.polygon, sumo.poi, config.building_height_m)
        parked = parked_cars(self._session.command, sumo.lane, config.parking_fill, seed)
        until = sumo.simulation.getTime() + config.max_wait_s
        self.ego_name = self._ego = self._await_ego(ego, until)
        roster = Roster(seed, redraw_default_sizes=config.redraw_default_sizes)
        ground = net_terrain(self._session.net)
        left_hand = is_left_hand(self._session.command)
        self._reader = SumoReader(
            sumo, self._ego, roster, parked, self._range, self.dt, left_hand=left_hand, bridges=ground.bridges
        )
        self._await_vehicles(until)
        self._control = EgoControl(sumo, self._ego) if config.ego_control else None
        self.origin = self._reader.origin
        self.warnings = self._reader.warnings + ground.warnings
        terrain = ground.seen_from(self.origin)
        self._layer = PhysicalTruth(self.dt, config.physical, rolling=True)
        self._frame_builder = FrameBuilder(self.dt, self._range, config.modes, terrain, suspension=config.suspension)
        self._pushed, self._end = 0, ""
        self._push_frame()
        return replace(obstacles, vertices_world=obstacles.vertices_world - self.origin, terrain=terrain)

    def _await_ego(self, ego: str, until: float) -> str:
        """Step SUMO until the ego is in the net, and return its SUMO id."""
        config, any_class = self._config, self._config.ego_any_class
        if ego == "first" and config.min_vehicles:
            return await_busy_ego(
                self._sumo, config.min_vehicles, self._range, until, self.report_start, any_class=any_class
            )
        return await_ego(self._sumo, ego, until, self.report_start, any_class=any_class)

    def _await_vehicles(self, until: float) -> None:
        """Step SUMO until the start of the frames, with enough vehicles around the ego."""
        required, simulation, count_max = self._config.min_vehicles, self._sumo.simulation, 0
        begin = -math.inf if self._config.frames_from_s is None else self._config.frames_from_s
        while (count := self._reader.vehicles_in_range()) < required or simulation.getTime() < begin - EARLY:
            count_max = max(count_max, count)
            arrived = self._ego in simulation.getArrivedIDList()
            if arrived or simulation.getTime() >= until:
                raise TrafficInputError(self._too_few(count_max, arrived, begin))
            self.report_start(StartStatus(f"SUMO runs until frame 0, {simulation.getTime():.0f} s on its clock"))
            self._sumo.simulationStep()

    def _too_few(self, count_max: int, arrived: bool, begin: float) -> str:
        """Return the message that the ego arrived or the time ran out before frame 0, with the true cause."""
        now = self._sumo.simulation.getTime()
        if now < begin - EARLY:
            end = f'ego "{self._ego}" left the net at {now:.0f} s' if arrived else f"max_wait_s ended at {now:.0f} s"
            remedy = "choose an ego that stays longer (luxloop egos lists them)" if arrived else "raise max_wait_s"
            return f"frames_from_s = {begin:g}: {end} on SUMO's clock; {remedy}, or lower frames_from_s"
        remedy = "when it left the net; choose another ego (luxloop egos lists them), or lower min_vehicles"
        return (
            f'min_vehicles = {self._config.min_vehicles}: ego "{self._ego}" had at most {count_max} around it until '
            f"{now:.0f} s on SUMO's clock{', ' + remedy if arrived else '; lower it, or raise max_wait_s'}"
        )

    def _advance(self) -> None:
        """Step SUMO once and push the frame."""
        with self._in_mid_run():
            self._sumo.simulationStep()
            self._push_frame()

    def _push_frame(self) -> None:
        """Push the present frame to the physical layer, or end the run if the ego is gone."""
        raw = self._reader.read()
        if raw is not None:
            self._layer.push(raw)
            self._pushed += 1
            self._time = self._sumo.simulation.getTime()
        else:
            self._end = f'ego "{self._ego}" left the net at {self._pushed * self.dt:.2f} s: {self._reader.end_reason}'
            self._layer.end()

    @contextmanager
    def _in_mid_run(self) -> Iterator[None]:
        """Convert SUMO's errors to simulator failures."""
        try:
            yield
        except (self._sumo.TraCIException, self._sumo.FatalTraCIError) as error:
            raise SimulatorFailedError(f"SUMO after {self._time:.2f} s on its clock: {one_line(str(error))}") from error
