"""Trackers with one known fault each, to test the grader with. They are handed the truth when made, not in a scan."""

import math
from dataclasses import dataclass, replace

from support.frames import Estimate, compose, express, tracks_of

GHOST_ID = 999


@dataclass
class Perfect:
    """Reports every actor's true box, in the odometry frame of the scan."""

    frames: list
    index: int = -1

    def step(self, scan):
        self.index += 1
        return tracks_of(self.estimates(self.index, scan)), None

    def estimates(self, index, scan):
        actors, ego = self.frames[index].actors, self.frames[index].ego
        out = []
        for actor, pose, size in zip(actors.id.tolist(), actors.pose_world, actors.size, strict=True):
            x, y, heading = compose(scan.ego_pose_odom, express(ego.pose_world, pose))
            out.append(Estimate(actor, x, y, heading, tuple(size[:2])))
        return out


@dataclass
class OneFrameLate(Perfect):
    """Reports where everything was in the frame before; the ego must stand still."""

    def estimates(self, index, scan):
        return super().estimates(max(index - 1, 0), scan)


@dataclass
class IdSwapping(Perfect):
    """Swaps the ids of two actors from frame `at` on."""

    pair: tuple = (0, 1)
    at: int = 0

    def estimates(self, index, scan):
        a, b = self.pair
        swap = {a: b, b: a} if index >= self.at else {}
        return [replace(e, id=swap.get(e.id, e.id)) for e in super().estimates(index, scan)]


@dataclass
class BiasedYaw(Perfect):
    """Turns every box about its centre."""

    bias_deg: float = 0.0

    def estimates(self, index, scan):
        turn = math.radians(self.bias_deg)
        return [replace(e, heading=e.heading + turn) for e in super().estimates(index, scan)]


@dataclass
class GhostMaking(Perfect):
    """Adds a track on nothing, `at` in the odometry frame."""

    at: tuple = (0.0, 25.0)

    def estimates(self, index, scan):
        return [*super().estimates(index, scan), Estimate(GHOST_ID, *self.at)]


@dataclass
class Forgetful(Perfect):
    """Gives an actor a new id each time it comes back from having no points; `points[index][actor]` tells."""

    points: list = None
    lost: dict = None

    def estimates(self, index, scan):
        self.lost = self.lost or {}
        out = []
        for e in super().estimates(index, scan):
            hidden, times = self.lost.get(e.id, (False, 0))
            seen = self.points[index][e.id] > 0
            self.lost[e.id] = (not seen, times + (hidden and seen))
            if seen:
                out.append(replace(e, id=e.id + 100 * self.lost[e.id][1]))
        return out
