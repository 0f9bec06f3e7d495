"""Positions of a storyboard on the road network."""

import math

from luxloop.sim.opendrive.road import Road
from luxloop.sim.opendrive.road_network import RoadNetwork
from luxloop.sim.openscenario.storyboard import (
    Entity,
    EntityCondition,
    LanePlace,
    Place,
    RelativePlace,
    Storyboard,
    WorldPlace,
)
from luxloop.sim.openscenario.traveller import Traveller
from luxloop.sim.xml_tree import XmlElement

ALIGNED_RAD = 0.35
"""[rad] Largest angle between a world position's heading and its lane. The entity then follows the lane."""


def place_all(board: Storyboard, network: RoadNetwork) -> dict[str, Traveller]:
    """Return the entities of a storyboard at their initial positions, in the order of the file.

    Raises
    ------
    TrafficInputError
        A position is not on a lane, or relative positions depend on each other.
    """
    placed: dict[str, Traveller] = {}
    waiting = dict(board.places)
    while waiting:
        ready = [
            name
            for name, (place, _) in waiting.items()
            if not isinstance(place, RelativePlace) or place.entity in placed
        ]
        if not ready:
            name, (_, source) = next(iter(waiting.items()))
            raise source.error(f'positions "{name}" relative to an entity that itself depends on it; break the circle')
        for name in ready:
            place, source = waiting.pop(name)
            placed[name] = _placed(board.entities[name], network, place, source, placed)
    return {name: placed[name] for name in board.entities}


def require_places(board: Storyboard, network: RoadNetwork) -> None:
    """Check that the lanes exist that conditions name.

    Raises
    ------
    TrafficInputError
        A position is not on a lane.
    """
    for one in board.conditions():
        if isinstance(one.test, EntityCondition) and isinstance(one.test.place, LanePlace):
            _road(network, one.test.place, one.source)


def _placed(
    entity: Entity, network: RoadNetwork, place: Place, source: XmlElement, placed: dict[str, Traveller]
) -> Traveller:
    match place:
        case LanePlace():
            road = _road(network, place, source)
            return Traveller(entity, network, road, place.lane, place.s, place.offset, road.forward(place.lane))
        case RelativePlace(along_road=True):
            other = placed[place.entity]
            lane = shifted_lane(other.lane, place.lanes * other.forward)
            s = other.s + other.forward * place.ahead
            return _placed(entity, network, LanePlace(other.road.id, lane, s, place.left), source, placed)
        case _:
            x, y = point(place, network, placed, source)
            heading = place.heading if isinstance(place, WorldPlace) else placed[place.entity].pose[2]
            return _projected(entity, network, x, y, heading, source)


def _projected(
    entity: Entity, network: RoadNetwork, x: float, y: float, heading: float | None, source: XmlElement
) -> Traveller:
    """Return an entity on the lane at a point."""
    road, s, t = network.nearest(x, y)
    lane = road.lane_at(s, t)
    if lane is None:
        raise source.error(f"x = {x:g}, y = {y:g} is on no lane; the nearest road is {road.id} at s = {s:.1f}")
    forward = road.forward(lane)
    if heading is not None:
        angle = math.remainder(heading - road.pose(s, t)[2], 2 * math.pi)
        forward = 1 if abs(angle) < math.pi / 2 else -1
        if min(abs(angle), math.pi - abs(angle)) > ALIGNED_RAD:
            raise source.error(f"is turned by {math.degrees(angle):.0f} deg from its lane, which is not supported")
    return Traveller(entity, network, road, lane, s, t - road.centre(s, lane), forward)


def _road(network: RoadNetwork, place: LanePlace, source: XmlElement) -> Road:
    """Return the road of a position, which must have the lane there."""
    if (road := network.roads.get(place.road)) is None:
        raise source.error(f'roadId = "{place.road}" is no road; use one of {", ".join(list(network.roads)[:8])}')
    if not 0 <= place.s <= road.length:
        raise source.error(f"s = {place.s:g} is outside road {road.id}, which is {road.length:.1f} m long")
    if not road.has_lane(place.s, place.lane):
        lanes = ", ".join(str(lane) for lane in sorted(road.section(place.s).lanes))
        raise source.error(f"laneId = {place.lane} is no lane of road {road.id} at s = {place.s:g}; use one of {lanes}")
    return road


def point(place: Place, network: RoadNetwork, placed: dict[str, Traveller], source: XmlElement) -> tuple[float, float]:
    """Return the coordinates [m] of a position.

    Raises
    ------
    TrafficInputError
        The position is not on a lane.
    """
    match place:
        case WorldPlace():
            return place.x, place.y
        case LanePlace():
            road = _road(network, place, source)
            x, y, *_ = road.pose(place.s, road.centre(place.s, place.lane) + place.offset)
            return x, y
        case RelativePlace(along_road=True):
            other = placed[place.entity]
            lane = shifted_lane(other.lane, place.lanes * other.forward)
            s = other.s + other.forward * place.ahead
            return point(LanePlace(other.road.id, lane, s, place.left), network, placed, source)
        case RelativePlace():
            x, y, yaw = placed[place.entity].pose
            cos, sin = math.cos(yaw), math.sin(yaw)
            return x + cos * place.ahead - sin * place.left, y + sin * place.ahead + cos * place.left


def shifted_lane(lane: int, left: int) -> int:
    """Return the id of the lane `left` lanes to the left of another; ids skip 0, the line between both directions."""
    shifted = lane + left
    crosses = lane * shifted <= 0 and left != 0
    return shifted + (1 if left > 0 else -1) if crosses else shifted
