"""The last step of every traffic source: members and their motion become the world record."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from sim.arrays import Floats, Ints
from sim.kinematics import Kinematics
from sim.modes import ModeJudge, ModeLimits
from sim.roster import Member
from sim.world import Actors, Ego, WorldFrame


class FrameBuilder:
    """Builds the frames of one run, one after the other.

    Parameters
    ----------
    dt
        Time between frames [s].
    range_m
        Delivered are the ego, and all others whose centre is within this radius of the ego's [m].
    limits
        Of the motion modes.
    """

    def __init__(self, dt: float, range_m: float, limits: ModeLimits):
        self._dt = dt
        self._range = range_m
        self._judge = ModeJudge(limits)
        self._next = 0
        self._present: list[Member] = []
        self._looks = _Looks.of([])

    def frame(self, members: list[Member], motion: Kinematics) -> WorldFrame:
        """Return the next frame of N members by ascending number, the ego first, and their motion."""
        distance = np.hypot(*(motion.pose_world[:, :2] - motion.pose_world[0, :2]).T)
        near = np.flatnonzero(distance <= self._range)[1:]
        looks = self._looks_of([members[row] for row in near])
        velocity_world, acceleration_world = motion.velocity_world[near], motion.acceleration_world[near]
        actors = Actors(
            id=looks.id,
            name=looks.name,
            kind=looks.kind,
            pose_world=motion.pose_world[near],
            velocity_world=velocity_world,
            acceleration_world=acceleration_world,
            yaw_rate=motion.yaw_rate[near],
            articulation=motion.articulation[near],
            mode=self._judge.modes(looks.id, velocity_world, acceleration_world),
            changes_lane=motion.changes_lane[near],
            deviation=motion.deviation[near],
            size=looks.size,
            reflectivity=looks.reflectivity,
        )
        ego = Ego(
            pose_world=motion.pose_world[0],
            velocity_world=motion.velocity_world[0],
            acceleration_world=motion.acceleration_world[0],
            yaw_rate=float(motion.yaw_rate[0]),
            size=np.array(members[0].size),
            changes_lane=bool(motion.changes_lane[0]),
            deviation=motion.deviation[0],
        )
        index, self._next = self._next, self._next + 1
        return WorldFrame(index=index, time=index * self._dt, ego=ego, actors=actors)

    def _looks_of(self, members: list[Member]) -> "_Looks":
        """Return what does not change about members; mostly they are those of the frame before."""
        if members != self._present:
            self._present, self._looks = members, _Looks.of(members)
        return self._looks


@dataclass(frozen=True, slots=True, eq=False)
class _Looks:
    """Columns of `Actors` that stay."""

    id: Ints
    name: npt.NDArray[np.str_]
    kind: npt.NDArray[np.uint8]
    size: Floats
    reflectivity: Floats

    @classmethod
    def of(cls, members: list[Member]) -> "_Looks":
        return cls(
            id=np.array([member.id for member in members], dtype=np.int64),
            name=np.array([member.name for member in members], dtype=np.str_),
            kind=np.array([member.kind for member in members], dtype=np.uint8),
            size=np.array([member.size for member in members], dtype=np.float64).reshape(-1, 3),
            reflectivity=np.array([member.reflectivity for member in members], dtype=np.float64),
        )
