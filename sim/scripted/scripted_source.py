"""Scripted traffic: analytic motions from the scenario file with exact rates, for tests that need exact truth."""

import math
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal

import numpy as np

from luxloop.arrays import Floats
from luxloop.sim.actor_draws import Stream, actor_rng
from luxloop.sim.frame_builder import FrameBuilder
from luxloop.sim.kinematics import Kinematics, wrap_angle
from luxloop.sim.modes import ModeLimits
from luxloop.sim.obstacles import obstacles
from luxloop.sim.roster import Roster
from luxloop.sim.scripted.motions import state_at
from luxloop.sim.scripted.script import SIZE_BY_KIND, ScriptedActor, ScriptedEgo, ScriptedObstacle, ScriptedRing
from luxloop.sim.source import EgoCommand, SimulatorFailedError, TrafficInputError, TrafficSource
from luxloop.sim.world import Kind, Obstacles, WorldFrame


@dataclass(frozen=True, slots=True)
class ScriptedTraffic:
    """Scripted traffic. It does not end before the scenario does."""

    kind: Literal["scripted"] = "scripted"
    ego: ScriptedEgo = field(default_factory=ScriptedEgo)
    """The vehicle that carries the rig."""
    actor: list[ScriptedActor] = field(default_factory=list)
    """All other road users, numbered from 1 in this order."""
    ring: ScriptedRing | None = None
    """Cars around the ego, numbered after the actors."""
    obstacle: list[ScriptedObstacle] = field(default_factory=list)
    """Static obstacles along the road."""
    dt_s: float = 0.08
    """[s] Time between frames; the rig turns at 12.5 Hz."""
    jitter_m: float = 0.05
    """[m] Actors start up to this far from their position in x and in y, drawn uniformly by the seed."""
    jitter_deg: float = 0.05
    """[deg] Jitter of the initial yaw, drawn in the same way."""
    modes: ModeLimits = field(default_factory=ModeLimits)
    """Limits of the true motion modes."""
    suspension: bool = True
    """If true, bodies pitch and roll by their accelerations, and riders lean into turns."""

    def __post_init__(self) -> None:
        if self.dt_s <= 0 or self.jitter_m < 0 or self.jitter_deg < 0:
            raise ValueError("dt_s must be positive, jitter_m and jitter_deg must not be negative")
        names = [actor.name for actor in self.actor if actor.name]
        if twice := sorted({name for name in names if names.count(name) > 1}):
            raise ValueError(
                f'two actors have name = "{twice[0]}"; give each its own, which its random draws are keyed by'
            )

    def make_source(self, folder: Path, range_m: float) -> TrafficSource:
        """Make the source. See `luxloop.sim.factory.TrafficConfig`."""
        return ScriptedSource(self, folder, range_m)


class ScriptedSource:
    """Source that plays a script.

    Parameters
    ----------
    config
        Script to play.
    folder
        Folder of the scenario file; unused, it is part of the common signature.
    range_m
        Delivery radius around the ego [m].
    """

    def __init__(self, config: ScriptedTraffic, folder: Path, range_m: float):
        del folder
        self.dt = config.dt_s
        self.origin = np.zeros(2)
        self.warnings: tuple[str, ...] = ()
        self.ego_name = ""
        self._config = config
        self._range = range_m
        self._frame_builder: FrameBuilder | None = None

    def reset(self, seed: int) -> Obstacles:
        """Place all road users at their start. See `TrafficSource.reset`."""
        ego, roster = self._config.ego, Roster(seed)
        self._members = [roster.add("ego", Kind.CAR, ego.size_m, "ego")]
        self._starts = [ego.start_world]
        self._motions = [ego.motion]
        ring = self._config.ring.actors(ego) if self._config.ring else []
        for number, actor in enumerate([*self._config.actor, *ring], start=1):
            kind = Kind[actor.kind.upper().replace("-", "_")]
            size = actor.size_m or SIZE_BY_KIND[kind]
            member = roster.add(number, kind, size, actor.name, actor.reflectivity)
            self._members.append(member)
            self._starts.append(actor.start_world + self._jitter(seed, member.name))
            self._motions.append(actor.motion)
        config, self._next = self._config, 0
        self._frame_builder = FrameBuilder(self.dt, self._range, config.modes, suspension=config.suspension)
        return obstacles([prism for obstacle in self._config.obstacle for prism in obstacle.prisms()])

    def step(self) -> WorldFrame:
        """Return the next frame. See `TrafficSource.step`."""
        if self._frame_builder is None:
            raise SimulatorFailedError("the script is not running: call reset before step")
        time, self._next = self._next * self.dt, self._next + 1
        return self._frame_builder.frame(self._members, self._motion_at(time))

    def apply(self, command: EgoCommand) -> None:
        """Reject the command, since the script is fixed. See `TrafficSource.apply`."""
        raise TrafficInputError(f'scripted traffic follows its script and accepts no {command}; use kind = "sumo"')

    def close(self) -> None:
        """Stop the script."""
        self._frame_builder = None

    def _motion_at(self, time: float) -> Kinematics:
        states = [state_at(motion, start, time) for motion, start in zip(self._motions, self._starts, strict=True)]
        pose_world = np.array([state.pose for state in states])
        pose_world[:, 2] = wrap_angle(pose_world[:, 2])
        return Kinematics(
            pose_world=pose_world,
            velocity_world=np.array([state.velocity for state in states]),
            acceleration_world=np.array([state.acceleration for state in states]),
            yaw_rate=np.array([state.yaw_rate for state in states]),
            articulation=np.zeros(len(states)),
            changes_lane=np.zeros(len(states), dtype=np.bool_),
            deviation=np.zeros((len(states), 2)),
        )

    def _jitter(self, seed: int, name: str) -> Floats:
        rng = actor_rng(seed, name, Stream.START)
        limit = np.array([self._config.jitter_m, self._config.jitter_m, math.radians(self._config.jitter_deg)])
        return limit * rng.uniform(-1.0, 1.0, size=3)
