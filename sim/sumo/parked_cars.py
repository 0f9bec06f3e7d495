"""Cars that stand in parking spaces for the whole run, and are no part of SUMO's traffic."""

import math

import numpy as np

from sim.arrays import Floats
from sim.roster import Member, Roster
from sim.sumo.parking import ParkedCar
from sim.sumo.teleports import Point

Pose = tuple[float, float, float]

_STRIDE = 20.0
"""[m] After so much of the ego's way all cars are looked at anew, in between only those that can be near."""


class Standing:
    """The parked cars of a run.

    Parameters
    ----------
    cast
        Takes in whoever comes near.
    cars
        All parked cars, by name.
    origin
        (2,) of the world, in the net's coordinates [m].
    radius
        Of what is near [m].
    """

    def __init__(self, cast: Roster, cars: list[ParkedCar], origin: Floats, radius: float):
        self._cast = cast
        self._cars = cars
        self._radius = radius
        self._pose = np.array([car.pose for car in cars]).reshape(-1, 3) - (*origin, 0.0)
        self._centre = (math.inf, math.inf)
        self._close: list[tuple[ParkedCar, Pose]] = []

    def near(self, place: Point) -> list[tuple[Member, Pose]]:
        """Return who stands near a place [m], with poses."""
        if math.dist(place, self._centre) > _STRIDE:
            self._centre = place
            distance = np.hypot(self._pose[:, 0] - place[0], self._pose[:, 1] - place[1])
            rows = np.flatnonzero(distance <= self._radius + _STRIDE).tolist()
            self._close = [(self._cars[row], tuple(self._pose[row].tolist())) for row in rows]
        return [(self._member(car), pose) for car, pose in self._close if math.dist(pose[:2], place) <= self._radius]

    def _member(self, car: ParkedCar) -> Member:
        key = ("parked", car.name)
        return self._cast.find(key) or self._cast.enter(key, car.kind, car.size, car.name)
