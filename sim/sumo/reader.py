"""Who is near the ego in SUMO, read in bulk, and as far as SUMO's own search by place goes: cities cost no more.

SUMO tells the middle of the front bumper and an angle clockwise from north in degrees; a pose is the box centre, and
yaw is counter-clockwise from east.
"""

import math
from collections.abc import Iterator
from typing import Any

import numpy as np

from sim.arrays import Floats
from sim.kinematics import RawFrame
from sim.origin import origin_near
from sim.roster import EGO_ID, Member, Roster
from sim.sumo.parked_cars import Pose, Standing
from sim.sumo.parking import ParkedCar
from sim.sumo.teleports import Body, MemberNames, Parking, Point
from sim.sumo.vehicle_kinds import kind_of_shape
from sim.world import Kind

MARGIN = 60.0
"""[m] Read beyond the delivery range: what two who meet in a city drive in half the layer's smoothing window, and half
a long vehicle, for SUMO searches by front bumpers."""

_NOWHERE = -1e8
"""[m] SUMO gives -2^30 for who is not on the road."""
_HERE = "luxloop: around the ego"

_Row = tuple[Member, Pose, float]
"""With pose and speed [m/s]."""
_Results = dict[str, dict[int, Any]]


class SumoReader:
    """Reads frame after frame around an ego that is in the net.

    Parameters
    ----------
    sumo
        The libsumo module, running.
    ego
        The ego's SUMO id.
    cast
        Takes in whoever comes near, the ego at once.
    parked
        Cars that stand beside SUMO's traffic.
    range_m
        Delivery radius around the ego [m].
    dt
        Time between frames [s].
    """

    def __init__(self, sumo: Any, ego: str, cast: Roster, parked: list[ParkedCar], range_m: float, dt: float):
        self._sumo = sumo
        self._ego = ego
        self._range = range_m
        self._dt = dt
        self._vehicles = MemberNames(cast, "vehicle", self._vehicle_body)
        self._people = MemberNames(cast, "person", self._person_body)
        self._vehicles.member(ego)
        self._parking = Parking(sumo.simulation)
        self.origin: Floats = origin_near(np.array(sumo.vehicle.getPosition(ego)))
        self._east, self._north = self.origin.tolist()
        self._standing = Standing(cast, parked, self.origin, range_m + MARGIN)
        self.fate = ""
        self._subscribe()

    def vehicles_in_range(self) -> int:
        """Return how many vehicles but the ego are in delivery range; 0 if the ego is gone. For steps without `read`.

        People are sought around the ego after the next step, too, so that the first frame has them.
        """
        seen: _Results = self._sumo.vehicle.getContextSubscriptionResults(self._ego)
        if self._ego not in seen:
            return 0
        self._sumo.poi.setPosition(_HERE, *seen[self._ego][self._position])
        place = np.array([row[self._position] for row in seen.values()]) - seen[self._ego][self._position]
        return int((np.hypot(place[:, 0], place[:, 1]) <= self._range).sum()) - 1

    def read(self) -> RawFrame | None:
        """Return the present frame, or None if the ego is gone: then `fate` says how."""
        vehicles: _Results = self._sumo.vehicle.getContextSubscriptionResults(self._ego)
        people: _Results = self._sumo.poi.getContextSubscriptionResults(_HERE)
        teleported = self._sumo.simulation.getStartingTeleportIDList()
        if self._ego in teleported or self._ego not in vehicles:
            self.fate = "SUMO teleported it" if self._ego in teleported else "it arrived, or SUMO removed it"
            return None
        place = vehicles[self._ego][self._position]
        self._sumo.poi.setPosition(_HERE, *place)  # people are sought around it after the next step
        for name in filter(self._vehicles.knows, teleported):
            self._vehicles.renew(name)
        parks = self._parking.names(lambda name: vehicles[name][self._speed] if name in vehicles else None)
        rows = [
            *self._rows(self._vehicles, vehicles, {*parks} - {self._ego}),
            *self._rows(self._people, {name: row for name, row in people.items() if not row[self._ride]}, set()),
            *((member, pose, 0.0) for member, pose in self._standing.near(self._in_world(place))),
        ]
        rows.sort(key=lambda row: row[0].id)
        if rows[0][0].id != EGO_ID:
            self.fate = "SUMO put it elsewhere"
            return None
        return RawFrame(
            members=[member for member, _, _ in rows],
            pose_world=np.array([pose for _, pose, _ in rows]),
            speed=np.array([speed for _, _, speed in rows]),
        )

    def _rows(self, lives: MemberNames, seen: _Results, parks: set[str]) -> Iterator[_Row]:
        """Yield who is on the road, by name. A loop: after a step of a city, numpy's functions are cold."""
        lives.next_frame()
        for name in sorted(seen):
            row = seen[name]
            place, speed = row[self._position], row[self._speed]
            if place[0] < _NOWHERE:
                continue
            x, y = front = self._in_world(place)
            half, yaw = 0.5 * lives.member(name).size[0], math.pi - math.radians(90.0 + row[self._angle]) % math.tau
            centre = x - half * math.cos(yaw), y - half * math.sin(yaw)
            member = lives.seen(name, front, centre, abs(speed) * self._dt, name in parks)
            yield member, (*centre, yaw), speed

    def _in_world(self, place: Point) -> Point:
        """Take a point of the net into the world frame."""
        return place[0] - self._east, place[1] - self._north

    def _subscribe(self) -> None:
        """Let SUMO tell who is near.

        Vehicles and people may be namesakes, and SUMO tells the surroundings of a thing by name: those of the ego are
        the vehicles, those of a point that goes along with it are the people.
        """
        sumo, constants = self._sumo, self._sumo.constants
        self._position, self._angle, self._speed = constants.VAR_POSITION, constants.VAR_ANGLE, constants.VAR_SPEED
        self._ride = constants.VAR_VEHICLE
        radius, variables = self._range + MARGIN, [self._position, self._angle, self._speed]
        sumo.vehicle.subscribeContext(self._ego, constants.CMD_GET_VEHICLE_VARIABLE, radius, variables)
        sumo.poi.add(_HERE, *sumo.vehicle.getPosition(self._ego), (0, 0, 0, 0))
        sumo.poi.subscribeContext(_HERE, constants.CMD_GET_PERSON_VARIABLE, radius, [*variables, self._ride])

    def _vehicle_body(self, name: str) -> Body:
        vehicle = self._sumo.vehicle
        size = (vehicle.getLength(name), vehicle.getWidth(name), vehicle.getHeight(name))
        return kind_of_shape(vehicle.getShapeClass(name), size[2]), size

    def _person_body(self, name: str) -> Body:
        person = self._sumo.person
        height = self._sumo.vehicletype.getHeight(person.getTypeID(name))
        return Kind.PEDESTRIAN, (person.getLength(name), person.getWidth(name), height)
