"""Traffic by highway-env, stepped without a window. Only this package imports it.

highway-env draws y downwards: its coordinates are left-handed, with clockwise headings and lanes counted towards +y, to
the driver's right. Mirroring (negating y and heading) gives the world frame, with traffic on the right.
"""

from pathlib import Path
from typing import Any

import numpy as np

from luxloop.arrays import Floats
from luxloop.sim.frame_builder import FrameBuilder
from luxloop.sim.highway.agents import controlled_action, idle_action, install_drivers
from luxloop.sim.highway.environment import POLICY_HZ, Tuning, make, recorded_tuning, restore, translated_errors
from luxloop.sim.highway.highway_config import HighwayTraffic
from luxloop.sim.kinematics import RawFrame, origin_near, wrap_angle
from luxloop.sim.physical.layer import PhysicalTruth
from luxloop.sim.roster import Member, Roster
from luxloop.sim.source import EgoCommand, SimulatorFailedError, TrafficEndedError, TrafficInputError
from luxloop.sim.world import Kind, Obstacles, WorldFrame

VEHICLE_HEIGHT = 1.5
"""[m] highway-env is flat. All its vehicles are cars of 5 m by 2 m by default."""
OBSTACLE_HEIGHT = 1.0
"""[m] Height of obstacles: the end of a merging lane, a car park's walls."""


class HighwaySource:
    """A highway-env environment, centred on its first agent.

    Static obstacles are delivered once. Landmarks, which are goals without a body, are not delivered. Crashed vehicles
    stay. The environment's yaw is kept: course and heading differ where its vehicles slip.

    Parameters
    ----------
    config
        Environment to simulate.
    folder
        Folder of the scenario file; unused, it is part of the common signature.
    range_m
        Delivery radius around the ego [m].
    """

    dt = 1 / POLICY_HZ
    origin: Floats
    warnings: tuple[str, ...] = ()

    def __init__(self, config: HighwayTraffic, folder: Path, range_m: float):
        del folder
        self._config = config
        self._range = range_m
        self.ego_name = ""
        self._env: Any = None
        self._tuning: Tuning = []

    def reset(self, seed: int) -> Obstacles:
        """Build a new environment. See `TrafficSource.reset`."""
        self.close()
        config = self._config
        self._tuning = recorded_tuning(config.config)
        with translated_errors(f"{config.env} with this config", TrafficInputError):
            self._env = make(config.env, config.config)
            self._env.reset(seed=seed)
            install_drivers(self._env, ego=config.ego == "idm")
        self._action = (
            idle_action(self._env) if config.ego != "fixed" else controlled_action(self._env, config.env, config.action)
        )
        self._roster = Roster(seed, redraw_default_sizes=config.redraw_default_sizes)
        self._member(self._env.vehicle)  # the ego is added first
        self.origin = origin_near(_mirrored([self._env.vehicle])[0, :2])
        self._layer = PhysicalTruth(self.dt, config.smoothing, rolling=False)
        self._frame_builder = FrameBuilder(self.dt, self._range, config.modes, suspension=config.suspension)
        self._pushed, self._end = 0, ""
        return self._obstacles()

    def step(self) -> WorldFrame:
        """Advance until the next frame is final. See `TrafficSource.step`."""
        if self._env is None:
            raise SimulatorFailedError("highway-env is not running: call reset before step")
        if (settled := self._layer.next(self._advance)) is None:
            raise TrafficEndedError(self._end)
        return self._frame_builder.frame(*settled)

    def apply(self, command: EgoCommand) -> None:
        """Set the ego's action; further agents ignore it. See `TrafficSource.apply`."""
        if self._config.ego != "controlled":
            raise TrafficInputError(f'the ego is "{self._config.ego}"; commands need ego = "controlled"')
        if command.speed_mps is not None or command.lane is not None or command.action is None:
            raise TrafficInputError("highway-env's ego takes an action, neither speed_mps nor lane")
        if self._env is None:
            raise SimulatorFailedError("highway-env is not running: call reset before apply")
        self._action = controlled_action(self._env, self._config.env, command.action)

    def close(self) -> None:
        """Drop the environment and restore vehicle classes."""
        if self._env is not None:
            self._env.close()
            self._env = None
        restore(self._tuning)
        self._tuning = []

    def _advance(self) -> None:
        """Take one policy step, except before frame 0, and push the raw frame, or end if the ego crashed."""
        if self._pushed:
            with translated_errors(self._config.env, SimulatorFailedError):
                self._env.step(self._action)
        if self._env.vehicle.crashed:
            self._end = f"the ego crashed at {self._pushed * self.dt:.2f} s; try another seed"
            self._layer.end()
            return
        cars = {self._member(vehicle): vehicle for vehicle in self._env.road.vehicles}
        row = sorted(cars, key=lambda member: member.id)
        pose_world = _mirrored([cars[member] for member in row])
        pose_world[:, :2] -= self.origin
        speed = np.array([cars[member].speed for member in row], dtype=np.float64)
        self._layer.push(RawFrame(row, pose_world, speed))
        self._pushed += 1

    def _member(self, vehicle: Any) -> Member:
        # the roster keeps a reference to the object, so that its identity is not reused by another vehicle
        return self._roster.find(vehicle) or self._roster.add(
            vehicle, Kind.CAR, (vehicle.LENGTH, vehicle.WIDTH, VEHICLE_HEIGHT)
        )

    def _obstacles(self) -> Obstacles:
        """Return the solid objects on the road as walls."""
        solid = [item for item in self._env.road.objects if item.solid]
        outlines = [item.polygon()[:-1] * (1.0, -1.0) - self.origin for item in solid]
        return Obstacles.from_polygons(outlines, [OBSTACLE_HEIGHT] * len(solid))


def _mirrored(items: list[Any]) -> Floats:
    """Return poses (N, 3) in a frame with y upwards, with highway-env's y and heading negated."""
    x, y = np.array([item.position for item in items], dtype=np.float64).T
    heading = np.array([item.heading for item in items], dtype=np.float64)
    return np.column_stack([x, -y, wrap_angle(-heading)])
