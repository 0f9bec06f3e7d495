"""OpenSCENARIO files as storyboards."""

from collections.abc import Mapping
from pathlib import Path

from luxloop.sim.openscenario.action_elements import read_private_action
from luxloop.sim.openscenario.catalogs import read_entities, require_entity
from luxloop.sim.openscenario.condition_elements import read_trigger
from luxloop.sim.openscenario.expressions import resolve
from luxloop.sim.openscenario.position_elements import read_position
from luxloop.sim.openscenario.storyboard import Action, Entity, Place, Step, Storyboard, ValueCondition
from luxloop.sim.xml_tree import XmlElement, read_xml

PRIORITIES = {"overwrite": "override", "override": "override", "skip": "skip", "parallel": "parallel"}
MOST_EXECUTIONS = 10_000


def read_storyboard(path: Path, parameters: Mapping[str, str]) -> tuple[Storyboard, Path]:
    """Read an OpenSCENARIO file.

    Parameters
    ----------
    path
        The `.xosc`.
    parameters
        Values of declared parameters, in place of those of the file.

    Returns
    -------
    The storyboard, and the path of its OpenDRIVE file.

    Raises
    ------
    TrafficInputError
        The file is invalid or uses something that is not supported.
    """
    tree = read_xml(path, "OpenSCENARIO")
    if (revision := tree.need("FileHeader").whole("revMajor")) != 1:
        raise tree.need("FileHeader").error(f"revMajor = {revision}: only OpenSCENARIO XML 1.x is supported")
    resolve(tree, {}, parameters)
    entities = read_entities(tree, path.parent)
    board = tree.need("Storyboard")
    places, actions = _init(board.need("Init"), entities)
    stories = [_step("story", one, entities) for one in board.all("Story")]
    stop = read_trigger(board.find("StopTrigger"), entities) or []
    storyboard = Storyboard(entities, places, actions, stories, stop)
    _require_known_elements(storyboard)
    return storyboard, path.parent / _roads(tree)


def _roads(tree: XmlElement) -> str:
    return tree.need("RoadNetwork", "LogicFile").text("filepath")


def _init(
    init: XmlElement, entities: dict[str, Entity]
) -> tuple[dict[str, tuple[Place, XmlElement]], list[tuple[str, Action, XmlElement]]]:
    """Read initial positions by entity, and all other initial actions."""
    places: dict[str, tuple[Place, XmlElement]] = {}
    actions: list[tuple[str, Action, XmlElement]] = []
    for group in init.need("Actions").children:
        if group.tag != "Private":
            raise (group.children or [group])[0].error("is not supported; remove it")
        name = require_entity(group, entities)
        for private in group.children:
            if (teleport := private.find("TeleportAction")) is not None:
                places[name] = (read_position(teleport, entities), teleport)
            else:
                actions.append((name, *read_private_action(private, entities)))
    if missing := [name for name in entities if name not in places]:
        raise init.error(f'has no TeleportAction of entity "{missing[0]}"; add its position')
    return places, actions


_CHILDREN = {"story": "Act", "act": "ManeuverGroup", "maneuverGroup": "Maneuver", "maneuver": "Event"}
_KINDS = {"Act": "act", "ManeuverGroup": "maneuverGroup", "Maneuver": "maneuver", "Event": "event"}


def _step(kind: str, element: XmlElement, entities: dict[str, Entity], actors: tuple[str, ...] = ()) -> Step:
    """Read an element of a story with everything below it; events are done by the actors of their group."""
    if kind == "maneuverGroup":
        actors = _actors(element, entities)
    if kind == "event":
        return _event(element, entities, actors)
    below = _CHILDREN[kind]
    return Step(
        kind=kind,
        name=element.text("name"),
        source=element,
        children=tuple(_step(_KINDS[below], one, entities, actors) for one in element.all(below)),
        start=read_trigger(element.find("StartTrigger"), entities),
        stop=read_trigger(element.find("StopTrigger"), entities),
    )


def _actors(group: XmlElement, entities: dict[str, Entity]) -> tuple[str, ...]:
    """Return the actors of a maneuver group, and refuse what is not supported in it."""
    for reference in group.all("CatalogReference"):
        raise reference.error(
            f'takes the maneuver "{reference.text("entryName")}" from a catalog, which is not supported; '
            "write the maneuver into the file"
        )
    if group.number("maximumExecutionCount", 1) != 1:
        raise group.error("has a maximumExecutionCount other than 1, which is supported for events only")
    actors = group.need("Actors")
    if actors.attributes.get("selectTriggeringEntities", "false") in ("true", "1"):
        raise actors.error("has selectTriggeringEntities, which is not supported; name the entities")
    return tuple(require_entity(one, entities) for one in actors.all("EntityRef"))


def _event(element: XmlElement, entities: dict[str, Entity], actors: tuple[str, ...]) -> Step:
    actions: list[tuple[str, Action, XmlElement]] = []
    for action in element.all("Action"):
        inner = action.only()
        if inner.tag != "PrivateAction":
            raise (inner.children or [inner])[0].error("is not supported; remove it")
        read, source = read_private_action(inner, entities)
        actions += [(actor, read, source) for actor in actors]
    count = element.whole("maximumExecutionCount") if "maximumExecutionCount" in element.attributes else 1
    if not 1 <= count <= MOST_EXECUTIONS:
        raise element.error(f"maximumExecutionCount = {count} should be between 1 and {MOST_EXECUTIONS}")
    return Step(
        kind="event",
        name=element.text("name"),
        source=element,
        start=read_trigger(element.find("StartTrigger"), entities),
        priority=element.choice("priority", PRIORITIES),
        count=count,
        actions=tuple(actions),
    )


def _require_known_elements(board: Storyboard) -> None:
    """Check that conditions name elements of the storyboard."""
    known = {(step.kind, step.name) for story in board.stories for step in story.all()}
    for one in board.conditions():
        if isinstance(one.test, ValueCondition) and one.test.element and one.test.element not in known:
            kind, name = one.test.element
            raise one.source.error(f'names the {kind} "{name}", which the storyboard does not have')
