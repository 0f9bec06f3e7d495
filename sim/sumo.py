"""Traffic by SUMO, run in this process through libsumo. The only file that imports it.

SUMO tells the middle of the front bumper and an angle clockwise from north in degrees; frames carry the box
centre and yaw. Rates are differenced from poses: SUMO's own speed is the front bumper's.
"""

import math
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, ClassVar, Literal

import numpy as np

from sim.cast import Cast, Member, frame_around_ego
from sim.kinematics import PoseDifferencer, wrap_angle
from sim.source import SimulatorFailedError, TrafficEndedError, TrafficInputError
from sim.sumo_bodies import kind_of_shape
from sim.sumo_input import captured_stderr, one_line, sumo_command
from sim.sumo_street import static_obstacles
from sim.world import Floats, Kind, Obstacles, WorldFrame

_RESERVED_OPTIONS = frozenset(
    {"configuration-file", "net-file", "route-files", "additional-files", "seed", "random", "step-length"}
)
_LONGEST = 20.0
"""[m] Half of two long vehicles: how far apart bumpers may be when the centres are in range."""


@dataclass(frozen=True, slots=True)
class SumoTraffic:
    """SUMO traffic: a `.sumocfg`, or a net with routes. Paths are relative to the scenario file."""

    kind: Literal["sumo"] = "sumo"
    config: str = ""
    """A `.sumocfg`; then `net`, `routes` and `additional` stay out."""
    net: str = ""
    """A `.net.xml`."""
    routes: list[str] = field(default_factory=list)
    """Route files: vehicle types, routes, flows, vehicles, persons."""
    additional: list[str] = field(default_factory=list)
    """Additional files. Shapes in them block beams: polygons of a type `building`, `wall`, `barrier`, `fence` or
    `guard_rail`, points of interest of a type `pole`, `street_lamp`, `tree`, `traffic_sign` or `bollard`, and whatever
    has a parameter `height` [m]. Further parameters: `base` and `diameter` [m], `reflectivity`."""
    ego: str = "first"
    """`vehicle:<id>`, `route:<id>` (the first vehicle that enters on it), or `first` that enters at all."""
    dt_s: float = 0.08
    """[s] SUMO's step and the time between frames; the rig turns at 12.5 Hz."""
    max_wait_s: float = 300.0
    """[s] simulated time to wait for the ego."""
    building_height_m: float = 10.0
    """[m] Height of polygons that do not tell their own."""
    redraw_default_sizes: bool = True
    """Whether vehicles and people of exactly SUMO's default size are drawn anew within their class, by the seed: no
    longer and no wider, the front bumper where SUMO has it. Types with a size of their own, and the ego, stay."""
    options: dict[str, str] = field(default_factory=dict)
    """Further SUMO options by long name, as `lateral-resolution = "0.8"`, without which lane changes are jumps."""

    def __post_init__(self) -> None:
        if bool(self.config) == bool(self.net and self.routes):
            raise ValueError("name either config (a .sumocfg), or both net and routes")
        if self.config and self.additional:
            raise ValueError("additional goes with net and routes; with config, list the files in the .sumocfg")
        selector, _, wanted = self.ego.partition(":")
        if self.ego != "first" and not (selector in ("vehicle", "route") and wanted):
            raise ValueError(f'ego = "{self.ego}": write "vehicle:<id>", "route:<id>" or "first"')
        if not (self.dt_s > 0 and self.max_wait_s > 0 and self.building_height_m > 0):
            raise ValueError("dt_s, max_wait_s and building_height_m must be positive")
        if reserved := sorted(_RESERVED_OPTIONS & self.options.keys()):
            raise ValueError(f"options.{reserved[0]}: set it by its own scenario key instead")


class SumoSource:
    """One SUMO simulation, centred on an ego vehicle.

    libsumo holds one simulation per process: `close` one source before `reset` of another.

    Parameters
    ----------
    config
        What to simulate.
    folder
        Folder of the scenario file.
    range_m
        Delivery radius around the ego [m].
    """

    _running: ClassVar["SumoSource | None"] = None

    def __init__(self, config: SumoTraffic, folder: Path, range_m: float):
        self.dt = config.dt_s
        self._config = config
        self._folder = folder
        self._range = range_m
        self._sumo: Any = None
        self._ego = ""
        self._next = 0

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
            self._ego = self._await_ego()
            self._subscribe()
            obstacles = static_obstacles(libsumo.polygon, libsumo.poi, self._config.building_height_m)
        except (libsumo.TraCIException, libsumo.FatalTraCIError) as error:
            self.close()
            raise TrafficInputError(f"SUMO: {one_line(str(error))}") from error
        except TrafficInputError:
            self.close()
            raise
        self._cast = Cast(seed, redraw_default_sizes=self._config.redraw_default_sizes)
        self._differencer = PoseDifferencer(self.dt)
        self._next = 0
        return obstacles

    def step(self) -> WorldFrame:
        """Advance one step, but for frame 0. See `TrafficSource.step`."""
        sumo = self._sumo
        if sumo is None:
            raise SimulatorFailedError("SUMO is not running: reset comes before step")
        if self._next:
            try:
                sumo.simulationStep()
            except (sumo.TraCIException, sumo.FatalTraCIError) as error:
                raise SimulatorFailedError(f"SUMO at {self._next * self.dt:.2f} s: {one_line(str(error))}") from error
        members, pose_world, speed = self._collect()
        ids = np.array([member.id for member in members], dtype=np.int64)
        rates = self._differencer.add(ids, pose_world, speed)
        frame = frame_around_ego(self._next, self.dt, members, pose_world, rates, self._range)
        self._next += 1
        return frame

    def close(self) -> None:
        """End the simulation, if there is one."""
        if self._sumo is not None:
            self._sumo.close()
            self._sumo = SumoSource._running = None

    def _command(self, seed: int) -> list[str]:
        config = self._config
        if config.config:
            files = {"configuration-file": [config.config]}
        else:
            files = {
                "net-file": [config.net],
                "route-files": config.routes,
                "additional-files": config.additional,
            }
        return sumo_command(self._folder, files, self.dt, seed, config.options)

    def _await_ego(self) -> str:
        """Step until the ego enters; return its SUMO id."""
        sumo = self._sumo
        selector, _, wanted = self._config.ego.partition(":")
        appeared: dict[str, None] = {}
        for _ in range(math.ceil(self._config.max_wait_s / self.dt)):
            sumo.simulationStep()
            for name in sorted(sumo.simulation.getDepartedIDList()):
                label = sumo.vehicle.getRouteID(name) if selector == "route" else name
                if selector == "first" or label == wanted:
                    return str(name)
                appeared[label] = None
            if sumo.simulation.getMinExpectedNumber() == 0:  # nobody is left to come
                break
        raise TrafficInputError(
            f'ego = "{self._config.ego}" did not enter in {sumo.simulation.getTime():.0f} s; '
            f"these did: {', '.join(list(appeared)[:8]) or 'none'}; name one of them or raise max_wait_s"
        )

    def _subscribe(self) -> None:
        constants = self._sumo.constants
        self._position, self._angle, self._speed = (
            constants.VAR_POSITION,
            constants.VAR_ANGLE,
            constants.VAR_SPEED,
        )
        self._sumo.vehicle.subscribeContext(
            self._ego,
            constants.CMD_GET_VEHICLE_VARIABLE,
            self._range + _LONGEST,
            [self._position, self._angle, self._speed],
        )

    def _collect(self) -> tuple[list[Member], Floats, Floats]:
        """Return members by number, their poses (N, 3) and SUMO's speeds (N,) [m/s]."""
        seen = self._sumo.vehicle.getContextSubscriptionResults(self._ego)
        if self._ego not in seen:
            raise TrafficEndedError(
                f'ego "{self._ego}" left the net at {self._next * self.dt:.2f} s (arrived or teleported)'
            )
        names = [self._ego, *sorted(seen.keys() - {self._ego})]
        rows = [
            (self._vehicle(name), seen[name][self._position], seen[name][self._angle], seen[name][self._speed])
            for name in names
        ]
        rows += self._persons(seen[self._ego][self._position])
        rows.sort(key=lambda row: row[0].id)
        members = [row[0] for row in rows]
        front = np.array([row[1] for row in rows])
        length = np.array([member.size[0] for member in members])
        pose_world = _box_centre(front, np.array([row[2] for row in rows]), length)
        return members, pose_world, np.array([row[3] for row in rows])

    def _vehicle(self, name: str) -> Member:
        vehicle, key = self._sumo.vehicle, ("vehicle", name)
        if member := self._cast.find(key):
            return member
        size = (vehicle.getLength(name), vehicle.getWidth(name), vehicle.getHeight(name))
        return self._cast.enter(key, kind_of_shape(vehicle.getShapeClass(name), size[2]), size, name)

    def _persons(self, centre: tuple[float, float]) -> list[tuple[Member, Any, float, float]]:
        """Return those on foot in range. A vehicle's context cannot hold two domains, so they are asked singly."""
        person = self._sumo.person
        rows = []
        for name in sorted(person.getIDList()):
            position = person.getPosition(name)
            if math.dist(position, centre) <= self._range + _LONGEST and not person.getVehicle(name):
                rows.append((self._person(name), position, person.getAngle(name), person.getSpeed(name)))
        return rows

    def _person(self, name: str) -> Member:
        person, key = self._sumo.person, ("person", name)
        if member := self._cast.find(key):
            return member
        height = self._sumo.vehicletype.getHeight(person.getTypeID(name))
        size = (person.getLength(name), person.getWidth(name), height)
        return self._cast.enter(key, Kind.PEDESTRIAN, size, name)


def _start(sumo: Any, command: list[str]) -> None:
    """Start SUMO without a word on the terminal; what it would say of bad input becomes the error."""
    with captured_stderr() as said:
        try:
            sumo.start(command)
        except (sumo.TraCIException, sumo.FatalTraCIError) as error:
            said.seek(0)
            complaint = said.read().decode(errors="replace") or str(error)
            raise TrafficInputError(f"SUMO: {one_line(complaint)}") from error


def _box_centre(front: Floats, angle_deg: Floats, length: Floats) -> Floats:
    """Return poses (N, 3) from front bumpers (N, 2) [m], angles clockwise from north (N,) and lengths (N,) [m]."""
    yaw = wrap_angle(np.radians(90.0 - angle_deg))
    back = 0.5 * length[:, None] * np.column_stack([np.cos(yaw), np.sin(yaw)])
    return np.column_stack([front - back, yaw])
