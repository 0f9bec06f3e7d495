"""Bulk reader of the road users near the ego in SUMO. Its cost does not depend on the size of the net.

SUMO reports the middle of the front bumper and an angle clockwise from north in degrees. Poses use the box centre, and
yaw counter-clockwise from east.
"""

import math
from collections.abc import Iterable, Iterator
from typing import Any

import numpy as np

from luxloop import elementary, elementwise
from luxloop.arrays import Floats
from luxloop.sim.kinematics import RawFrame, origin_near
from luxloop.sim.roster import EGO_ID, Member, Roster
from luxloop.sim.sumo.parking import ParkedCar, ParkedCars, Pose
from luxloop.sim.sumo.roadside_stops import RoadsideStops
from luxloop.sim.sumo.teleports import Body, MemberNames, ParkingManoeuvres, Point
from luxloop.sim.sumo.vehicles import kind_of_shape, yaw_of
from luxloop.sim.world import Collision, Kind

MARGIN = 60.0
"""[m] Margin beyond the delivery range: the distance of two vehicles approaching each other in a city within half the
smoothing window, plus half a long vehicle, since SUMO searches by front bumper."""

_OFF_ROAD_M = -1e8
"""[m] SUMO reports -2^30 for road users that are not on the road."""
_NO_ROAD = math.nan, math.nan  # of a parked car
_EGO_POI = "luxloop: around the ego"

_UNSEEN = -1  # id in a collision of a road user that was in no frame

_Row = tuple[Member, Pose, float]
"""Member, pose and speed [m/s]."""
_Results = dict[str, dict[int, Any]]


class SumoReader:
    """Reader of frames around an ego that is in the net.

    Parameters
    ----------
    sumo
        The libsumo module, running.
    ego
        The ego's SUMO id.
    roster
        Registers the road users that come near, the ego first.
    parked
        Parked cars independent of SUMO's traffic.
    range_m
        Delivery radius around the ego [m].
    dt
        Time between frames [s].
    left_hand
        Traffic keeps to the left.
    bridges
        If True, frames have the heights of the roads.
    """

    def __init__(
        self, sumo: Any, ego: str, roster: Roster, parked: list[ParkedCar], range_m: float, dt: float, *,
        left_hand: bool = False, bridges: bool = False,
    ):  # fmt: skip
        self._sumo = sumo
        self._ego = ego
        self._range = range_m
        self._dt = dt
        self._bridges = bridges
        self._road: dict[int, tuple[float, float]] = {}
        self._vehicles = MemberNames(roster, "vehicle", self._vehicle_body, dt)
        self._people = MemberNames(roster, "person", self._person_body, dt)
        self._vehicles.member(ego)
        self._parking = ParkingManoeuvres(sumo.simulation)
        self._stops = RoadsideStops(sumo, dt, left_hand=left_hand)
        self.origin: Floats = origin_near(np.array(sumo.vehicle.getPosition(ego)))
        self._east, self._north = self.origin.tolist()
        self._parked = ParkedCars(roster, parked, self.origin, range_m + MARGIN)
        self.collisions: tuple[Collision, ...] = ()
        """Collisions of the ego in the last step that was read, and that no frame shows."""
        self._shows_collisions = keeps_collided(sumo)
        self.end_reason = ""
        crossed = has_internal_lanes(sumo)
        self.warnings = () if crossed else (WARNING,)
        self._missing_lanes = "" if crossed else f", since {NO_INTERNAL_LINKS}; build the net again without this option"
        self._subscribe()

    def vehicles_in_range(self) -> int:
        """Return the number of other vehicles in delivery range, 0 if the ego is gone. Use it in steps without `read`.

        It also moves the search for pedestrians to the ego, so that the first frame contains them.
        """
        results: _Results = self._sumo.vehicle.getContextSubscriptionResults(self._ego)
        if self._ego not in results:
            return 0
        self._sumo.poi.setPosition(_EGO_POI, *results[self._ego][self._position])
        place = np.array([row[self._position] for row in results.values()]) - results[self._ego][self._position]
        return int((elementwise.hypot(place[:, 0], place[:, 1]) <= self._range).sum()) - 1

    def read(self) -> RawFrame | None:
        """Return the present frame, or None if the ego is gone; `end_reason` then contains the cause."""
        vehicles: _Results = self._sumo.vehicle.getContextSubscriptionResults(self._ego)
        people: _Results = self._sumo.poi.getContextSubscriptionResults(_EGO_POI)
        teleported = self._sumo.simulation.getStartingTeleportIDList()
        self.collisions = self._ego_collisions()
        if self._ego in teleported or self._ego not in vehicles:
            self.end_reason = self._reason_of_absence(teleported)
            return None
        place = vehicles[self._ego][self._position]
        self._sumo.poi.setPosition(_EGO_POI, *place)  # centre of the search for pedestrians in the next step
        for name in filter(self._vehicles.knows, teleported):
            self._vehicles.start_new_member(name)
        self._road.clear()
        parking = self._parking.names(lambda name: vehicles[name][self._speed] if name in vehicles else None)
        shifts = self._stops.shifts({name: row[self._speed] for name, row in vehicles.items()})
        on_foot = {name: row for name, row in people.items() if not row[self._carrier]}
        rows = [
            *self._rows(self._vehicles, vehicles, {*parking} - {self._ego}, shifts),
            *self._rows(self._people, on_foot, set(), {}),
            *((member, pose, 0.0) for member, pose in self._parked.near(self._in_world(place))),
        ]
        rows.sort(key=lambda row: row[0].id)
        if rows[0][0].id != EGO_ID:
            self.end_reason = "SUMO moved it to another place" + self._missing_lanes
            return None
        return RawFrame(
            members=[member for member, _, _ in rows],
            pose_world=np.array([pose for _, pose, _ in rows]),
            speed=np.array([speed for _, _, speed in rows]),
            road=np.array([self._road.get(member.id, _NO_ROAD) for member, _, _ in rows]) if self._bridges else None,
            collisions=self.collisions,
        )

    def _ego_collisions(self) -> tuple[Collision, ...]:
        """Return the collisions of the ego in this step. Call it before those that teleport become new members."""
        if self._shows_collisions:
            return ()
        found = collision_partners(self._sumo.simulation.getCollisions(), self._ego)
        return tuple(Collision(self._id_of(name), name, speed) for name, speed in found)

    def _id_of(self, name: str) -> int:
        """Return the id of a vehicle or person of this SUMO name."""
        ids = (names.id_of(name) for names in (self._vehicles, self._people))
        return next((id for id in ids if id is not None), _UNSEEN)

    def _reason_of_absence(self, teleported: tuple[str, ...]) -> str:
        """Return why the ego is gone: SUMO removes or teleports vehicles that collide, without `collision.action`."""
        others = collision_partners(self._sumo.simulation.getCollisions(), self._ego)
        if others:
            what = "teleported" if self._ego in teleported else "removed"
            return (
                f'it collided with "{others[0][0]}", and SUMO {what} it; let drivers keep their distance, or set '
                'options."collision.action" = "warn" to keep both on the road'
            )
        if self._ego in teleported:
            return "SUMO teleported it out of a jam; raise options.time-to-teleport"
        return "it arrived, or SUMO removed it"

    def _rows(
        self, names: MemberNames, results: _Results, parking: set[str], shifts: dict[str, Point]
    ) -> Iterator[_Row]:
        """Yield the road users on the road, by name. A Python loop: numpy calls are slower with cold caches."""
        names.next_frame()
        for name in sorted(results):
            row = results[name]
            place, speed = row[self._position], row[self._speed]
            if place[0] < _OFF_ROAD_M:
                continue
            x, y = self._in_world(place)
            half, yaw = 0.5 * names.member(name).size[0], yaw_of(row[self._angle])
            cos, sin = elementary.cos(yaw), elementary.sin(yaw)
            if name in shifts:
                ahead, left = shifts[name]
                x, y = x + ahead * cos - left * sin, y + ahead * sin + left * cos
            front, centre = (x, y), (x - half * cos, y - half * sin)
            member = names.observe(name, front, centre, abs(speed) * self._dt, name in parking)
            if self._bridges:
                slope = math.radians(row[self._slope])
                self._road[member.id] = row[self._position_3d][2] - half * elementary.sin(slope), slope
            yield member, (*centre, yaw), speed

    def _in_world(self, place: Point) -> Point:
        """Transform a point of the net to the world frame."""
        return place[0] - self._east, place[1] - self._north

    def _subscribe(self) -> None:
        """Subscribe to the road users near the ego.

        SUMO keys the results by the name of the centre object, and a vehicle and a pedestrian may have the same name.
        Vehicles are therefore searched around the ego, and pedestrians around a point of interest that moves with it.
        """
        sumo, constants = self._sumo, self._sumo.constants
        self._position, self._angle, self._speed = constants.VAR_POSITION, constants.VAR_ANGLE, constants.VAR_SPEED
        self._carrier = constants.VAR_VEHICLE
        self._position_3d, self._slope = constants.VAR_POSITION3D, constants.VAR_SLOPE
        radius, variables = self._range + MARGIN, [self._position, self._angle, self._speed]
        if self._bridges:
            variables += [self._position_3d, self._slope]
        sumo.vehicle.subscribeContext(self._ego, constants.CMD_GET_VEHICLE_VARIABLE, radius, variables)
        sumo.poi.add(_EGO_POI, *sumo.vehicle.getPosition(self._ego), (0, 0, 0, 0))
        sumo.poi.subscribeContext(_EGO_POI, constants.CMD_GET_PERSON_VARIABLE, radius, [*variables, self._carrier])

    def _vehicle_body(self, name: str) -> Body:
        vehicle = self._sumo.vehicle
        size = (vehicle.getLength(name), vehicle.getWidth(name), vehicle.getHeight(name))
        return kind_of_shape(vehicle.getShapeClass(name), size[2]), size

    def _person_body(self, name: str) -> Body:
        person = self._sumo.person
        height = self._sumo.vehicletype.getHeight(person.getTypeID(name))
        return Kind.PEDESTRIAN, (person.getLength(name), person.getWidth(name), height)


NO_INTERNAL_LINKS = "the net has no lanes across its junctions (netconvert --no-internal-links)"

WARNING = (
    f"{NO_INTERNAL_LINKS}: vehicles jump across them, with accelerations that no vehicle has "
    "(sim.teleports, sim.limit_violations); build the net again without this option"
)
"""Warning about a net without internal lanes."""


def has_internal_lanes(sumo: Any) -> bool:
    """Return True if lanes lead across the junctions of the net, or no junction is crossed.

    Parameters
    ----------
    sumo
        The libsumo module, running.
    """
    lanes = sumo.lane.getIDList()
    return any(lane.startswith(":") for lane in lanes) or not any(sumo.lane.getLinkNumber(lane) for lane in lanes)


def keeps_collided(sumo: Any) -> bool:
    """Return True if vehicles that collide drive on (`collision.action` is `warn`): frames then show their overlap.

    SUMO also reports gaps below `minGap` as collisions, so that its report is not needed there, and often wrong.
    """
    return str(sumo.simulation.getOption("collision.action")) == "warn"


def collision_partners(collisions: Iterable[Any], name: str) -> list[tuple[str, float]]:
    """Return the other road user in each collision of a vehicle, and the speed of the collider [m/s].

    Parameters
    ----------
    collisions
        Collisions of a step, as libsumo reports them.
    """
    pairs = (((str(one.collider), str(one.victim)), float(one.colliderSpeed)) for one in collisions)
    return [(pair[pair[0] == name], speed) for pair, speed in pairs if name in pair]
