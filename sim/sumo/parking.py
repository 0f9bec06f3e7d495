"""Parked cars on SUMO's parking areas, which SUMO itself leaves empty until one of its vehicles stops there.

Places lie where SUMO 1.28 puts the vehicles that park on them; its geometry was found by parking some.
"""

import math
import re
import xml.etree.ElementTree as ET
import zlib
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from sim.paint import actor_rng
from sim.sumo.input import input_files, is_left_hand, text_of
from sim.world import Floats, Kind

DEFAULT_CAR = (5.0, 1.8, 1.5)
"""[m] Length, width, height of a car of SUMO's default type."""
SHORTEST, NARROWEST = 3.0, 1.4
"""[m] Places that are smaller are not for cars, and stay empty."""

_LANE_WIDTH = 3.2
"""[m] SUMO's default, of places, too."""
_PARKING_STREAM = 3
"""Of the counter-based draws; the others are in `sim.paint` and `sim.redraw`."""
_SENT_TO = re.compile(r"""parkingArea\s*=\s*["']([^"']+)|<parkingAreaReroute\s[^>]*?id\s*=\s*["']([^"']+)""")


@dataclass(frozen=True, slots=True)
class ParkedCar:
    """A car that stands on a place for the whole run."""

    name: str
    """Of the parking area, and the place's number in it."""
    pose: tuple[float, float, float]
    """Box centre x [m], y [m], yaw [rad], in the net's coordinates."""
    size: tuple[float, float, float]
    """Length, width, height [m]."""
    kind: Kind


@dataclass(frozen=True, slots=True)
class Place:
    """Where one vehicle can park."""

    name: str
    front: tuple[float, float]
    """Middle of the front bumper of whoever parks [m]."""
    yaw: float
    """[rad]"""
    length: float
    """[m]"""
    width: float
    """[m]"""


def parked_cars(command: Sequence[str], lanes: Any, fill: float, seed: int) -> list[ParkedCar]:
    """Return the cars that stand on a share of all places beside the road.

    Areas on the road stay empty, since SUMO's traffic would drive through the cars; so do those that a stop or a
    rerouter sends vehicles to.

    Parameters
    ----------
    command
        SUMO's command line, by `sim.sumo.input.sumo_command`. Its route and additional files are read.
    lanes
        libsumo's domain of lanes.
    fill
        Share of the places that are taken, 0 to 1.
    seed
        Of the run. Every place has a draw of its own, by its name.
    """
    if not fill:
        return []
    texts = [text_of(path) for path in input_files(command)]
    areas = [area for text in texts if "<parkingArea" in text for area in ET.fromstring(text).iter("parkingArea")]
    busy = {name for text in texts for names in _SENT_TO.findall(text) for name in names}
    left_hand = is_left_hand(command)
    places = [place for area in areas if area.get("id") not in busy for place in _places(area, lanes, left_hand)]
    return [_car(place) for place in places if _takes_a_car(place) and _drawn(place, seed) < fill]


def _places(area: ET.Element, lanes: Any, left_hand: bool) -> Iterator[Place]:
    """Yield the places of a `<parkingArea>`: those along the road, then its `<space>`s."""
    if area.get("onRoad", "false") in ("true", "1", "yes", "on"):
        return
    name, capacity = area.get("id", ""), int(area.get("roadsideCapacity", "0"))
    width = float(area.get("width", 0.0)) or _LANE_WIDTH
    length, angle = float(area.get("length", 0.0)), float(area.get("angle", 0.0))
    if capacity:
        side, step = _side(area, lanes, width, left_hand), _span(area, lanes) / capacity
        length = length or step
        for index in range(capacity):
            front, yaw = _roadside(side, index, step, angle, width, length)
            yield Place(f"{name}.{index}", front, yaw, length, width)
    for index, space in enumerate(area.iter("space"), start=capacity):
        yield Place(
            f"{name}.{index}",
            (float(space.get("x", 0.0)), float(space.get("y", 0.0))),
            math.radians(float(space.get("angle", angle)) - 90.0),
            float(space.get("length", length)) or 7.5,
            float(space.get("width", width)),
        )


def _limits(area: ET.Element, lanes: Any) -> tuple[float, float, float]:
    """Return where an area begins and ends [m] along its lane's shape, and the lane's length."""
    lane = area.get("lane", "")
    length = lanes.getLength(lane)
    ends = [float(area.get("startPos", 0.0)), float(area.get("endPos", length))]
    begin, end = (min(max(end + length if end < 0 else end, 0.0), length) for end in ends)
    return begin, end, length


def _span(area: ET.Element, lanes: Any) -> float:
    """Return an area's length along its lane's shape [m], which need not be as long as the lane is said to be."""
    begin, end, length = _limits(area, lanes)
    return (end - begin) * float(_along(np.array(lanes.getShape(area.get("lane", ""))))[-1]) / length


def _side(area: ET.Element, lanes: Any, width: float, left_hand: bool) -> Floats:
    """Return the middle line (K, 2) [m] of the places along the road."""
    lane = area.get("lane", "")
    shape = np.array(lanes.getShape(lane), dtype=np.float64)[:, :2]
    begin, end, length = _limits(area, lanes)
    along = _along(shape)
    begin, end = begin * along[-1] / length, end * along[-1] / length
    inner = shape[(along > begin) & (along < end)]
    line = np.vstack([_point(shape, begin), inner, _point(shape, end)])
    to_the_right = (lanes.getWidth(lane) + width) / 2
    return _moved(line, -to_the_right if left_hand else to_the_right)


def _moved(line: Floats, right: float) -> Floats:
    """Move a line (K, 2) to its right by `right` [m], with mitred corners."""
    step = np.diff(line, axis=0)
    normal = np.column_stack([step[:, 1], -step[:, 0]]) / np.hypot(*step.T)[:, None]
    before, after = np.vstack([normal[:1], normal]), np.vstack([normal, normal[-1:]])
    mitre = (before + after) / (1.0 + np.sum(before * after, axis=1))[:, None]
    moved: Floats = line + right * mitre
    return moved


def _roadside(
    side: Floats, index: int, step: float, angle_deg: float, width: float, length: float
) -> tuple[tuple[float, float], float]:
    """Return the front (2,) [m] and the yaw [rad] of a vehicle on a place along the road."""
    first, last = _point(side, index * step), _point(side, (index + 1) * step)
    course = math.atan2(*(last - first)[::-1])
    yaw = course - math.radians(angle_deg)
    if not angle_deg:
        return (float(last[0]), float(last[1])), yaw
    turn = math.fmod(angle_deg, 360.0)
    sine, cosine = math.sin(math.radians(turn)), math.cos(math.radians(turn))
    # SUMO turns the places round a point that depends on the quadrant
    ahead = (step + length * cosine) / 2
    left = width / 2 * (1 - cosine if 0 <= turn <= 90 or turn > 270 else 1 + cosine)
    left -= length * sine if 0 <= turn <= 180 else 0.0
    x = first[0] + ahead * math.cos(course) - left * math.sin(course)
    y = first[1] + ahead * math.sin(course) + left * math.cos(course)
    return (float(x), float(y)), yaw


def _along(line: Floats) -> Floats:
    """Return how far along a line (K, 2) its points lie (K,) [m]."""
    return np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(line[:, :2], axis=0).T))])


def _point(line: Floats, distance: float) -> Floats:
    """Return the point (2,) of a line at a distance from its beginning [m], within its ends."""
    along = _along(line)
    return np.array([np.interp(distance, along, line[:, axis]) for axis in (0, 1)])


def _takes_a_car(place: Place) -> bool:
    return place.length >= SHORTEST and place.width >= NARROWEST


def _drawn(place: Place, seed: int) -> float:
    """Draw a place's number, 0 to 1."""
    return float(actor_rng(seed, zlib.crc32(place.name.encode()), _PARKING_STREAM).random())


def _car(place: Place) -> ParkedCar:
    size = (min(DEFAULT_CAR[0], place.length), min(DEFAULT_CAR[1], place.width), DEFAULT_CAR[2])
    x = place.front[0] - size[0] / 2 * math.cos(place.yaw)
    y = place.front[1] - size[0] / 2 * math.sin(place.yaw)
    return ParkedCar(place.name, (x, y, math.remainder(place.yaw, 2 * math.pi)), size, Kind.CAR)
