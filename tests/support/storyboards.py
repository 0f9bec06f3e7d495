"""OpenDRIVE and OpenSCENARIO files of a few lines, for tests."""

from luxloop.sim.opendrive.road_network import read_network
from luxloop.sim.openscenario.storyboard_elements import read_storyboard
from luxloop.sim.openscenario.storyboard_run import StoryboardRun

STEP_S = 0.01
LINE = '<geometry s="0" x="0" y="0" hdg="0" length="{length}"><line/></geometry>'
CAR = (
    '<Vehicle name="car" vehicleCategory="car"><BoundingBox><Center x="1.4" y="0" z="0.7"/>'
    '<Dimensions length="4.8" width="1.8" height="1.4"/></BoundingBox></Vehicle>'
)


def lane(id, width=3.5, link=""):
    """Return a lane with a constant width, or with the polynomial (a, b, c, d)."""
    a, b, c, d = width if isinstance(width, tuple) else (width, 0, 0, 0)
    return (
        f'<lane id="{id}" type="driving"><link>{link}</link><width sOffset="0" a="{a}" b="{b}" c="{c}" d="{d}"/></lane>'
    )


def section(s=0, left=(), right=()):
    """Return a lane section."""
    sides = (f"<{side}>{''.join(lanes)}</{side}>" for side, lanes in (("left", left), ("right", right)) if lanes)
    return f'<laneSection s="{s}">{"".join(sides)}</laneSection>'


def road(geometry=None, sections=None, length=500, id="1", link="", offset="", rule="RHT"):
    """Return a road; by default a straight one along x with one lane on the left and two on the right."""
    geometry = geometry or LINE.format(length=length)
    sections = sections or section(left=[lane(1)], right=[lane(-1), lane(-2)])
    return (
        f'<road id="{id}" length="{length}" junction="-1" rule="{rule}"><link>{link}</link>'
        f"<planView>{geometry}</planView><lanes>{offset}{sections}</lanes></road>"
    )


def network(folder, *parts):
    """Write an OpenDRIVE file of roads and junctions, and read it."""
    path = folder / "roads.xodr"
    path.write_text(f"<OpenDRIVE>{''.join(parts) or road()}</OpenDRIVE>", encoding="utf-8")
    return read_network(path)


def at(s, lane=-1, road="1", offset=0):
    """Return a teleport to a lane."""
    return (
        "<PrivateAction><TeleportAction><Position>"
        f'<LanePosition roadId="{road}" laneId="{lane}" s="{s}" offset="{offset}"/>'
        "</Position></TeleportAction></PrivateAction>"
    )


def speed(value, shape="step", dimension="time", over=0, target=None):
    """Return a speed action, to a speed or to a target."""
    target = target or f'<AbsoluteTargetSpeed value="{value}"/>'
    return (
        "<PrivateAction><LongitudinalAction><SpeedAction>"
        f'<SpeedActionDynamics dynamicsShape="{shape}" dynamicsDimension="{dimension}" value="{over}"/>'
        f"<SpeedActionTarget>{target}</SpeedActionTarget></SpeedAction></LongitudinalAction></PrivateAction>"
    )


def lane_change(target, shape="sinusoidal", dimension="time", over=4, offset=0):
    """Return a lane change, to the id of a lane or to a target."""
    target = target if isinstance(target, str) else f'<AbsoluteTargetLane value="{target}"/>'
    return (
        f'<PrivateAction><LateralAction><LaneChangeAction targetLaneOffset="{offset}">'
        f'<LaneChangeActionDynamics dynamicsShape="{shape}" dynamicsDimension="{dimension}" value="{over}"/>'
        f"<LaneChangeTarget>{target}</LaneChangeTarget></LaneChangeAction></LateralAction></PrivateAction>"
    )


def after(seconds):
    """Return a condition on the simulation time."""
    return f'<ByValueCondition><SimulationTimeCondition value="{seconds}" rule="greaterThan"/></ByValueCondition>'


def by_entity(test, *entities):
    """Return a condition on entities."""
    refs = "".join(f'<EntityRef entityRef="{name}"/>' for name in entities or ("Ego",))
    return (
        f'<ByEntityCondition><TriggeringEntities triggeringEntitiesRule="any">{refs}</TriggeringEntities>'
        f"<EntityCondition>{test}</EntityCondition></ByEntityCondition>"
    )


def trigger(*conditions, tag="StartTrigger", delay=0, edge="none"):
    """Return a trigger of one group of conditions."""
    inner = "".join(
        f'<Condition name="c" delay="{delay}" conditionEdge="{edge}">{one}</Condition>' for one in conditions
    )
    return f"<{tag}><ConditionGroup>{inner}</ConditionGroup></{tag}>"


def event(action, start="", name="event", priority="parallel", count=1):
    """Return an event with one action."""
    return (
        f'<Event name="{name}" priority="{priority}" maximumExecutionCount="{count}">'
        f'<Action name="{name} action">{action}</Action>{start}</Event>'
    )


def act(*events, actor="Ego", start="", name="act"):
    """Return an act with one maneuver."""
    return (
        f'<Act name="{name}"><ManeuverGroup name="{name} group" maximumExecutionCount="1">'
        f'<Actors selectTriggeringEntities="false"><EntityRef entityRef="{actor}"/></Actors>'
        f'<Maneuver name="{name} maneuver">{"".join(events)}</Maneuver></ManeuverGroup>{start}</Act>'
    )


def document(entities, *acts, stop="", parameters="", bodies=None):
    """Return an OpenSCENARIO file: initial actions by entity, and acts."""
    objects = "".join(
        f'<ScenarioObject name="{name}">{(bodies or {}).get(name, CAR)}</ScenarioObject>' for name in entities
    )
    private = "".join(f'<Private entityRef="{name}">{actions}</Private>' for name, actions in entities.items())
    story = f'<Story name="story">{"".join(acts)}</Story>' if acts else ""
    return (
        '<OpenSCENARIO><FileHeader revMajor="1" revMinor="1"/>'
        f"<ParameterDeclarations>{parameters}</ParameterDeclarations>"
        '<CatalogLocations><VehicleCatalog><Directory path="catalogs"/></VehicleCatalog></CatalogLocations>'
        f'<RoadNetwork><LogicFile filepath="roads.xodr"/></RoadNetwork><Entities>{objects}</Entities>'
        f"<Storyboard><Init><Actions>{private}</Actions></Init>{story}{stop}</Storyboard></OpenSCENARIO>"
    )


def start(folder, text, *roads, parameters=None):
    """Write both files, and return the storyboard at 0 s."""
    roads = network(folder, *roads)
    (folder / "a.xosc").write_text(text, encoding="utf-8")
    board, _ = read_storyboard(folder / "a.xosc", parameters or {})
    return StoryboardRun(board, roads)


def run_to(run, time):
    """Advance a storyboard to a time [s]."""
    while run.time < time - STEP_S / 2 and not run.stopped:
        run.advance(STEP_S)
    return run


def first_time(run, holds, latest=60.0):
    """Return the first time [s] at which something holds."""
    while not holds(run):
        assert run.time < latest
        run.advance(STEP_S)
    return run.time
