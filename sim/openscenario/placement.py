"""Positions of a storyboard on the road network."""

import math

from luxloop import elementary
from luxloop.sim.opendrive.road import Road
from luxloop.sim.opendrive.road_network import RoadNetwork
from luxloop.sim.openscenario.storyboard import (
    Entity,
    EntityCondition,
    LanePlace,
    Place,
    RelativePlace,
    RouteAction,
    Storyboard,
    TrajectoryAction,
    WorldPlace,
)
from luxloop.sim.openscenario.trajectory import Trajectory
from luxloop.sim.openscenario.traveller import Traveller
from luxloop.sim.xml_tree import XmlElement

ALIGNED_RAD = 0.35
"""[rad] Largest angle between a world position's heading and its lane. The entity then follows the lane."""

JUMP_M = 1.0
"""[m] Largest distance of an entity from the beginning of its trajectory."""


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
    """Check that the lanes exist that conditions, routes and trajectories name.

    Raises
    ------
    TrafficInputError
        A position is not on a lane.
    """
    for one in board.conditions():
        if isinstance(one.test, EntityCondition) and isinstance(one.test.place, LanePlace):
            _road(network, one.test.place, one.source)
    for _, action, source in board.all_actions():
        for place in action.places if isinstance(action, RouteAction | TrajectoryAction) else ():
            if isinstance(place, LanePlace):
                _road(network, place, source)


def route(own: Traveller, action: RouteAction, placed: dict[str, Traveller], source: XmlElement) -> list[str]:
    """Return the ids of the roads after that of an entity, by the shortest way through the positions of a route.

    Raises
    ------
    TrafficInputError
        There is no way to a position.
    """
    way = [(own.road, own.forward)]
    for place in action.places:
        if isinstance(place, LanePlace):
            goal = _road(own.network, place, source)
        else:
            goal = own.network.nearest(*point(place, own.network, placed, source))[0]
        leg = own.network.shortest_way(*way[-1], goal)
        if leg is None:
            raise source.error(f"leads to road {goal.id}, to which there is no way from road {way[-1][0].id}")
        way += leg
    return [road.id for road, _ in way[1:]]


def trajectory(
    own: Traveller, action: TrajectoryAction, time: float, placed: dict[str, Traveller], source: XmlElement
) -> Trajectory:
    """Return the way of an entity along a trajectory that begins at a time [s].

    Raises
    ------
    TrafficInputError
        It begins elsewhere than the entity is, or drives backwards between positions that are not all in the world.
    """
    vertices = [
        (*point(place, own.network, placed, source), place.heading if isinstance(place, WorldPlace) else None)
        for place in action.places
    ]
    times = action.times
    if times is not None and action.absolute:
        times = tuple(one - time for one in times)
    found = Trajectory(vertices, times, action.skipped)
    if found.reverses and not action.reverses:
        raise source.error("drives backwards, for which all positions should be a WorldPosition")
    if (apart := math.dist(found.pose[:2], own.pose[:2])) > JUMP_M:
        raise source.error(f"begins {apart:.1f} m from the entity at {time:.2f} s, but bodies cannot jump")
    return found


def leave_trajectory(own: Traveller) -> bool:
    """Put an entity on the lane under its trajectory; if there is none in its direction, it stands: return False.

    It stands also at the end of a way backwards.
    """
    x, y, heading = own.pose
    road, s, t = own.network.nearest(x, y)
    lane = road.lane_at(s, t)
    angle = math.remainder(heading - road.pose(s, t)[2], 2 * math.pi)
    backwards = own.trajectory is not None and own.trajectory.backwards
    if lane is None or backwards or min(abs(angle), math.pi - abs(angle)) > ALIGNED_RAD:
        own.speed = 0.0
        return False
    own.route = []
    own.put(road, lane, s, t - road.centre(s, lane), 1 if abs(angle) < math.pi / 2 else -1)
    return True


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
            require_lane(other, source)
            lane = shifted_lane(other.lane, place.lanes * other.forward)
            s = other.s + other.forward * place.ahead
            return point(LanePlace(other.road.id, lane, s, place.left), network, placed, source)
        case RelativePlace():
            x, y, yaw = placed[place.entity].pose
            cos, sin = elementary.cos(yaw), elementary.sin(yaw)
            return x + cos * place.ahead - sin * place.left, y + sin * place.ahead + cos * place.left


def require_lane(other: Traveller, source: XmlElement) -> None:
    """Raise a TrafficInputError for an entity on a trajectory, which is on no lane."""
    if other.trajectory:
        raise source.error(f'needs the lane of "{other.entity.name}", which follows a trajectory beside all lanes')


def shifted_lane(lane: int, left: int) -> int:
    """Return the id of the lane `left` lanes to the left of another; ids skip 0, the line between both directions."""
    shifted = lane + left
    crosses = lane * shifted <= 0 and left != 0
    return shifted + (1 if left > 0 else -1) if crosses else shifted
