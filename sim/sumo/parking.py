"""Parked cars on SUMO's parking areas, which are empty in SUMO until one of its vehicles stops there."""

import math
import re
import xml.etree.ElementTree as ET
import zlib
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from luxloop import elementary, elementwise
from luxloop.arrays import Floats
from luxloop.sim.roster import Member, Roster
from luxloop.sim.sumo.input_checks import input_files, is_left_hand, text_of
from luxloop.sim.sumo.teleports import Point
from luxloop.sim.world import Kind

_LANE_WIDTH = 3.2
"""[m] SUMO's default of lanes and places."""
_SPACE_LENGTH = 7.5
"""[m] SUMO's default."""


@dataclass(frozen=True, slots=True)
class Place:
    """Place for one vehicle."""

    name: str
    front: tuple[float, float]
    """Middle of the front bumper of a parked vehicle [m]."""
    yaw: float
    """[rad]"""
    length: float
    """[m]"""
    width: float
    """[m]"""


def places_of(area: ET.Element, lanes: Any, left_hand: bool) -> Iterator[Place]:
    """Yield the places of a `<parkingArea>`: roadside places, then its `<space>`s."""
    if area.get("onRoad", "false") in ("true", "1", "yes", "on"):
        return
    name, capacity = area.get("id", ""), int(area.get("roadsideCapacity", "0"))
    width = float(area.get("width", 0.0)) or _LANE_WIDTH
    length, angle = float(area.get("length", 0.0)), float(area.get("angle", 0.0))
    if capacity:
        side, step = _side(area, lanes, width, left_hand), _span(area, lanes) / capacity
        length = length or step
        for index in range(capacity):
            front, yaw = _roadside_pose(side, index, step, angle, width, length)
            yield Place(f"{name}.{index}", front, yaw, length, width)
    for index, space in enumerate(area.iter("space"), start=capacity):
        yield Place(
            f"{name}.{index}",
            (float(space.get("x", 0.0)), float(space.get("y", 0.0))),
            math.radians(float(space.get("angle", angle)) - 90.0),
            float(space.get("length", length)) or _SPACE_LENGTH,
            float(space.get("width", width)),
        )


def _limits(area: ET.Element, lanes: Any) -> tuple[float, float, float]:
    """Return the start and end of an area along its lane [m], and the lane's nominal length."""
    lane = area.get("lane", "")
    length = lanes.getLength(lane)
    ends = [float(area.get("startPos", 0.0)), float(area.get("endPos", length))]
    begin, end = (min(max(end + length if end < 0 else end, 0.0), length) for end in ends)
    return begin, end, length


def _span(area: ET.Element, lanes: Any) -> float:
    """Return an area's length along its lane's shape [m], which may differ from the lane's nominal length."""
    begin, end, length = _limits(area, lanes)
    return (end - begin) * float(arc_lengths(np.array(lanes.getShape(area.get("lane", ""))))[-1]) / length


def _side(area: ET.Element, lanes: Any, width: float, left_hand: bool) -> Floats:
    """Return the centre line (K, 2) [m] of the roadside places."""
    lane = area.get("lane", "")
    shape = np.array(lanes.getShape(lane), dtype=np.float64)[:, :2]
    begin, end, length = _limits(area, lanes)
    along = arc_lengths(shape)
    begin, end = begin * along[-1] / length, end * along[-1] / length
    inner = shape[(along > begin) & (along < end)]
    line = np.vstack([point_along(shape, begin), inner, point_along(shape, end)])
    to_the_right = (lanes.getWidth(lane) + width) / 2
    return offset_line(line, -to_the_right if left_hand else to_the_right)


def offset_line(line: Floats, right: float) -> Floats:
    """Offset a line (K, 2) to its right by `right` [m], with mitred corners."""
    step = np.diff(line, axis=0)
    normal = np.column_stack([step[:, 1], -step[:, 0]]) / elementwise.hypot(*step.T)[:, None]
    before, after = np.vstack([normal[:1], normal]), np.vstack([normal, normal[-1:]])
    mitre = (before + after) / (1.0 + np.sum(before * after, axis=1))[:, None]
    offset: Floats = line + right * mitre
    return offset


def _roadside_pose(
    side: Floats, index: int, step: float, angle_deg: float, width: float, length: float
) -> tuple[tuple[float, float], float]:
    """Return the front (2,) [m] and the yaw [rad] of a vehicle on a roadside place."""
    first, last = point_along(side, index * step), point_along(side, (index + 1) * step)
    course = elementary.atan2(*(last - first)[::-1])
    yaw = course - math.radians(angle_deg)
    if not angle_deg:
        return (float(last[0]), float(last[1])), yaw
    turn = math.fmod(angle_deg, 360.0)
    sine, cosine = elementary.sin(math.radians(turn)), elementary.cos(math.radians(turn))
    # SUMO rotates the places about a point that depends on the quadrant
    ahead = (step + length * cosine) / 2
    left = width / 2 * (1 - cosine if 0 <= turn <= 90 or turn > 270 else 1 + cosine)
    left -= length * sine if 0 <= turn <= 180 else 0.0
    x = first[0] + ahead * elementary.cos(course) - left * elementary.sin(course)
    y = first[1] + ahead * elementary.sin(course) + left * elementary.cos(course)
    return (float(x), float(y)), yaw


def arc_lengths(line: Floats) -> Floats:
    """Return the arc length at the points (K,) of a line (K, 2) [m]."""
    return np.concatenate([[0.0], np.cumsum(elementwise.hypot(*np.diff(line[:, :2], axis=0).T))])


def point_along(line: Floats, distance: float) -> Floats:
    """Return the point (2,) of a line at an arc length [m], limited to its ends."""
    along = arc_lengths(line)
    return np.array([np.interp(distance, along, line[:, axis]) for axis in (0, 1)])


DEFAULT_CAR = (5.0, 1.8, 1.5)
"""[m] Length, width, height of a car of SUMO's default type."""
SHORTEST, NARROWEST = 3.0, 1.4
"""[m] Smaller places are not for cars, and stay empty."""

_STOP_TARGET = re.compile(r"""parkingArea\s*=\s*["']([^"']+)|<parkingAreaReroute\s[^>]*?id\s*=\s*["']([^"']+)""")


@dataclass(frozen=True, slots=True)
class ParkedCar:
    """A car parked for the whole run."""

    name: str
    """Name of the parking area, and number of the place in it."""
    pose: tuple[float, float, float]
    """Box centre x [m], y [m], yaw [rad], in the net's coordinates."""
    size: tuple[float, float, float]
    """Length, width, height [m]."""
    kind: Kind


def parked_cars(command: Sequence[str], lanes: Any, fill: float, seed: int) -> list[ParkedCar]:
    """Return the cars on a random share of all parking places beside the road.

    Areas on the road stay empty, since SUMO's traffic would drive through the cars. So do areas that are targets of a
    stop or a rerouter.

    Parameters
    ----------
    command
        SUMO's command line, by `luxloop.sim.sumo.input_checks.sumo_command`. Its route and additional files are read.
    lanes
        libsumo's domain of lanes.
    fill
        Share of occupied places, 0 to 1.
    seed
        Seed of the run. The draw of each place is keyed by its name.
    """
    if not fill:
        return []
    texts = [text_of(path) for path in input_files(command)]
    areas = [area for text in texts if "<parkingArea" in text for area in ET.fromstring(text).iter("parkingArea")]
    busy = {name for text in texts for names in _STOP_TARGET.findall(text) for name in names}
    left_hand = is_left_hand(command)
    places = [place for area in areas if area.get("id") not in busy for place in places_of(area, lanes, left_hand)]
    return [_car(place) for place in places if _fits_a_car(place) and _draw(place, seed) < fill]


def _fits_a_car(place: Place) -> bool:
    return place.length >= SHORTEST and place.width >= NARROWEST


def _draw(place: Place, seed: int) -> float:
    """Draw a place's random number, 0 to 1, by (seed, name); by another key than its car's other draws."""
    key = np.array([seed % 2**64, zlib.crc32(place.name.encode())], dtype=np.uint64)
    return float(np.random.Generator(np.random.Philox(key=key, counter=[0, 0, 0, 3])).random())


def _car(place: Place) -> ParkedCar:
    size = (min(DEFAULT_CAR[0], place.length), min(DEFAULT_CAR[1], place.width), DEFAULT_CAR[2])
    x = place.front[0] - size[0] / 2 * elementary.cos(place.yaw)
    y = place.front[1] - size[0] / 2 * elementary.sin(place.yaw)
    return ParkedCar(place.name, (x, y, math.remainder(place.yaw, 2 * math.pi)), size, Kind.CAR)


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
