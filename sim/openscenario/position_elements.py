"""Positions, routes and trajectories of OpenSCENARIO files."""

import math

from luxloop.sim.openscenario.catalogs import require_entity
from luxloop.sim.openscenario.storyboard import (
    Entity,
    LanePlace,
    Place,
    RelativePlace,
    RouteAction,
    TrajectoryAction,
    WorldPlace,
)
from luxloop.sim.xml_tree import XmlElement

ALIGNED_RAD = 0.01
"""[rad] Orientations closer to 0 than this count as along the lane."""


def read_position(parent: XmlElement, entities: dict[str, Entity]) -> Place:
    """Read the position of a `<Position>` in an element.

    Raises
    ------
    TrafficInputError
        The position is of an unsupported kind, or names an unknown entity.
    """
    position = parent.need("Position").only()
    match position.tag:
        case "LanePosition":
            _require_along_lane(position)
            return LanePlace(
                position.text("roadId"), position.whole("laneId"), position.number("s"), position.number("offset", 0.0)
            )
        case "RelativeLanePosition":
            _require_along_lane(position)
            if "dsLane" in position.attributes:
                raise position.error("has dsLane, which is not supported; write ds")
            entity = require_entity(position, entities)
            return RelativePlace(entity, position.number("ds"), position.whole("dLane"), position.number("offset", 0.0))
        case "RelativeObjectPosition":
            _require_along_lane(position)
            entity = require_entity(position, entities)
            return RelativePlace(entity, position.number("dx"), left=position.number("dy", 0.0), along_road=False)
        case "WorldPosition":
            heading = position.number("h") if "h" in position.attributes else None
            return WorldPlace(position.number("x"), position.number("y"), heading)
        case _:
            raise position.error(
                "is not supported; use LanePosition, RelativeLanePosition, RelativeObjectPosition or WorldPosition"
            )


def _require_along_lane(position: XmlElement) -> None:
    orientation = position.find("Orientation")
    if orientation and abs(math.remainder(orientation.number("h", 0.0), 2 * math.pi)) > ALIGNED_RAD:
        raise orientation.error("turns the entity out of its lane, which is not supported; remove h")


CLOSED = {"false": "", "0": ""}
STRATEGIES = {"shortest": "", "fastest": ""}
"""Roads have no speed limits here, so that the shortest route is the fastest."""


def read_route(action: XmlElement, entities: dict[str, Entity]) -> RouteAction:
    """Read an `<AssignRouteAction>`.

    Raises
    ------
    TrafficInputError
        The route is closed, or comes from a catalog.
    """
    route = action.need("Route")
    route.choice("closed", CLOSED, "false")
    waypoints = route.all("Waypoint")
    for one in waypoints:
        one.choice("routeStrategy", STRATEGIES, "shortest")
    if not waypoints:
        raise route.error("has no <Waypoint>; add the position to reach")
    return RouteAction(tuple(read_position(one, entities) for one in waypoints))


def read_destination(action: XmlElement, entities: dict[str, Entity]) -> RouteAction:
    """Read an `<AcquirePositionAction>`, a route to one position."""
    return RouteAction((read_position(action, entities),))


def read_trajectory(action: XmlElement, entities: dict[str, Entity]) -> TrajectoryAction:
    """Read a `<FollowTrajectoryAction>`.

    Raises
    ------
    TrafficInputError
        The trajectory is closed, comes from a catalog, is no polyline, or has times that do not increase.
    """
    trajectory = action.find("TrajectoryRef", "Trajectory") or action.need("Trajectory")
    trajectory.choice("closed", CLOSED, "false")
    shape = trajectory.need("Shape").only()
    if shape.tag != "Polyline":
        raise shape.error("is not supported; write the trajectory as a Polyline")
    vertices = shape.all("Vertex")
    if len(vertices) < 2:
        raise shape.error("should have at least two <Vertex>")
    places = tuple(read_position(one, entities) for one in vertices)
    skipped = action.number("initialDistanceOffset", 0.0)
    timing = action.find("TimeReference", "Timing")
    if timing is None:
        return TrajectoryAction(places, None, absolute=False, skipped=skipped)
    absolute = timing.choice("domainAbsoluteRelative", {"absolute": "yes", "relative": ""}) != ""
    return TrajectoryAction(places, _times(vertices, timing), absolute, skipped)


def _times(vertices: list[XmlElement], timing: XmlElement) -> tuple[float, ...]:
    """Return the times [s] of the vertices, after the scale and the offset of the timing."""
    scale, offset = timing.number("scale", 1.0), timing.number("offset", 0.0)
    times = tuple(scale * one.number("time") + offset for one in vertices)
    for vertex, before, after in zip(vertices[1:], times, times[1:], strict=False):
        if after <= before:
            raise vertex.error(f"time = {vertex.text('time')} should be later than that of the vertex before")
    return times
