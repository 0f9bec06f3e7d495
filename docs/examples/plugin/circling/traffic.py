"""Traffic of the kind `circle`: cars on a circle around an ego that stands."""

from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np

from luxloop.sim.frame_builder import FrameBuilder
from luxloop.sim.kinematics import Kinematics, wrap_angle
from luxloop.sim.modes import ModeLimits
from luxloop.sim.obstacles import obstacles
from luxloop.sim.roster import Roster
from luxloop.sim.source import EgoCommand, SimulatorFailedError, TrafficInputError
from luxloop.sim.world import Kind, Obstacles, WorldFrame

CAR_M = (4.5, 1.8, 1.5)


@dataclass(frozen=True, slots=True, kw_only=True)
class CircleTraffic:
    """The `[traffic]` table: its fields are the keys."""

    kind: Literal["circle"] = "circle"
    cars: int = 4
    """Number of cars, evenly spaced."""
    radius_m: float = 15.0
    """[m] Radius of the circle of their centres."""
    speed_mps: float = 6.0
    """[m/s] Speed, counter-clockwise."""

    def __post_init__(self) -> None:
        if not (1 <= self.cars <= 100 and self.radius_m * np.pi > self.cars * CAR_M[0]):
            raise ValueError(
                f"cars = {self.cars} should be at least 1, and fit on a circle of radius_m = {self.radius_m:g}"
            )

    def make_source(self, folder: Path, range_m: float) -> "CircleSource":
        """Make the source; `folder` is that of the scenario file, `range_m` the range of the LIDARs [m]."""
        del folder
        return CircleSource(self, range_m)


class CircleSource:
    """A `luxloop.sim.source.TrafficSource`."""

    dt = 0.08
    warnings: tuple[str, ...] = ()
    ego_name = "ego"

    def __init__(self, config: CircleTraffic, range_m: float) -> None:
        self.origin = np.zeros(2)
        self.config, self.range_m = config, range_m
        self.builder: FrameBuilder | None = None

    def reset(self, seed: int) -> Obstacles:
        """Place the cars, the first at an angle that the seed draws."""
        roster, names = Roster(seed), [f"car {number}" for number in range(self.config.cars)]
        self.members = [roster.add(name, Kind.CAR, CAR_M, name) for name in ("ego", *names)]
        self.start = np.random.default_rng(seed).uniform(0.0, 2.0 * np.pi)
        self.builder, self.frame = FrameBuilder(self.dt, self.range_m, ModeLimits()), 0
        return obstacles([])

    def step(self) -> WorldFrame:
        """Return the next frame."""
        if self.builder is None:
            raise SimulatorFailedError("the circle is not running: call reset before step")
        time, self.frame = self.frame * self.dt, self.frame + 1
        return self.builder.frame(self.members, self.motion(time))

    def motion(self, time: float) -> Kinematics:
        """Return the motion of the ego and of the cars at a time [s]."""
        count, radius, speed = self.config.cars, self.config.radius_m, self.config.speed_mps
        angle = self.start + speed / radius * time + 2.0 * np.pi * np.arange(count) / count
        outward = np.column_stack([np.cos(angle), np.sin(angle)])
        along = np.column_stack([-np.sin(angle), np.cos(angle)])
        pose = np.column_stack([radius * outward, wrap_angle(angle + 0.5 * np.pi)])
        return Kinematics(
            pose_world=np.vstack([np.zeros(3), pose]),
            velocity_world=np.vstack([np.zeros(2), speed * along]),
            acceleration_world=np.vstack([np.zeros(2), -(speed**2) / radius * outward]),
            yaw_rate=np.append(0.0, np.full(count, speed / radius)),
            articulation=np.zeros(count + 1),
            changes_lane=np.zeros(count + 1, np.bool_),
            deviation=np.zeros((count + 1, 2)),
        )

    def apply(self, command: EgoCommand) -> None:
        """Refuse a command: the ego stands."""
        raise TrafficInputError(f"the ego of a circle stands and accepts no {command}")

    def close(self) -> None:
        """End the run."""
        self.builder = None
