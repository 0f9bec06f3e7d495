"""Evaluation of conditions, with edges and delays."""

import math
from collections import deque
from typing import Protocol

from luxloop.sim.opendrive.road_network import RoadNetwork
from luxloop.sim.openscenario.distances import in_own_axes, signed_distance
from luxloop.sim.openscenario.placement import point
from luxloop.sim.openscenario.storyboard import Condition, EntityCondition, RelativePlace, Trigger, ValueCondition
from luxloop.sim.openscenario.traveller import Traveller

EQUAL = 1e-6
"""Numbers closer than this count as equal."""
STANDING_MPS = 1e-3
"""[m/s] A slower entity has no time headway."""


class Scene(Protocol):
    """State that conditions are tested on."""

    @property
    def time(self) -> float:
        """Simulation time [s]."""
        ...

    @property
    def network(self) -> RoadNetwork:
        """Roads."""
        ...

    @property
    def travellers(self) -> dict[str, Traveller]:
        """Entities by name, without those that have left the roads."""
        ...

    def has_state(self, element: tuple[str, str], state: str) -> bool:
        """Return whether a storyboard element has a state, or makes a transition now."""
        ...


class TriggerWatch:
    """Trigger over time: it keeps the values that edges and delays need."""

    def __init__(self, trigger: Trigger):
        self._groups = [[_ConditionWatch(one) for one in group] for group in trigger]

    def fires(self, scene: Scene) -> bool:
        """Evaluate all conditions once, and return whether those of any group are all true."""
        values = [[watch.value(scene) for watch in group] for group in self._groups]
        return any(group and all(group) for group in values)


class _ConditionWatch:
    def __init__(self, condition: Condition):
        self._condition = condition
        self._before: bool | None = None
        self._late: deque[float] = deque()

    def value(self, scene: Scene) -> bool:
        condition = self._condition
        now, before = _holds(condition, scene), self._before
        self._before = now
        rises, falls = now and before is False, before is True and not now
        edge = {"none": now, "rising": rises, "falling": falls, "risingOrFalling": rises or falls}[condition.edge]
        if not condition.delay:
            return edge
        if edge:
            self._late.append(scene.time + condition.delay)
        due = False
        while self._late and self._late[0] <= scene.time + EQUAL:
            due = bool(self._late.popleft())
        return due


def _holds(condition: Condition, scene: Scene) -> bool:
    test = condition.test
    if isinstance(test, ValueCondition):
        if test.element:
            return scene.has_state(test.element, test.state)
        return _compare(scene.time, test.rule, test.value)
    values = [_quantity(test, name, condition, scene) for name in test.entities]
    held = [value is not None and _compare(value, test.rule, test.value) for value in values]
    return all(held) if test.all else any(held)


def _compare(value: float, rule: str, limit: float) -> bool:
    match rule:
        case "greaterThan":
            return value > limit
        case "lessThan":
            return value < limit
        case "greaterOrEqual":
            return value >= limit
        case "lessOrEqual":
            return value <= limit
        case "notEqualTo":
            return abs(value - limit) > EQUAL
        case _:
            return abs(value - limit) <= EQUAL


def _quantity(test: EntityCondition, name: str, condition: Condition, scene: Scene) -> float | None:
    """Return the quantity of an entity that a condition compares, or None if it is not defined now."""
    one, other = scene.travellers.get(name), scene.travellers.get(test.other)
    if one is None or (test.other and other is None):
        return None
    match test.quantity:
        case "speed":
            return one.speed
        case "travelled":
            return one.travelled
        case "standing":
            return one.standing
        case "relative speed":
            return one.speed - other.speed if other else None
    ahead = _distance(test, one, other, condition, scene)
    match test.quantity:
        case _ if ahead is None:
            return None
        case "distance" | "reach":
            return abs(ahead)
        case "headway":  # not defined for an entity behind, nor while standing
            return ahead / one.speed if ahead >= 0 and one.speed > STANDING_MPS else None
        case _:
            closing = one.speed - (other.speed if other else 0.0)
            approaches = closing > 0 if ahead >= 0 else closing < 0
            return ahead / closing if approaches else None


def _distance(
    test: EntityCondition, one: Traveller, other: Traveller | None, condition: Condition, scene: Scene
) -> float | None:
    """Return the distance [m] to another entity or a position, negative behind where the axis has a direction."""
    if other:
        return signed_distance(test, one, other)
    place = test.place
    if place is None or (isinstance(place, RelativePlace) and place.entity not in scene.travellers):
        return None
    x, y = point(place, scene.network, scene.travellers, condition.source)
    if test.quantity == "reach" or test.axis == "euclidean":
        return math.dist(one.pose[:2], (x, y))
    ahead, left = in_own_axes(one, x, y)
    return left if test.axis == "lateral" else ahead
