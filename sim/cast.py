"""Who is on the road: numbers, paint and the frame around the ego, the same for every traffic source."""

from collections.abc import Hashable
from dataclasses import dataclass

import numpy as np

from sim.kinematics import Rates
from sim.paint import paint_reflectivity
from sim.redraw import redrawn_size
from sim.world import Actors, Ego, Floats, Kind, WorldFrame

EGO_ID = 0
"""The ego is the first to be cast; actors count from 1."""


@dataclass(frozen=True, slots=True)
class Member:
    """What does not change about a road user."""

    id: int
    name: str
    kind: Kind
    size: tuple[float, float, float]
    """Length, width, height [m]."""
    reflectivity: float


class Cast:
    """Everyone who has appeared in a run, numbered in order of appearance. Numbers are never reused.

    Parameters
    ----------
    seed
        Of the run.
    redraw_default_sizes
        Whether all but the ego, which is to fit its rig, get a size of their own in place of the simulator's default.
    """

    def __init__(self, seed: int, *, redraw_default_sizes: bool = False):
        self._seed = seed
        self._redraw = redraw_default_sizes
        self._members: dict[Hashable, Member] = {}

    def find(self, key: Hashable) -> Member | None:
        """Return the member whom the simulator calls `key`, or None before its first appearance."""
        return self._members.get(key)

    def enter(
        self,
        key: Hashable,
        kind: Kind,
        size: tuple[float, float, float],
        name: str = "",
        reflectivity: float | None = None,
    ) -> Member:
        """Cast a new member. Without a name it is `<kind>.<number>`; without reflectivity its paint is drawn."""
        number = len(self._members)
        if self._redraw and number != EGO_ID:
            size = redrawn_size(kind, size, self._seed, number)
        self._members[key] = Member(
            id=number,
            name=name or f"{kind.name.lower()}.{number}",
            kind=kind,
            size=size,
            reflectivity=paint_reflectivity(self._seed, number) if reflectivity is None else reflectivity,
        )
        return self._members[key]


def frame_around_ego(
    index: int, dt: float, members: list[Member], pose_world: Floats, rates: Rates, range_m: float
) -> WorldFrame:
    """Build the frame: the ego, and of all others those whose centre is within `range_m` of the ego's.

    Parameters
    ----------
    index, dt
        Number of the frame and time between frames [s].
    members
        N members by ascending number, the ego first.
    pose_world
        (N, 3) x [m], y [m], yaw [rad].
    rates
        Rates of the N poses.
    range_m
        Delivery radius [m].
    """
    distance = np.hypot(*(pose_world[:, :2] - pose_world[0, :2]).T)
    near = np.flatnonzero(distance <= range_m)[1:]
    size = np.array([member.size for member in members], dtype=np.float64)
    ego = Ego(
        pose_world=pose_world[0],
        velocity_world=rates.velocity_world[0],
        acceleration_world=rates.acceleration_world[0],
        yaw_rate=float(rates.yaw_rate[0]),
        size=size[0],
    )
    actors = Actors(
        id=np.array([members[n].id for n in near], dtype=np.int64),
        name=np.array([members[n].name for n in near], dtype=np.str_),
        kind=np.array([members[n].kind for n in near], dtype=np.uint8),
        pose_world=pose_world[near],
        velocity_world=rates.velocity_world[near],
        acceleration_world=rates.acceleration_world[near],
        yaw_rate=rates.yaw_rate[near],
        size=size[near],
        reflectivity=np.array([members[n].reflectivity for n in near], dtype=np.float64),
    )
    return WorldFrame(index=index, time=index * dt, ego=ego, actors=actors)
