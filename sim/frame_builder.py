"""Last step of every traffic source: build world frames from members and their motion."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from luxloop import elementwise
from luxloop.arrays import Floats, Ints
from luxloop.sim.kinematics import Kinematics
from luxloop.sim.modes import ModeClassifier, ModeLimits
from luxloop.sim.road_terrain import ground_contact
from luxloop.sim.roster import Member
from luxloop.sim.suspension import Suspension
from luxloop.sim.world import Actors, Ego, Terrain, WorldFrame


class FrameBuilder:
    """Builder of the frames of one run, one after the other.

    Parameters
    ----------
    dt
        Time between frames [s].
    range_m
        Delivery radius [m]: the ego, and all actors whose centre is within this distance of the ego's centre.
    limits
        Limits of the motion modes.
    terrain
        Ground under the bodies; None if it is flat.
    suspension
        If True, vehicles pitch and roll by their accelerations, and riders lean.
    """

    def __init__(
        self, dt: float, range_m: float, limits: ModeLimits, terrain: Terrain | None = None, *, suspension: bool = True
    ):
        self._dt = dt
        self._range = range_m
        self._classifier = ModeClassifier(limits)
        self._terrain = terrain
        self._suspension = Suspension(dt) if suspension else None
        self._next = 0
        self._present: list[Member] = []
        self._appearance = _Appearance.of([])

    def frame(self, members: list[Member], motion: Kinematics) -> WorldFrame:
        """Return the next frame of N members by ascending number, the ego first, and their motion."""
        distance = elementwise.hypot(*(motion.pose_world[:, :2] - motion.pose_world[0, :2]).T)
        near = np.flatnonzero(distance <= self._range)[1:]
        appearance = self._appearance_of([members[row] for row in near])
        ground_z, slope = self._contacts(members[0], appearance, motion, near)
        velocity_world, acceleration_world = motion.velocity_world[near], motion.acceleration_world[near]
        attitude = slope + self._attitudes(members[0], appearance, motion, near)
        actors = Actors(
            id=appearance.id,
            name=appearance.name,
            kind=appearance.kind,
            pose_world=motion.pose_world[near],
            velocity_world=velocity_world,
            acceleration_world=acceleration_world,
            yaw_rate=motion.yaw_rate[near],
            articulation=motion.articulation[near],
            further_articulation=motion.further_articulation[near],
            mode=self._classifier.modes(appearance.id, velocity_world, acceleration_world),
            changes_lane=motion.changes_lane[near],
            deviation=motion.deviation[near],
            ground_z=ground_z[1:],
            attitude=attitude[1:],
            size=appearance.size,
            reflectivity=appearance.reflectivity,
        )
        ego = Ego(
            pose_world=motion.pose_world[0],
            velocity_world=motion.velocity_world[0],
            acceleration_world=motion.acceleration_world[0],
            yaw_rate=float(motion.yaw_rate[0]),
            size=np.array(members[0].size),
            changes_lane=bool(motion.changes_lane[0]),
            deviation=motion.deviation[0],
            ground_z=float(ground_z[0]),
            attitude=attitude[0],
        )
        index, self._next = self._next, self._next + 1
        return WorldFrame(index=index, time=index * self._dt, ego=ego, actors=actors, collisions=motion.collisions)

    def _contacts(
        self, ego: Member, appearance: "_Appearance", motion: Kinematics, near: Ints
    ) -> tuple[Floats, Floats]:
        """Return height (1 + N,) [m] and slope (1 + N, 2) [rad] of the road under the ego and the actors at `near`."""
        if self._terrain is None:
            return np.zeros(1 + len(near)), np.zeros((1 + len(near), 2))
        rows, size = np.concatenate([[0], near]), np.concatenate([[ego.size], appearance.size])
        road = None if motion.road is None else motion.road[rows]
        return ground_contact(self._terrain, motion.pose_world[rows], size, road)

    def _attitudes(self, ego: Member, appearance: "_Appearance", motion: Kinematics, near: Ints) -> Floats:
        """Return pitch and roll (1 + N, 2) on the suspension of the ego and of the N actors at `near` [rad]."""
        if self._suspension is None:
            return np.zeros((1 + len(near), 2))
        rows = np.concatenate([[0], near])
        id, kind = np.concatenate([[ego.id], appearance.id]), np.concatenate([[ego.kind], appearance.kind])
        return self._suspension.attitude(id, kind, motion.pose_world[rows, 2], motion.acceleration_world[rows])

    def _appearance_of(self, members: list[Member]) -> "_Appearance":
        """Return the constant columns of the members, cached since they rarely change between frames."""
        if members != self._present:
            self._present, self._appearance = members, _Appearance.of(members)
        return self._appearance


@dataclass(frozen=True, slots=True, eq=False)
class _Appearance:
    """Columns of `Actors` that are constant over time."""

    id: Ints
    name: npt.NDArray[np.str_]
    kind: npt.NDArray[np.uint8]
    size: Floats
    reflectivity: Floats

    @classmethod
    def of(cls, members: list[Member]) -> "_Appearance":
        return cls(
            id=np.array([member.id for member in members], dtype=np.int64),
            name=np.array([member.name for member in members], dtype=np.str_),
            kind=np.array([member.kind for member in members], dtype=np.uint8),
            size=np.array([member.size for member in members], dtype=np.float64).reshape(-1, 3),
            reflectivity=np.array([member.reflectivity for member in members], dtype=np.float64),
        )
