"""Traffic by highway-env, stepped without a window. Only this package imports it.

highway-env draws y downwards: its frame is left-handed in data, with headings clockwise and lanes counted towards +y,
to the driver's right. Mirrored (y and heading change sign) it is our world, and traffic keeps to the right.
"""

from pathlib import Path
from typing import Any

import numpy as np

from sim.arrays import Floats
from sim.frame_builder import FrameBuilder
from sim.highway.agents import idle, obeying, put_drivers
from sim.highway.environment import POLICY_HZ, Tuning, foreign, make, restore, tuning
from sim.highway.highway_config import HighwayTraffic
from sim.kinematics import RawFrame, wrap_angle
from sim.origin import origin_near
from sim.physical.layer import PhysicalTruth
from sim.roster import Member, Roster
from sim.source import EgoCommand, SimulatorFailedError, TrafficEndedError, TrafficInputError
from sim.world import Kind, Obstacles, WorldFrame

VEHICLE_HEIGHT = 1.5
"""[m] highway-env is flat. All its vehicles are cars of 5 m by 2 m, before they are redrawn."""
OBSTACLE_HEIGHT = 1.0
"""[m] Of what stands on its roads: the end of a merging lane, a car park's walls."""


class HighwaySource:
    """One highway-env environment, centred on its first agent.

    Obstacles are static and come once; landmarks, which are goals without a body, do not come. Vehicles that crashed
    stay. The environment's yaw is kept: where its vehicles slip, their course differs from their heading.

    Parameters
    ----------
    config
        What to simulate.
    folder
        Folder of the scenario file; not needed here, every source has it.
    range_m
        Delivery radius around the ego [m].
    """

    dt = 1 / POLICY_HZ
    origin: Floats

    def __init__(self, config: HighwayTraffic, folder: Path, range_m: float):
        del folder
        self._config = config
        self._range = range_m
        self._env: Any = None
        self._tuning: Tuning = []

    def reset(self, seed: int) -> Obstacles:
        """Build the environment anew. See `TrafficSource.reset`."""
        self.close()
        config = self._config
        self._tuning = tuning(config.config)
        with foreign(f"{config.env} with this config", TrafficInputError):
            self._env = make(config.env, config.config)
            self._env.reset(seed=seed)
            put_drivers(self._env, ego=config.ego == "idm")
        self._action = idle(self._env) if config.ego != "fixed" else obeying(self._env, config.env, config.action)
        self._cast = Roster(seed, redraw_default_sizes=config.redraw_default_sizes)
        self._member(self._env.vehicle)  # the ego is cast first
        self.origin = origin_near(_mirrored([self._env.vehicle])[0, :2])
        self._layer = PhysicalTruth(self.dt, config.smoothing, rolling=False)
        self._delivery = FrameBuilder(self.dt, self._range, config.modes)
        self._pushed, self._end = 0, ""
        return self._obstacles()

    def step(self) -> WorldFrame:
        """Advance until the next frame is settled. See `TrafficSource.step`."""
        if self._env is None:
            raise SimulatorFailedError("highway-env is not running: reset comes before step")
        if (settled := self._layer.next(self._advance)) is None:
            raise TrafficEndedError(self._end)
        return self._delivery.frame(*settled)

    def apply(self, command: EgoCommand) -> None:
        """Give the ego an action of its own, whatever further agents there are. See `TrafficSource.apply`."""
        if self._config.ego != "controlled":
            raise TrafficInputError(f'the ego is "{self._config.ego}"; commands need ego = "controlled"')
        if command.speed_mps is not None or command.lane is not None or command.action is None:
            raise TrafficInputError("highway-env's ego takes an action, and neither a speed_mps nor a lane")
        if self._env is None:
            raise SimulatorFailedError("highway-env is not running: reset comes before apply")
        self._action = obeying(self._env, self._config.env, command.action)

    def close(self) -> None:
        """Drop the environment and put vehicle classes back as they were."""
        if self._env is not None:
            self._env.close()
            self._env = None
        restore(self._tuning)
        self._tuning = []

    def _advance(self) -> None:
        """Take one policy step, but for frame 0, and pass on what came of it, unless it was the ego's crash."""
        if self._pushed:
            with foreign(self._config.env, SimulatorFailedError):
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
        # the cast keeps the object itself, so that its identity is not given to another vehicle later
        return self._cast.find(vehicle) or self._cast.enter(
            vehicle, Kind.CAR, (vehicle.LENGTH, vehicle.WIDTH, VEHICLE_HEIGHT)
        )

    def _obstacles(self) -> Obstacles:
        """Return what stands on the road as walls."""
        solid = [thing for thing in self._env.road.objects if thing.solid]
        outlines = [thing.polygon()[:-1] * (1.0, -1.0) - self.origin for thing in solid]
        return Obstacles.from_polygons(outlines, [OBSTACLE_HEIGHT] * len(solid))


def _mirrored(things: list[Any]) -> Floats:
    """Return poses (N, 3) in a y-up frame: highway-env's with y and heading turned around."""
    x, y = np.array([thing.position for thing in things], dtype=np.float64).T
    heading = np.array([thing.heading for thing in things], dtype=np.float64)
    return np.column_stack([x, -y, wrap_angle(-heading)])
