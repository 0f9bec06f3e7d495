"""Traffic by SUMO, run in this process through libsumo. Only this file imports it."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any, ClassVar

from sim.arrays import Floats
from sim.frame_builder import FrameBuilder
from sim.physical.layer import PhysicalTruth
from sim.roster import Roster
from sim.source import EgoCommand, SimulatorFailedError, TrafficEndedError, TrafficInputError
from sim.sumo.ego import EgoControl, await_ego
from sim.sumo.error_messages import captured_stderr, one_line
from sim.sumo.input_checks import clean_up, sumo_command
from sim.sumo.opendrive_net import converted
from sim.sumo.parking import parked_cars
from sim.sumo.reader import SumoReader
from sim.sumo.roadside import static_obstacles
from sim.sumo.sumo_config import OPENDRIVE, SumoTraffic
from sim.world import Obstacles, WorldFrame


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
    _running: ClassVar["SumoSource | None"] = None

    def __init__(self, config: SumoTraffic, folder: Path, range_m: float):
        self.dt = config.dt_s
        self._config = config
        self._folder = folder
        self._range = range_m
        self._sumo: Any = None
        self._control: EgoControl | None = None

    def reset(self, seed: int) -> Obstacles:
        """Start SUMO and run it until the ego enters. See `TrafficSource.reset`."""
        self.close()
        if SumoSource._running is not None:
            raise SimulatorFailedError("libsumo runs one simulation per process: close the other source first")
        command = self._command(seed)
        import libsumo

        self._sumo, SumoSource._running = libsumo, self
        try:
            _start(libsumo, command)
            return self._set_up(command, seed)
        except (libsumo.TraCIException, libsumo.FatalTraCIError) as error:
            self.close()
            raise TrafficInputError(f"SUMO: {one_line(str(error), command)}") from error
        except BaseException:
            self.close()
            raise

    def step(self) -> WorldFrame:
        """Advance SUMO until the next frame is final. See `TrafficSource.step`."""
        if self._sumo is None:
            raise SimulatorFailedError("SUMO is not running: call reset before step")
        if (settled := self._layer.next(self._advance)) is None:
            raise TrafficEndedError(self._end)
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
        if self._sumo is not None:
            self._sumo.close()
            self._sumo = SumoSource._running = None
            clean_up()
        self._control = None

    def _command(self, seed: int) -> list[str]:
        config = self._config
        if config.config:
            files = {"configuration-file": [config.config]}
        else:
            opendrive = config.net.endswith(OPENDRIVE)
            net = converted(self._folder, config.net, config.netconvert) if opendrive else config.net
            files = {
                "net-file": [net],
                "route-files": config.routes,
                "additional-files": config.additional,
            }
        # by default SUMO removes an ego that collides
        options = {"collision.action": "warn"} if config.ego_control else {}
        return sumo_command(self._folder, files, self.dt, seed, options | config.options, config.begin_s)

    def _set_up(self, command: list[str], seed: int) -> Obstacles:
        """Run SUMO until the first frame, push it and return the obstacles."""
        sumo, config = self._sumo, self._config
        obstacles = static_obstacles(sumo.polygon, sumo.poi, config.building_height_m)
        parked = parked_cars(command, sumo.lane, config.parking_fill, seed)
        until = sumo.simulation.getTime() + config.max_wait_s
        self._ego = await_ego(sumo, config.ego, until)
        roster = Roster(seed, redraw_default_sizes=config.redraw_default_sizes)
        self._reader = SumoReader(sumo, self._ego, roster, parked, self._range, self.dt)
        self._await_vehicles(until)
        self._control = EgoControl(sumo, self._ego) if config.ego_control else None
        self.origin = self._reader.origin
        self._layer = PhysicalTruth(self.dt, config.physical, rolling=True)
        self._frame_builder = FrameBuilder(self.dt, self._range, config.modes)
        self._pushed, self._end = 0, ""
        self._push_frame()
        return replace(obstacles, vertices_world=obstacles.vertices_world - self.origin)

    def _await_vehicles(self, until: float) -> None:
        """Step SUMO until enough vehicles are around the ego."""
        required, simulation, count_max = self._config.min_vehicles, self._sumo.simulation, 0
        while (count := self._reader.vehicles_in_range()) < required:
            count_max = max(count_max, count)
            if simulation.getTime() >= until or self._ego in simulation.getArrivedIDList():
                raise TrafficInputError(
                    f'min_vehicles = {required}: ego "{self._ego}" had at most {count_max} around it until '
                    f"{simulation.getTime():.0f} s on SUMO's clock; lower it, or raise max_wait_s"
                )
            self._sumo.simulationStep()

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


def _start(sumo: Any, command: list[str]) -> None:
    """Start SUMO without output on the terminal; its messages about bad input become the error."""
    with captured_stderr() as captured:
        try:
            sumo.start(command)
        except (sumo.TraCIException, sumo.FatalTraCIError) as error:
            captured.seek(0)
            message = captured.read().decode(errors="replace") or str(error)
            raise TrafficInputError(f"SUMO: {one_line(message, command)}") from error
