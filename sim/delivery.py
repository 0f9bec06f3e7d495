"""The last step of every traffic source: members and their motion become the world record."""

import numpy as np

from sim.cast import Member
from sim.kinematics import Kinematics
from sim.modes import ModeJudge, ModeLimits
from sim.world import Actors, Ego, WorldFrame


class Delivery:
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

    def frame(self, members: list[Member], motion: Kinematics) -> WorldFrame:
        """Return the next frame of N members by ascending number, the ego first, and their motion."""
        distance = np.hypot(*(motion.pose_world[:, :2] - motion.pose_world[0, :2]).T)
        near = np.flatnonzero(distance <= self._range)[1:]
        present = [members[row] for row in near]
        ego = Ego(
            pose_world=motion.pose_world[0],
            velocity_world=motion.velocity_world[0],
            acceleration_world=motion.acceleration_world[0],
            yaw_rate=float(motion.yaw_rate[0]),
            size=np.array(members[0].size),
            deviation=motion.deviation[0],
        )
        id = np.array([member.id for member in present], dtype=np.int64)
        velocity_world, acceleration_world = motion.velocity_world[near], motion.acceleration_world[near]
        actors = Actors(
            id=id,
            name=np.array([member.name for member in present], dtype=np.str_),
            kind=np.array([member.kind for member in present], dtype=np.uint8),
            pose_world=motion.pose_world[near],
            velocity_world=velocity_world,
            acceleration_world=acceleration_world,
            yaw_rate=motion.yaw_rate[near],
            articulation=motion.articulation[near],
            mode=self._judge.modes(id, velocity_world, acceleration_world),
            changes_lane=motion.changes_lane[near],
            deviation=motion.deviation[near],
            size=np.array([member.size for member in present], dtype=np.float64).reshape(-1, 3),
            reflectivity=np.array([member.reflectivity for member in present], dtype=np.float64),
        )
        index, self._next = self._next, self._next + 1
        return WorldFrame(index=index, time=index * self._dt, ego=ego, actors=actors)
