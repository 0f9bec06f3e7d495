"""Stub trackers with one known fault each, for tests of the grader. They receive the truth, as registered oracles."""

import cmath
import math
from dataclasses import dataclass, field, replace

import numpy as np
from support.frames import Estimate, compose, express, tracks_of

from luxloop.scenarios.run import device
from luxloop.sim.world import VEHICLE_KINDS

GHOST_ID = 999_999


@dataclass
class Perfect:
    """Reports the true box of every vehicle, visible or not, in the odometry frame."""

    frames: list = field(default_factory=list)
    points: list = field(default_factory=list)
    """Number of points on every actor, by frame."""
    odom: list = field(default_factory=list)

    def __init_subclass__(cls):
        device.ORACLES.add(cls)

    def see_truth(self, frame, truth):
        self.frames.append(frame)
        self.points.append({actor: int((truth.actor_id == actor).sum()) for actor in frame.actors.id.tolist()})

    def step(self, scan):
        self.odom.append(np.array(scan.ego_pose_odom))
        return tracks_of(self.estimates(len(self.odom) - 1))

    def estimates(self, index):
        actors, ego = self.frames[index].actors, self.frames[index].ego
        out = []
        for row, actor in enumerate(actors.id.tolist()):
            if actors.kind[row] in VEHICLE_KINDS:
                pose = compose(self.odom[index], express(ego.pose_world, actors.pose_world[row]))
                size, turn = tuple(actors.size[row, :2]), cmath.exp(1j * (self.odom[index][2] - ego.pose_world[2]))
                velocity, acceleration = (motion * turn for motion in corner_motion(actors, row))
                out.append(
                    Estimate(
                        actor,
                        *pose,
                        size,
                        velocity=(velocity.real, velocity.imag),
                        acceleration=(acceleration.real, acceleration.imag),
                    )
                )
        return out


device.ORACLES.add(Perfect)


def corner_motion(actors, row):
    """Velocity and acceleration of the front left corner of a rigid body, without a change of its yaw rate."""
    yaw_rate = actors.yaw_rate[row]
    corner = 0.5 * complex(*actors.size[row, :2]) * cmath.exp(1j * actors.pose_world[row, 2])
    velocity, acceleration = complex(*actors.velocity_world[row]), complex(*actors.acceleration_world[row])
    return velocity + 1j * yaw_rate * corner, acceleration - yaw_rate**2 * corner


@dataclass
class OneFrameLate(Perfect):
    """Reports the boxes of the previous frame."""

    def estimates(self, index):
        return super().estimates(max(index - 1, 0))


@dataclass
class IdSwapping(Perfect):
    """Swaps the ids of two actors from frame `at` on."""

    pair: tuple = (0, 1)
    at: int = 0

    def estimates(self, index):
        a, b = self.pair
        swap = {a: b, b: a} if index >= self.at else {}
        return [replace(e, id=swap.get(e.id, e.id)) for e in super().estimates(index)]


@dataclass
class BiasedYaw(Perfect):
    """Rotates every box about its centre."""

    bias_deg: float = 0.0

    def estimates(self, index):
        turn = math.radians(self.bias_deg)
        return [replace(e, heading=e.heading + turn) for e in super().estimates(index)]


@dataclass
class GhostMaking(Perfect):
    """Adds a false track at the position `at` in the ego frame [m]."""

    at: tuple = (0.0, 25.0)

    def estimates(self, index):
        return [*super().estimates(index), Estimate(GHOST_ID, *compose(self.odom[index], (*self.at, 0.0)))]


@dataclass
class Forgetful(Perfect):
    """Drops an actor without points, and gives it a new id when it has points again."""

    lost: dict = field(default_factory=dict)

    def estimates(self, index):
        out = []
        for e in super().estimates(index):
            hidden, times = self.lost.get(e.id, (False, 0))
            seen = self.points[index][e.id] > 0
            self.lost[e.id] = (not seen, times + (hidden and seen))
            if seen:
                out.append(replace(e, id=e.id + 10_000 * self.lost[e.id][1]))
        return out
