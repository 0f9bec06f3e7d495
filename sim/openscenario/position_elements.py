"""Positions of OpenSCENARIO files."""

import math

from luxloop.sim.openscenario.catalogs import require_entity
from luxloop.sim.openscenario.storyboard import Entity, LanePlace, Place, RelativePlace, WorldPlace
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
