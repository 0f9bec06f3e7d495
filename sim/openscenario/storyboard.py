"""Records of a storyboard, with all parameters and catalogs resolved."""

from dataclasses import dataclass
from itertools import pairwise

from luxloop import elementary
from luxloop.sim.world import Kind
from luxloop.sim.xml_tree import XmlElement


@dataclass(frozen=True, slots=True)
class Entity:
    """A vehicle or pedestrian."""

    name: str
    kind: Kind
    size: tuple[float, float, float]
    """Length, width, height [m]."""
    centre: tuple[float, float]
    """[m] Box centre in front and to the left of the reference point, the middle of the rear axle."""

    @property
    def front(self) -> float:
        """Distance [m] of the front from the reference point."""
        return self.centre[0] + self.size[0] / 2

    @property
    def rear(self) -> float:
        """The same of the rear, negative behind the reference point."""
        return self.centre[0] - self.size[0] / 2


@dataclass(frozen=True, slots=True)
class LanePlace:
    """Position on a lane."""

    road: str
    lane: int
    s: float
    offset: float = 0.0
    """[m] To the left of the lane's centre, along the reference line."""


@dataclass(frozen=True, slots=True)
class RelativePlace:
    """Position relative to an entity, in its lane or its own axes."""

    entity: str
    ahead: float
    """[m] Along the entity's lane in its direction, or along its own axis."""
    lanes: int = 0
    """Lanes to the left."""
    left: float = 0.0
    """[m] To the left of the lane's centre, or of the entity."""
    along_road: bool = True


@dataclass(frozen=True, slots=True)
class WorldPlace:
    """Position in the coordinates of the road network."""

    x: float
    y: float
    heading: float | None
    """[rad] Counter-clockwise from x; None for that of the lane."""


Place = LanePlace | RelativePlace | WorldPlace


@dataclass(frozen=True, slots=True)
class Dynamics:
    """Course of a change from one value to another."""

    shape: str
    """`step`, `linear`, `cubic` or `sinusoidal`."""
    dimension: str
    """`time`, `distance` or `rate`."""
    value: float


@dataclass(frozen=True, slots=True)
class SpeedAction:
    """Change to a speed [m/s], or to another entity's speed plus a difference or times a factor."""

    dynamics: Dynamics
    target: float
    entity: str = ""
    factor: bool = False
    continuous: bool = False


@dataclass(frozen=True, slots=True)
class LaneChangeAction:
    """Change to a lane, or to the lane this many lanes to the left of another entity."""

    dynamics: Dynamics
    lane: int
    entity: str = ""
    offset: float = 0.0
    """[m] To the left of the target lane's centre."""


@dataclass(frozen=True, slots=True)
class DistanceAction:
    """Change to a distance behind another entity."""

    entity: str
    distance: float | None
    """[m], or None for a time gap."""
    time_gap: float
    """[s]"""
    freespace: bool
    continuous: bool
    acceleration: float
    deceleration: float
    speed: float
    """[m/s^2], [m/s^2], [m/s] Largest values."""


@dataclass(frozen=True, slots=True)
class RouteAction:
    """Way through junctions, by the shortest way from each position to the next."""

    places: tuple[Place, ...]


@dataclass(frozen=True, slots=True)
class TrajectoryAction:
    """Way along a polyline."""

    places: tuple[Place, ...]
    times: tuple[float, ...] | None
    """[s] Time at each position; None if the entity's own speed determines it."""
    absolute: bool
    """Times are simulation times, not times since the beginning of the action."""
    skipped: float
    """[m] Length of the polyline before the entity."""

    @property
    def reverses(self) -> bool:
        """True if the entity drives backwards, by the headings of positions in the world."""
        return any(
            isinstance(one, WorldPlace)
            and isinstance(after, WorldPlace)
            and one.heading is not None
            and (after.x - one.x) * elementary.cos(one.heading) + (after.y - one.y) * elementary.sin(one.heading) < 0
            for one, after in pairwise(self.places)
        )


Action = SpeedAction | LaneChangeAction | DistanceAction | RouteAction | TrajectoryAction


@dataclass(frozen=True, slots=True)
class ValueCondition:
    """Comparison of the simulation time [s], or the state of a storyboard element."""

    rule: str
    value: float
    element: tuple[str, str] | None = None
    """Type and name of the element."""
    state: str = ""


@dataclass(frozen=True, slots=True)
class EntityCondition:
    """Comparison of a quantity of one or more entities."""

    quantity: str
    """`headway`, `collision`, `distance`, `travelled`, `reach`, `speed`, `relative speed` or `standing`."""
    entities: tuple[str, ...]
    all: bool
    """All entities must fulfil it, not just one."""
    rule: str
    value: float
    other: str = ""
    place: Place | None = None
    freespace: bool = False
    axis: str = "longitudinal"
    along_road: bool = False


@dataclass(frozen=True, slots=True, eq=False)
class Condition:
    """A condition with its edge and delay."""

    test: ValueCondition | EntityCondition
    edge: str
    """`none`, `rising`, `falling` or `risingOrFalling`."""
    delay: float
    """[s]"""
    source: XmlElement


Trigger = list[list[Condition]]
"""Groups of conditions: it fires if all conditions of any group are true."""


@dataclass(frozen=True, slots=True, eq=False)
class Step:
    """An element of a story: story, act, maneuver group, maneuver or event."""

    kind: str
    """Type of the element in conditions: `story`, `act`, `maneuverGroup`, `maneuver` or `event`."""
    name: str
    source: XmlElement
    children: tuple["Step", ...] = ()
    start: Trigger | None = None
    """None starts it with the element around it."""
    stop: Trigger | None = None
    priority: str = "parallel"
    """Of an event: `override`, `skip` or `parallel`."""
    count: int = 1
    """Of an event: number of executions."""
    actions: tuple[tuple[str, Action, XmlElement], ...] = ()
    """Of an event: actions with the entities that do them."""

    def all(self) -> list["Step"]:
        """Return the element and all below it."""
        return [self, *(one for child in self.children for one in child.all())]


@dataclass(frozen=True, slots=True, eq=False)
class Storyboard:
    """Content of an OpenSCENARIO file."""

    entities: dict[str, Entity]
    places: dict[str, tuple[Place, XmlElement]]
    """Initial position by entity."""
    actions: list[tuple[str, Action, XmlElement]]
    """Initial actions, in order."""
    stories: list[Step]
    stop: Trigger

    def all_actions(self) -> list[tuple[str, Action, XmlElement]]:
        """Return the initial actions and those of all events."""
        return [*self.actions, *(one for story in self.stories for step in story.all() for one in step.actions)]

    def conditions(self) -> list[Condition]:
        """Return the conditions of all triggers."""
        steps = [one for story in self.stories for one in story.all()]
        triggers = [self.stop, *(trigger for step in steps for trigger in (step.start, step.stop) if trigger)]
        return [one for trigger in triggers for group in trigger for one in group]
