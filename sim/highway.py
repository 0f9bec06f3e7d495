"""Traffic by highway-env, stepped without a window. The only file that imports it.

highway-env draws y downwards: its frame is left-handed in data, with headings clockwise and lanes counted towards +y,
to the driver's right. Mirrored (y and heading change sign) it is our world, and traffic keeps to the right.
"""

import difflib
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal

import numpy as np

from sim.cast import Cast, Member, frame_around_ego
from sim.kinematics import PoseDifferencer, wrap_angle
from sim.source import SimulatorFailedError, TrafficEndedError, TrafficError, TrafficInputError
from sim.world import Floats, Kind, Obstacles, WorldFrame

SIMULATION_HZ = 25
POLICY_HZ = 12.5
"""One frame of the rig is one policy step of two simulation steps."""

VEHICLE_HEIGHT = 1.5
"""[m] highway-env is flat. All its vehicles are cars of 5 m by 2 m, before they are redrawn."""
OBSTACLE_HEIGHT = 1.0
"""[m] Of what stands on its roads: the end of a merging lane, a car park's walls."""

_UNSEEN = {"observation": {"type": "Kinematics", "vehicles_count": 1}}
"""Nobody reads the observation; some environments' own is dear, or asks the ego for what an IDM vehicle lacks."""

_TUNED_BY_INTERSECTIONS = ("DISTANCE_WANTED", "COMFORT_ACC_MAX", "COMFORT_ACC_MIN")
"""intersection-v* overwrites these on the vehicle class; they must not leak into the next run of this process."""


@dataclass(frozen=True, slots=True)
class HighwayTraffic:
    """highway-env traffic. An episode's own end is ignored: the run ends with the scenario, or by the ego's crash."""

    kind: Literal["highway-env"] = "highway-env"
    env: str = "highway-v0"
    """Id of any environment that highway-env registers, but for lane-keeping-v0, which has nobody but its ego."""
    config: dict[str, Any] = field(default_factory=dict)
    """Overrides of the environment's own configuration, by its keys."""
    ego: Literal["idm", "fixed"] = "idm"
    """`idm`: the ego drives as the others do, by IDM and MOBIL. `fixed`: it repeats `action`, and crashes soon."""
    action: int = 1
    """Under `fixed`, the index of a discrete action; 1 is IDLE."""
    redraw_default_sizes: bool = True
    """Whether cars of highway-env's 5 m by 2 m, but for the ego, are drawn anew by the seed: no longer and no wider,
    about the same centre."""

    def __post_init__(self) -> None:
        for key in ("simulation_frequency", "policy_frequency"):
            if key in self.config:
                raise ValueError(f"config.{key} is fixed by the rig's 12.5 Hz; leave it out")


class HighwaySource:
    """One highway-env environment, centred on its first controlled vehicle.

    Obstacles are static and come once; landmarks, which are goals without a body, do not come.

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

    def __init__(self, config: HighwayTraffic, folder: Path, range_m: float):
        del folder
        self._config = config
        self._range = range_m
        self._env: Any = None
        self._tuning: list[tuple[type, dict[str, float]]] = []
        self._next = 0

    def reset(self, seed: int) -> Obstacles:
        """Build the environment anew. See `TrafficSource.reset`."""
        self.close()
        self._tuning = _tuning(self._config)
        with _foreign(self._config.env, TrafficInputError):
            self._env = _make(self._config)
            self._env.reset(seed=seed)
        if self._config.ego == "idm":
            _drive_by_idm(self._env)
        self._action = self._chosen_action(seed)
        self._cast = Cast(seed, redraw_default_sizes=self._config.redraw_default_sizes)
        self._member(self._env.vehicle)  # the ego is cast first
        self._differencer = PoseDifferencer(self.dt)
        self._next = 0
        return _obstacles(self._env.road.objects)

    def step(self) -> WorldFrame:
        """Advance one policy step, but for frame 0. See `TrafficSource.step`."""
        if self._env is None:
            raise SimulatorFailedError("highway-env is not running: reset comes before step")
        if self._next:
            with _foreign(self._config.env, SimulatorFailedError):
                self._env.step(self._action)
        if self._env.vehicle.crashed:
            raise TrafficEndedError(f"the ego crashed at {self._next * self.dt:.2f} s; try another seed")
        members = {self._member(vehicle): vehicle for vehicle in self._env.road.vehicles}
        row = sorted(members, key=lambda member: member.id)
        pose_world = _mirrored([members[member] for member in row])
        rates = self._differencer.add(
            np.array([member.id for member in row], dtype=np.int64),
            pose_world,
            np.array([members[member].speed for member in row], dtype=np.float64),
        )
        frame = frame_around_ego(self._next, self.dt, row, pose_world, rates, self._range)
        self._next += 1
        return frame

    def close(self) -> None:
        """Drop the environment and put vehicle classes back as they were."""
        if self._env is not None:
            self._env.close()
            self._env = None
        for vehicle_class, values in self._tuning:
            for name, value in values.items():
                setattr(vehicle_class, name, value)
        self._tuning = []

    def _member(self, vehicle: Any) -> Member:
        # the cast keeps the object itself, so that its identity is not given to another vehicle later
        return self._cast.find(vehicle) or self._cast.enter(
            vehicle, Kind.CAR, (vehicle.LENGTH, vehicle.WIDTH, VEHICLE_HEIGHT)
        )

    def _chosen_action(self, seed: int) -> Any:
        space = self._env.action_space
        if self._config.ego == "idm":  # which heeds no action, but the environment wants one to reward
            space.seed(seed)
            return space.sample()
        from gymnasium.spaces import Discrete

        if not (isinstance(space, Discrete) and space.contains(self._config.action)):
            raise TrafficInputError(
                f'action = {self._config.action} is not among {self._config.env}\'s actions, {space}; use ego = "idm"'
            )
        return self._config.action


@contextmanager
def _foreign(env: str, failure: type[TrafficError]) -> Iterator[None]:
    """Turn whatever a third party's environment raises into our error."""
    try:
        yield
    except TrafficError:
        raise
    except Exception as error:
        raise failure(f"{env}: {type(error).__name__}: {' '.join(str(error).split())}") from error


def _make(config: HighwayTraffic) -> Any:
    """Build the environment without gymnasium's wrappers, which would check, warn and truncate."""
    import gymnasium
    import highway_env  # noqa: F401  registers its environments
    from gymnasium.envs.registration import load_env_creator

    known = sorted(
        name
        for name, spec in gymnasium.registry.items()
        if isinstance(spec.entry_point, str) and spec.entry_point.startswith("highway_env.")
    )
    if config.env not in known:
        raise TrafficInputError(f'env = "{config.env}" is unknown; {_did_you_mean(config.env, known)}')
    env: Any = load_env_creator(str(gymnasium.spec(config.env).entry_point))()
    for key in config.config:
        if key not in env.config:
            raise TrafficInputError(
                f"config.{key} is unknown to {config.env}; {_did_you_mean(key, sorted(env.config))}"
            )
    env.configure(_UNSEEN | config.config | {"simulation_frequency": SIMULATION_HZ, "policy_frequency": POLICY_HZ})
    return env


def _did_you_mean(word: str, known: list[str]) -> str:
    close = difflib.get_close_matches(word, known)
    return f"did you mean {', '.join(close)}?" if close else f"known are {', '.join(known)}"


def _drive_by_idm(env: Any) -> None:
    """Put IDM vehicles in the places of the controlled ones, on their routes, where they and the road find them."""
    from highway_env.vehicle.behavior import IDMVehicle
    from highway_env.vehicle.controller import ControlledVehicle

    for n, passive in enumerate(env.controlled_vehicles):
        if isinstance(passive, ControlledVehicle):
            driver = IDMVehicle.create_from(passive)
        else:
            driver = IDMVehicle(env.road, passive.position, passive.heading, passive.speed)
        for name, value in vars(passive).items():  # goals and target speeds that rewards ask for
            vars(driver).setdefault(name, value)
        env.road.vehicles[env.road.vehicles.index(passive)] = driver
        env.controlled_vehicles[n] = driver
    env.define_spaces()  # links observations and actions to the new vehicles


def _tuning(config: HighwayTraffic) -> list[tuple[type, dict[str, float]]]:
    """Note what an intersection would overwrite."""
    from highway_env.utils import class_from_path
    from highway_env.vehicle.behavior import IDMVehicle

    classes = [IDMVehicle]
    if "other_vehicles_type" in config.config:
        with _foreign("config.other_vehicles_type", TrafficInputError):
            classes.append(class_from_path(config.config["other_vehicles_type"]))
    return [(cls, {name: getattr(cls, name) for name in _TUNED_BY_INTERSECTIONS}) for cls in classes]


def _mirrored(things: list[Any]) -> Floats:
    """Return poses (N, 3) in the world frame: highway-env's with y and heading turned around."""
    x, y = np.array([thing.position for thing in things], dtype=np.float64).T
    heading = np.array([thing.heading for thing in things], dtype=np.float64)
    return np.column_stack([x, -y, wrap_angle(-heading)])


def _obstacles(objects: list[Any]) -> Obstacles:
    """Return what stands on the road as walls."""
    solid = [thing for thing in objects if thing.solid]
    outlines = [thing.polygon()[:-1] * (1.0, -1.0) for thing in solid]
    return Obstacles.from_polygons(outlines, [OBSTACLE_HEIGHT] * len(solid))
