"""Triggers and conditions of OpenSCENARIO files."""

from luxloop.sim.openscenario.action_elements import flag
from luxloop.sim.openscenario.catalogs import require_entity
from luxloop.sim.openscenario.position_elements import read_position
from luxloop.sim.openscenario.storyboard import Condition, Entity, EntityCondition, Trigger, ValueCondition
from luxloop.sim.xml_tree import XmlElement

RULES = {name: name for name in ("greaterThan", "lessThan", "equalTo", "greaterOrEqual", "lessOrEqual", "notEqualTo")}
EDGES = {name: name for name in ("none", "rising", "falling", "risingOrFalling")}
AXES = {
    "longitudinal": "longitudinal",
    "lateral": "lateral",
    "cartesianDistance": "euclidean",
    "euclidianDistance": "euclidean",
}
FRAMES = {"entity": "", "road": "yes", "lane": "yes"}
KINDS = {name: name for name in ("story", "act", "maneuverGroup", "maneuver", "event")}
STATES = {
    name: name
    for name in (
        "startTransition",
        "endTransition",
        "stopTransition",
        "skipTransition",
        "standbyState",
        "runningState",
        "completeState",
    )
}


def read_trigger(element: XmlElement | None, entities: dict[str, Entity]) -> Trigger | None:
    """Read a trigger; None if it is missing or empty.

    Raises
    ------
    TrafficInputError
        A condition is not supported.
    """
    if element is None or not element.children:
        return None
    return [[_condition(one, entities) for one in group.all("Condition")] for group in element.all("ConditionGroup")]


def _condition(element: XmlElement, entities: dict[str, Entity]) -> Condition:
    if (delay := element.number("delay", 0.0)) < 0:
        raise element.error(f"delay = {delay:g} should not be negative")
    by = element.only()
    if by.tag == "ByValueCondition":
        test: ValueCondition | EntityCondition = _by_value(by.only())
    elif by.tag == "ByEntityCondition":
        test = _by_entity(by, entities)
    else:
        raise by.error("is not supported; use ByEntityCondition or ByValueCondition")
    return Condition(test, element.choice("conditionEdge", EDGES, "none"), delay, element)


def _by_value(element: XmlElement) -> ValueCondition:
    if element.tag == "SimulationTimeCondition":
        return ValueCondition(element.choice("rule", RULES), element.number("value"))
    if element.tag != "StoryboardElementStateCondition":
        raise element.error("is not supported; use SimulationTimeCondition or StoryboardElementStateCondition")
    named = (element.choice("storyboardElementType", KINDS), element.text("storyboardElementRef"))
    return ValueCondition("", 0.0, named, element.choice("state", STATES))


def _by_entity(by: XmlElement, entities: dict[str, Entity]) -> EntityCondition:
    triggering = by.need("TriggeringEntities")
    names = tuple(require_entity(one, entities) for one in triggering.all("EntityRef"))
    if not names:
        raise triggering.error("names no entity; add an EntityRef")
    every = triggering.choice("triggeringEntitiesRule", {"any": "", "all": "yes"}) != ""
    test = by.need("EntityCondition").only()
    if test.tag not in QUANTITIES:
        raise test.error(f"is not supported; supported are {', '.join(QUANTITIES)}")
    quantity, compared = QUANTITIES[test.tag]
    value = test.number(compared)
    rule = {"reach": "lessOrEqual", "travelled": "greaterOrEqual", "standing": "greaterOrEqual"}.get(quantity)
    target = test.find("TimeToCollisionConditionTarget") or test
    other = target.find("EntityRef") or test
    road = flag(test, "alongRoute") or test.choice("coordinateSystem", FRAMES, "entity") != ""
    has_place = target.find("Position") is not None or quantity == "reach"
    condition = EntityCondition(
        quantity=quantity,
        entities=names,
        all=every,
        rule=rule or test.choice("rule", RULES),
        value=value,
        other=require_entity(other, entities) if "entityRef" in other.attributes else "",
        place=read_position(target, entities) if has_place else None,
        freespace=flag(test, "freespace"),
        axis=test.choice("relativeDistanceType", AXES, _DEFAULT_AXIS.get(test.tag, "longitudinal")),
        along_road=road,
    )
    _require_complete(condition, test)
    return condition


def _require_complete(condition: EntityCondition, test: XmlElement) -> None:
    """Check that a comparison with another entity or place has one, and is defined for it."""
    if condition.quantity in ("headway", "collision", "distance", "relative speed") and not (
        condition.other or condition.place
    ):
        raise test.error("names no other entity; add an entityRef")
    if condition.freespace and (condition.axis == "euclidean" or condition.place):
        raise test.error('has freespace = "true", which is supported between two entities along one axis only')
    if "direction" in test.attributes:
        raise test.error("has a direction, which is not supported; remove it to compare the absolute value")


QUANTITIES = {
    "TimeHeadwayCondition": ("headway", "value"),
    "TimeToCollisionCondition": ("collision", "value"),
    "RelativeDistanceCondition": ("distance", "value"),
    "DistanceCondition": ("distance", "value"),
    "TraveledDistanceCondition": ("travelled", "value"),
    "ReachPositionCondition": ("reach", "tolerance"),
    "SpeedCondition": ("speed", "value"),
    "RelativeSpeedCondition": ("relative speed", "value"),
    "StandStillCondition": ("standing", "duration"),
}
"""Quantity, and attribute of the value that it is compared with, by condition."""
_DEFAULT_AXIS = {"DistanceCondition": "cartesianDistance"}
