"""Actions of OpenSCENARIO files."""

from collections.abc import Callable

from luxloop.sim.openscenario.catalogs import require_entity
from luxloop.sim.openscenario.position_elements import read_destination, read_route, read_trajectory
from luxloop.sim.openscenario.storyboard import (
    Action,
    DistanceAction,
    Dynamics,
    Entity,
    LaneChangeAction,
    SpeedAction,
)
from luxloop.sim.xml_tree import XmlElement

FLAGS = {"true": "yes", "1": "yes", "false": "", "0": ""}


def read_private_action(element: XmlElement, entities: dict[str, Entity]) -> tuple[Action, XmlElement]:
    """Read a `<PrivateAction>` other than a teleport, with its element for messages.

    Raises
    ------
    TrafficInputError
        The action is not supported.
    """
    action = _innermost(element)
    if action.tag in READERS:
        return READERS[action.tag](action, entities), action
    if action.tag == "TeleportAction":
        raise action.error("is supported in Init only, since bodies cannot jump during a run; remove the event")
    raise action.error(f"is not supported; supported are {SUPPORTED}")


def _innermost(element: XmlElement) -> XmlElement:
    """Return the action inside its group, such as a `<LongitudinalAction>`."""
    action = element.only()
    while action.tag in ("LongitudinalAction", "LateralAction", "RoutingAction", "ControllerAction"):
        action = action.children[0] if action.tag == "ControllerAction" and action.children else action.only()
    return action


def flag(element: XmlElement, name: str) -> bool:
    """Return an attribute that is true or false, by default false."""
    return element.choice(name, FLAGS, "false") != ""


def _dynamics(element: XmlElement) -> Dynamics:
    shapes = {name: name for name in ("step", "linear", "cubic", "sinusoidal")}
    dimensions = {name: name for name in ("time", "distance", "rate")}
    shape, value = element.choice("dynamicsShape", shapes), abs(element.number("value"))
    if shape != "step" and value == 0:
        shape = "step"
    return Dynamics(shape, element.choice("dynamicsDimension", dimensions), value)


def _speed(action: XmlElement, entities: dict[str, Entity]) -> SpeedAction:
    dynamics, target = _dynamics(action.need("SpeedActionDynamics")), action.need("SpeedActionTarget").only()
    if target.tag == "AbsoluteTargetSpeed":
        if (speed := target.number("value")) < 0:
            raise target.error(f"value = {speed:g}: driving backwards is not supported; use 0 or more")
        return SpeedAction(dynamics, speed)
    if target.tag != "RelativeTargetSpeed":
        raise target.error("is not supported; use AbsoluteTargetSpeed or RelativeTargetSpeed")
    factor = target.choice("speedTargetValueType", {"delta": "", "factor": "yes"}) != ""
    entity = require_entity(target, entities)
    return SpeedAction(dynamics, target.number("value"), entity, factor, flag(target, "continuous"))


def _lane_change(action: XmlElement, entities: dict[str, Entity]) -> LaneChangeAction:
    dynamics, target = _dynamics(action.need("LaneChangeActionDynamics")), action.need("LaneChangeTarget").only()
    if dynamics.shape == "step":
        raise action.error("has a step as its dynamics, but bodies cannot jump; use sinusoidal over a time")
    offset = action.number("targetLaneOffset", 0.0)
    if target.tag == "AbsoluteTargetLane":
        return LaneChangeAction(dynamics, target.whole("value"), offset=offset)
    if target.tag == "RelativeTargetLane":
        return LaneChangeAction(dynamics, target.whole("value"), require_entity(target, entities), offset)
    raise target.error("is not supported; use AbsoluteTargetLane or RelativeTargetLane")


def _distance(action: XmlElement, entities: dict[str, Entity]) -> DistanceAction:
    limits = action.find("DynamicConstraints")
    if limits is None:
        raise action.error("has no DynamicConstraints, so that it would jump; add maxAcceleration and maxDeceleration")
    action.choice("coordinateSystem", {"road": "", "lane": "", "entity": ""}, "road")
    action.choice("displacement", {"any": "", "trailingReferencedEntity": ""}, "any")
    if ("distance" in action.attributes) == ("timeGap" in action.attributes):
        raise action.error("should have either distance or timeGap")
    return DistanceAction(
        entity=require_entity(action, entities),
        distance=action.number("distance") if "distance" in action.attributes else None,
        time_gap=action.number("timeGap", 0.0),
        freespace=flag(action, "freespace"),
        continuous=flag(action, "continuous"),
        acceleration=_positive(limits, "maxAcceleration"),
        deceleration=_positive(limits, "maxDeceleration"),
        speed=_positive(limits, "maxSpeed", 1e9),
    )


def _positive(element: XmlElement, name: str, default: float | None = None) -> float:
    if (value := element.number(name, default)) <= 0:
        raise element.error(f"{name} = {value:g} should be positive")
    return value


READERS: dict[str, Callable[[XmlElement, dict[str, Entity]], Action]] = {
    "SpeedAction": _speed,
    "LaneChangeAction": _lane_change,
    "LongitudinalDistanceAction": _distance,
    "AssignRouteAction": read_route,
    "AcquirePositionAction": read_destination,
    "FollowTrajectoryAction": read_trajectory,
}
"""Actions of an event, by their element."""
SUPPORTED = f"{', '.join(READERS)}, and TeleportAction in Init"
