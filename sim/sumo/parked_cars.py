"""Cars parked beside the road for the whole run, independent of SUMO's traffic."""

import math

import numpy as np

from luxloop import elementwise
from luxloop.arrays import Floats
from luxloop.sim.roster import Member, Roster
from luxloop.sim.sumo.parking import ParkedCar
from luxloop.sim.sumo.teleports import Point

Pose = tuple[float, float, float]

_REFRESH_DISTANCE_M = 20.0
"""[m] Distance of the ego after which the candidates near it are selected again from all parked cars."""


class ParkedCars:
    """The parked cars of a run.

    Parameters
    ----------
    roster
        Registers cars that come near.
    cars
        All parked cars, by name.
    origin
        (2,) origin of the world frame, in the net's coordinates [m].
    radius
        Range of nearby cars [m].
    """

    def __init__(self, roster: Roster, cars: list[ParkedCar], origin: Floats, radius: float):
        self._roster = roster
        self._cars = cars
        self._radius = radius
        self._pose = np.array([car.pose for car in cars]).reshape(-1, 3) - (*origin, 0.0)
        self._centre = (math.inf, math.inf)
        self._candidates: list[tuple[ParkedCar, Pose]] = []

    def near(self, place: Point) -> list[tuple[Member, Pose]]:
        """Return the parked cars near a position [m], with poses."""
        if math.dist(place, self._centre) > _REFRESH_DISTANCE_M:
            self._centre = place
            distance = elementwise.hypot(self._pose[:, 0] - place[0], self._pose[:, 1] - place[1])
            rows = np.flatnonzero(distance <= self._radius + _REFRESH_DISTANCE_M).tolist()
            self._candidates = [(self._cars[row], tuple(self._pose[row].tolist())) for row in rows]
        return [
            (self._member(car), pose) for car, pose in self._candidates if math.dist(pose[:2], place) <= self._radius
        ]

    def _member(self, car: ParkedCar) -> Member:
        key = ("parked", car.name)
        return self._roster.find(key) or self._roster.add(key, car.kind, car.size, car.name)
