"""Routes through junctions and trajectories, against positions by hand."""

import math

import numpy as np
import pytest
from support.storyboards import (
    STEP_S,
    act,
    after,
    at,
    document,
    event,
    first_time,
    lane,
    lane_change,
    road,
    run_to,
    section,
    speed,
    start,
    trigger,
)

from luxloop.sim.openscenario.openscenario_config import OpenScenarioTraffic
from luxloop.sim.openscenario.openscenario_source import OpenScenarioSource
from luxloop.sim.source import TrafficInputError

LEFT_TURN = '<geometry s="0" x="100" y="0" hdg="0" length="31.4159"><arc curvature="0.05"/></geometry>'
ONWARD = '<geometry s="0" x="{x}" y="{y}" hdg="{heading}" length="{length}"><line/></geometry>'


def link(side, id, kind="road", point="start"):
    return f'<{side} elementType="{kind}" elementId="{id}" contactPoint="{point}"/>'


def way(id, incoming, over, lanes):
    links = "".join(f'<laneLink from="{one}" to="-1"/>' for one in lanes)
    ends = f'incomingRoad="{incoming}" connectingRoad="{over}" contactPoint="start"'
    return f'<connection id="{id}" {ends}>{links}</connection>'


def crossing():
    """Return road 1 along x to x = 100, on to road 2, or from lane -1 by a left turn of 20 m to road 3 along y."""
    single = section(right=[lane(-1, link='<successor id="-1"/>')])
    straight, upward = (ONWARD.format(x=120, y=y, heading=h, length=100) for y, h in ((0, 0), (20, math.pi / 2)))
    return [
        road(length=100, link=link("successor", "J", "junction")),
        road(ONWARD.format(x=100, y=0, heading=0, length=20), single, 20, "12", link("successor", "2")),
        road(LEFT_TURN, single, 31.4159, "13", link("successor", "3")),
        road(straight, section(right=[lane(-1)]), 100, "2"),
        road(upward, section(right=[lane(-1)]), 100, "3"),
        f'<junction id="J">{way(0, 1, 12, [-1, -2])}{way(1, 1, 13, [-1])}</junction>',
    ]


def routing(action):
    return f"<PrivateAction><RoutingAction>{action}</RoutingAction></PrivateAction>"


def position(road, s=10, lane=-1):
    return f'<Position><LanePosition roadId="{road}" laneId="{lane}" s="{s}"/></Position>'


def route(*roads, keys=""):
    waypoints = "".join(f'<Waypoint routeStrategy="shortest">{position(one)}</Waypoint>' for one in roads)
    return routing(f'<AssignRouteAction><Route name="r" closed="false"{keys}>{waypoints}</Route></AssignRouteAction>')


def _vertex(x, y, time, heading=None):
    turned = "" if heading is None else f' h="{heading}"'
    return f'<Vertex time="{time}"><Position><WorldPosition x="{x}" y="{y}"{turned}/></Position></Vertex>'


def trajectory(*vertices, timing="<None/>", keys="", inner=""):
    """Return an action along vertices (x, y, time) or (x, y, time, heading)."""
    points = "".join(_vertex(*vertex) for vertex in vertices)
    shape = inner or f"<Polyline>{points}</Polyline>"
    return routing(
        f'<FollowTrajectoryAction{keys}><TrajectoryRef><Trajectory name="t" closed="false"><Shape>{shape}</Shape>'
        f"</Trajectory></TrajectoryRef><TimeReference>{timing}</TimeReference></FollowTrajectoryAction>"
    )


def backwards_in_lanes():
    ahead = trajectory((50, -1.75, 0, 3.1), (70, -1.75, 1))
    return ahead.replace('<WorldPosition x="70" y="-1.75"/>', '<LanePosition roadId="1" laneId="-1" s="70"/>')


RELATIVE = '<Timing domainAbsoluteRelative="relative" scale="1" offset="0"/>'


@pytest.mark.parametrize(
    "action", [route(1, 3), routing(f"<AcquirePositionAction>{position(3)}</AcquirePositionAction>")]
)
def test_a_route_turns_left_where_the_way_straight_on_is_the_default(action, tmp_path):
    """Lane -1 is 21.75 m from the centre of the turn: 10 m and a quarter of its circle take 2.208 s at 20 m/s."""
    straight = start(tmp_path, document({"Ego": at(90) + speed(20)}), *crossing())
    assert run_to(straight, 3.0).travellers["Ego"].pose == pytest.approx((150, -1.75, 0))
    turned = start(tmp_path, document({"Ego": at(90) + speed(20) + action}), *crossing())
    ego = run_to(turned, 3.0).travellers["Ego"]
    assert ego.road.id == "3"
    assert ego.pose == pytest.approx((121.75, 20 + 60 - 10 - 21.75 * math.pi / 2, math.pi / 2), abs=0.05)


def test_a_route_that_the_lane_does_not_reach_names_the_lane(tmp_path):
    acts = act(event(lane_change(-1), trigger(after(1))))
    wrong = document({"Ego": at(5, lane=-2) + speed(20) + route(3)})
    with pytest.raises(
        TrafficInputError, match="to road 13, which lane -2 of road 1 does not reach; change to lane -1"
    ):
        run_to(start(tmp_path, wrong, *crossing()), 6.0)
    changed = start(tmp_path, document({"Ego": at(5, lane=-2) + speed(15) + route(3)}, acts), *crossing())
    assert run_to(changed, 8.0).travellers["Ego"].road.id in {"13", "3"}


def test_a_headway_along_the_route_finds_the_entity_around_the_corner(tmp_path):
    """The lead on road 3 is 20 + 31.4159 + 50 m ahead on the route; straight on there is no one."""
    headway = (
        '<ByEntityCondition><TriggeringEntities triggeringEntitiesRule="any"><EntityRef entityRef="Ego"/>'
        '</TriggeringEntities><EntityCondition><RelativeDistanceCondition entityRef="Lead" value="200" rule="lessThan" '
        'freespace="false" relativeDistanceType="longitudinal" coordinateSystem="road"/></EntityCondition>'
        "</ByEntityCondition>"
    )
    for action, expected in ((route(3), 5.0), ("", 20.0)):
        entities = {"Ego": at(80) + speed(20) + action, "Lead": at(50, road="3")}
        run = start(tmp_path, document(entities, act(event(speed(5), trigger(headway)))), *crossing())
        assert run_to(run, 0.1).travellers["Ego"].speed == expected


def test_a_trajectory_with_times_has_its_positions_and_ends_in_the_lane_below(tmp_path):
    """20 m in the first second, then 3.5 m to the left within 20 m: the end is the centre of lane 1."""
    bend = trajectory((50, -1.75, 0), (70, -1.75, 1), (90, 1.75, 2), timing=RELATIVE)
    run = start(tmp_path, document({"Ego": at(46.97) + speed(3)}, act(event(bend, trigger(after(1)), name="e"))))
    begun = first_time(run, lambda run: run.has_state(("event", "e"), "runningState"))
    ego = run.travellers["Ego"]
    assert ego.pose == pytest.approx((50, -1.75, 0))
    assert run_to(run, begun + 0.5).travellers["Ego"].pose == pytest.approx((60, -1.75, 0))
    assert ego.speed == pytest.approx(20)
    assert run_to(run, begun + 1.5).travellers["Ego"].pose == pytest.approx((80, 0, math.atan2(3.5, 20)))
    assert ego.speed == pytest.approx(math.hypot(20, 3.5))
    ended = first_time(run, lambda run: run.has_state(("event", "e"), "completeState"))
    assert ended == pytest.approx(begun + 2, abs=STEP_S)
    assert run_to(run, begun + 3).travellers["Ego"].pose == pytest.approx((90 + math.hypot(20, 3.5), 1.75, 0), abs=0.01)


def test_a_trajectory_without_times_is_driven_at_the_speed_of_the_entity(tmp_path):
    """13 m at 10 m/s: 5 m along x, then 8 m away from the road, where it stands, since there is no lane."""
    corner = trajectory((40, -1.75, 0), (55, -1.75, 0), (55, -9.75, 0), keys=' initialDistanceOffset="10"')
    run = start(tmp_path, document({"Ego": at(50) + speed(10) + corner}))
    assert run_to(run, 0.3).travellers["Ego"].pose == pytest.approx((53, -1.75, 0))
    assert run_to(run, 1.0).travellers["Ego"].pose == pytest.approx((55, -6.75, -math.pi / 2))
    ego = run_to(run, 2.0).travellers["Ego"]
    assert ego.pose == pytest.approx((55, -9.75, -math.pi / 2))
    assert (ego.speed, ego.travelled) == (0.0, pytest.approx(13))


def test_times_on_the_clock_of_the_simulation_are_scaled_and_shifted(tmp_path):
    """Twice the times less 1 s: the trajectory begins at 1 s, 20 m of it take 2 s, whenever the action begins."""
    timing = '<Timing domainAbsoluteRelative="absolute" scale="2" offset="-1"/>'
    drive = event(trajectory((50, -1.75, 1), (70, -1.75, 2, 0.1), timing=timing), trigger(after(0.5)))
    run = start(tmp_path, document({"Ego": at(50)}, act(drive)))
    assert run_to(run, 1.0).travellers["Ego"].pose == pytest.approx((50, -1.75, 0))
    assert run_to(run, 2.0).travellers["Ego"].pose == pytest.approx((60, -1.75, 0))


@pytest.mark.parametrize(
    ("action", "expected"),
    [
        (routing("<AssignRouteAction/>"), "has no <Route>; add it"),
        (route(), "has no <Waypoint>; add the position to reach"),
        (route("9"), 'roadId = "9" is no road'),
        (route("2") + route("1"), None),
        (route("3", "2"), "leads to road 2, to which there is no way from road 3"),
        (
            route("3").replace("shortest", "random"),
            'routeStrategy = "random" is not supported; use shortest or fastest',
        ),
        (route("3").replace('closed="false"', 'closed="true"'), 'closed = "true" is not supported'),
        (trajectory((50, -1.75, 0)), "should have at least two <Vertex>"),
        (
            trajectory(inner="<Clothoid/>"),
            '<Clothoid> of Trajectory "t" is not supported; write the trajectory as a Poly',
        ),
        (trajectory((53, -1.75, 0), (70, -1.75, 1)), "begins 3.0 m from the entity at 0.00 s, but bodies cannot jump"),
        (
            trajectory((50, -1.75, 1), (70, -1.75, 1), timing=RELATIVE),
            "time = 1 should be later than that of the vertex",
        ),
        (backwards_in_lanes(), "drives backwards, for which all positions should be a WorldPosition"),
    ],
)
def test_what_cannot_be_driven_is_one_line(action, expected, tmp_path):
    text = document({"Ego": at(50) + speed(10) + action})
    if expected is None:  # a later route replaces the first
        assert start(tmp_path, text, *crossing()).travellers["Ego"].route == []
        return
    with pytest.raises(TrafficInputError) as error:
        start(tmp_path, text, *crossing())
    assert expected in str(error.value)
    assert "\n" not in str(error.value)


def test_the_truth_follows_a_trajectory(tmp_path):
    """Fails if the bodies' feasible motion leaves a smooth trajectory, or headings of vertices are ignored."""
    xs = np.arange(50, 131, 5.0)
    ys = -1.75 - 1.75 * (1 - np.cos(np.pi * (xs - 50) / 80))
    vertices = [(x, y, t) for x, y, t in zip(xs, ys, (xs - 50) / 10, strict=True)]
    drive = at(50) + speed(10) + trajectory(*vertices, timing=RELATIVE)
    start(tmp_path, document({"Ego": at(20) + speed(10), "Other": drive}))
    source = OpenScenarioSource(OpenScenarioTraffic(file="a.xosc", ego="Ego"), tmp_path, 200.0)
    source.reset(1)
    frames = [source.step() for _ in range(60)]
    source.close()
    assert max(np.hypot(*frame.actors.deviation[0]) for frame in frames) < 0.15
    centre = frames[50].actors.pose_world[0, :2] + source.origin
    x = 50 + 10 * frames[50].time
    heading = math.atan2(-1.75 * math.pi / 80 * math.sin(math.pi * (x - 50) / 80), 1)
    y = -1.75 - 1.75 * (1 - math.cos(math.pi * (x - 50) / 80))
    assert centre == pytest.approx((x + 1.4 * math.cos(heading), y + 1.4 * math.sin(heading)), abs=0.15)


def test_the_truth_reverses_out_of_the_lane(tmp_path):
    """2 m/s backwards to another lane, where the entity stands; a body that rolls forwards would turn around."""
    back = trajectory(*((60 - x, -1.75 - 0.02 * x**2, x / 2, 0.04 * x) for x in range(11)), timing=RELATIVE)
    start(tmp_path, document({"Ego": at(20) + speed(1), "Other": at(60) + back}), *crossing())
    source = OpenScenarioSource(OpenScenarioTraffic(file="a.xosc", ego="Ego"), tmp_path, 200.0)
    source.reset(1)
    frames = [source.step() for _ in range(90)]
    source.close()
    assert max(np.hypot(*frame.actors.deviation[0]) for frame in frames) < 0.1
    assert frames[40].actors.velocity_world[0] @ [math.cos(0.3), math.sin(0.3)] == pytest.approx(-2, abs=0.1)
    assert frames[-1].actors.pose_world[0, 2] == pytest.approx(0.4, abs=0.01)
    assert not frames[-1].actors.velocity_world[0].any()
