"""Geometry of SUMO's parking areas: positions of parked vehicles in SUMO 1.28, determined by experiment."""

import math
import xml.etree.ElementTree as ET
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from luxloop import elementary, elementwise
from luxloop.arrays import Floats

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
