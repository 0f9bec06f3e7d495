"""Storyboards on small roads, against motions by hand."""

import math

import pytest
from support.storyboards import (
    STEP_S,
    act,
    after,
    at,
    by_entity,
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

from luxloop.sim.openscenario.expressions import resolved

CAR = {"Ego": at(50) + speed(20)}
TWO = CAR | {"Lead": at(100) + speed(10)}


def ego_after(folder, time, *acts, entities=None, **keys):
    return run_to(start(folder, document(entities or CAR, *acts, **keys)), time).travellers["Ego"]


def test_an_entity_follows_its_lane_at_its_speed(tmp_path):
    ego = ego_after(tmp_path, 3.0)
    assert ego.pose == pytest.approx((110.0, -1.75, 0.0))
    assert ego.centre == pytest.approx((111.4, -1.75, 0.0)), "the reference point is the rear axle"


def test_the_left_lane_drives_against_the_reference_line(tmp_path):
    ego = ego_after(tmp_path, 3.0, entities={"Ego": at(200, lane=1) + speed(20)})
    x, y, yaw = ego.pose
    assert (x, y) == pytest.approx((140.0, 1.75))
    assert abs(yaw) == pytest.approx(math.pi)


def test_an_outer_lane_of_a_bend_is_longer_than_the_reference_line(tmp_path):
    """A lane 1.75 m outside a left-hand bend of 100 m: 20 m/s turn by 20 / 101.75 rad/s."""
    bend = road('<geometry s="0" x="0" y="0" hdg="0" length="300"><arc curvature="0.01"/></geometry>', length=300)
    run = run_to(start(tmp_path, document({"Ego": at(0) + speed(20)}), bend), 5.0)
    x, y, yaw = run.travellers["Ego"].pose
    turned = 100 / 101.75
    assert yaw == pytest.approx(turned, abs=1e-6)
    assert (x, y) == pytest.approx((101.75 * math.sin(turned), 100 - 101.75 * math.cos(turned)), abs=1e-4)


@pytest.mark.parametrize(
    ("shape", "half_way"),
    [("linear", 20 - 0.25 * 10), ("cubic", 20 - 10 * 0.15625), ("sinusoidal", 20 - 10 * 0.1464466)],
)
def test_speeds_change_by_their_shape(tmp_path, shape, half_way):
    """A quarter of the way: linear x, cubic 3 x^2 - 2 x^3, sinusoidal (1 - cos pi x) / 2."""
    change = act(event(speed(10, shape, "time", 4)))
    run = start(tmp_path, document(CAR, change))
    assert run_to(run, 1.0).travellers["Ego"].speed == pytest.approx(half_way, abs=1e-6)
    assert run_to(run, 4.0).travellers["Ego"].s == pytest.approx(50 + 60, abs=1e-3), "all shapes have the mean speed"
    assert run_to(run, 6.0).travellers["Ego"].speed == 10.0


@pytest.mark.parametrize(("shape", "duration"), [("linear", 2.0), ("cubic", 3.0), ("sinusoidal", math.pi)])
def test_a_rate_is_the_largest_rate(tmp_path, shape, duration):
    change = act(event(speed(10, shape, "rate", 5)))
    run = start(tmp_path, document(CAR, change))
    assert first_time(run, lambda run: run.travellers["Ego"].speed == 10.0) == pytest.approx(duration, abs=2 * STEP_S)


def test_a_speed_changes_over_a_distance(tmp_path):
    run = start(tmp_path, document(CAR, act(event(speed(10, "linear", "distance", 30)))))
    first_time(run, lambda run: run.travellers["Ego"].speed == 10.0)
    assert run.time == pytest.approx(2.0, abs=2 * STEP_S)
    assert run.travellers["Ego"].s == pytest.approx(80.0, abs=0.2)


def test_a_relative_speed_is_kept_if_it_is_continuous(tmp_path):
    target = '<RelativeTargetSpeed entityRef="Lead" value="{}" speedTargetValueType="{}" continuous="{}"/>'
    brake = act(event(speed(4, "linear", "rate", 2)), actor="Lead", name="brake")
    for text, expected in (
        (target.format(1.5, "factor", "true"), 6.0),
        (target.format(2, "delta", "true"), 6.0),
        (target.format(2, "delta", "false"), 12.0),
    ):
        run = start(tmp_path, document(TWO, act(event(speed(0, target=text))), brake))
        assert run_to(run, 5.0).travellers["Ego"].speed == pytest.approx(expected)


def test_a_lane_change_takes_its_time_and_moves_sideways_by_its_shape(tmp_path):
    """From lane -1 to lane -2, 3.5 m: a quarter of the time gives (1 - cos(pi / 4)) / 2 of the way."""
    change = act(event(lane_change(-2, over=4), trigger(after(1), edge="rising")))
    run = start(tmp_path, document(CAR, change))
    begun = 1 + STEP_S
    assert run_to(run, begun).travellers["Ego"].t == -1.75
    ego = run_to(run, begun + 1).travellers["Ego"]
    assert ego.t == pytest.approx(-1.75 - 3.5 * 0.1464466, abs=1e-6)
    assert ego.pose[2] == pytest.approx(-math.asin(3.5 * math.pi / 8 * math.sin(math.pi / 4) / 20), abs=1e-3)
    ego = run_to(run, begun + 2).travellers["Ego"]
    assert ego.t == pytest.approx(-3.5)
    ego = run_to(run, begun + 4).travellers["Ego"]
    assert (ego.t, ego.lane) == (pytest.approx(-5.25), -2)
    assert ego.travelled == pytest.approx(20 * run.time), "the speed includes the lateral part"
    assert run.has_state(("event", "event"), "completeState")


def test_a_lane_change_over_a_distance_may_cross_the_centre(tmp_path):
    target = '<RelativeTargetLane entityRef="Ego" value="1"/>'
    change = act(event(lane_change(target, "linear", "distance", 40, offset=0.5)))
    run = start(tmp_path, document(CAR, change))
    assert run_to(run, 1.0).travellers["Ego"].t == pytest.approx(0.25), "half way from -1.75 to 1.75 + 0.5"
    assert run_to(run, 2.5).travellers["Ego"].t == pytest.approx(2.25)
    assert run.travellers["Ego"].forward == 1


def test_a_distance_is_kept_within_the_limits(tmp_path):
    """Follow at 2 s behind a lead at 10 m/s, bumper to bumper: 20 m of free space plus 4.8 m of body.

    At first 45.2 m are free, little more than 2 s at 20 m/s: the ego brakes at once.
    """
    follow = (
        '<PrivateAction><LongitudinalAction><LongitudinalDistanceAction entityRef="Lead" timeGap="2" freespace="true" '
        'continuous="true"><DynamicConstraints maxAcceleration="2" maxDeceleration="4" maxSpeed="40"/>'
        "</LongitudinalDistanceAction></LongitudinalAction></PrivateAction>"
    )
    run = start(tmp_path, document(TWO, act(event(follow))))
    run.advance(STEP_S)
    assert run.travellers["Ego"].speed == pytest.approx(20 - 4 * STEP_S), (
        "2 s at its own speed are 40 m, 45.2 m are free"
    )
    fastest, before = 0.0, run.travellers["Ego"].speed
    while run.time < 25:
        run.advance(STEP_S)
        now = run.travellers["Ego"].speed
        fastest, before = max(fastest, abs(now - before) / STEP_S), now
    ego, lead = run.travellers["Ego"], run.travellers["Lead"]
    assert fastest <= 4 + 1e-9
    assert lead.s - ego.s == pytest.approx(24.8, abs=0.05)
    assert ego.speed == pytest.approx(10, abs=0.02)


HEADWAY = '<TimeHeadwayCondition entityRef="Lead" value="{}" freespace="{}" rule="lessThan" coordinateSystem="road"/>'
COLLISION = (
    '<TimeToCollisionCondition value="2" freespace="{}" rule="lessThan"><TimeToCollisionConditionTarget>'
    '<EntityRef entityRef="Lead"/></TimeToCollisionConditionTarget></TimeToCollisionCondition>'
)
REACH = (
    '<ReachPositionCondition tolerance="1"><Position><LanePosition roadId="1" laneId="-1" s="90"/></Position>'
    "</ReachPositionCondition>"
)
DISTANCE = (
    '<RelativeDistanceCondition entityRef="Lead" value="30" freespace="{}" rule="lessThan" '
    'relativeDistanceType="{}" coordinateSystem="entity"/>'
)


@pytest.mark.parametrize(
    ("test", "expected"),
    [
        (HEADWAY.format(1.5, "false"), 2.0),  # (50 - 10 t) / 20 = 1.5
        (HEADWAY.format(1.5, "true"), 1.52),  # the same with 4.8 m less
        (COLLISION.format("false"), 3.0),  # (50 - 10 t) / 10 = 2
        (COLLISION.format("true"), 2.52),
        (REACH, 1.95),  # 50 + 20 t = 89
        (DISTANCE.format("false", "longitudinal"), 2.0),
        (DISTANCE.format("true", "longitudinal"), 1.52),
        (DISTANCE.format("false", "euclidianDistance"), 2.0),
        ('<TraveledDistanceCondition value="30"/>', 1.5),
        ('<SpeedCondition value="19" rule="greaterThan"/>', 0.0),
        ('<RelativeSpeedCondition entityRef="Lead" value="9" rule="greaterThan"/>', 0.0),
    ],
)
def test_conditions_become_true_at_the_time_by_hand(tmp_path, test, expected):
    change = act(event(speed(0), trigger(by_entity(test)), "stop"))
    run = start(tmp_path, document(TWO, change))
    time = first_time(run, lambda run: run.has_state(("event", "stop"), "completeState"))
    assert time == pytest.approx(expected, abs=STEP_S + 1e-9)


def test_standing_still_is_timed(tmp_path):
    change = act(
        event(speed(0, "linear", "time", 2), name="brake"),
        event(speed(5), trigger(by_entity('<StandStillCondition duration="3"/>')), "go"),
    )
    run = start(tmp_path, document(CAR, change))
    assert first_time(run, lambda run: run.has_state(("event", "go"), "completeState")) == pytest.approx(5, abs=0.03)


def test_edges_and_delays(tmp_path):
    late = act(event(speed(0), trigger(after(1), edge="rising", delay=0.5), "late"))
    run = start(tmp_path, document(CAR, late))
    time = first_time(run, lambda run: run.has_state(("event", "late"), "completeState"))
    assert time == pytest.approx(1.5 + STEP_S, abs=1e-9)
    never = act(event(speed(0), trigger(by_entity('<SpeedCondition value="1" rule="greaterThan"/>'), edge="rising")))
    run = run_to(start(tmp_path, document(CAR, never)), 2.0)
    assert run.has_state(("event", "event"), "standbyState"), "true from the beginning is no rising edge"


def test_conditions_of_a_group_must_all_be_true(tmp_path):
    both = trigger(after(1), by_entity('<TraveledDistanceCondition value="60"/>'))
    run = start(tmp_path, document(CAR, act(event(speed(0), both, "e"))))
    time = first_time(run, lambda run: run.has_state(("event", "e"), "completeState"))
    assert time == pytest.approx(3.0, abs=STEP_S)


def state(kind, name, value):
    return (
        f'<ByValueCondition><StoryboardElementStateCondition storyboardElementType="{kind}" '
        f'storyboardElementRef="{name}" state="{value}"/></ByValueCondition>'
    )


def test_an_event_may_follow_the_end_of_another(tmp_path):
    acts = act(
        event(speed(10, "linear", "time", 2), name="first"),
        event(lane_change(-2, over=1), trigger(state("event", "first", "endTransition"), edge="rising"), "second"),
    )
    run = start(tmp_path, document(CAR, acts, stop=trigger(state("act", "act", "completeState"), tag="StopTrigger")))
    assert first_time(run, lambda run: run.stopped) == pytest.approx(3.0, abs=3 * STEP_S)


@pytest.mark.parametrize(
    ("priority", "speed_at_3", "first"), [("override", 20.0, "complete"), ("parallel", 20.0, "running")]
)
def test_an_overriding_event_stops_the_others_of_its_maneuver(tmp_path, priority, speed_at_3, first):
    """A lane change of 10 s is stopped after 1 s by an override, and goes on beside a parallel event."""
    acts = act(
        event(lane_change(-2, "linear", over=10), name="first"),
        event(speed(20), trigger(after(1)), "second", priority),
    )
    run = run_to(start(tmp_path, document(CAR, acts)), 3.0)
    assert run.has_state(("event", "first"), f"{first}State")
    stopped = -1.75 - 3.5 * (0.1 if priority == "override" else 0.3)
    assert run.travellers["Ego"].t == pytest.approx(stopped, abs=0.01)
    assert run.travellers["Ego"].speed == speed_at_3


def test_an_event_is_repeated_as_often_as_it_says(tmp_path):
    faster = '<RelativeTargetSpeed entityRef="Ego" value="1" speedTargetValueType="delta" continuous="false"/>'
    rising = trigger(by_entity('<TraveledDistanceCondition value="1"/>'))
    run = run_to(start(tmp_path, document(CAR, act(event(speed(0, target=faster), rising, count=3)))), 2.0)
    assert run.travellers["Ego"].speed == 23.0


def test_roads_are_followed_through_links_and_opposite_directions(tmp_path):
    """The second road begins where the first ends but is written backwards: its left lane continues lane -1."""
    one = road(
        sections=section(right=[lane(-1, link='<successor id="1"/>')]),
        link='<successor elementType="road" elementId="2" contactPoint="end"/>',
    )
    backwards = f'<geometry s="0" x="700" y="0" hdg="{math.pi}" length="200"><line/></geometry>'
    two = road(backwards, section(left=[lane(1)]), 200, "2")
    entities = {"Ego": at(480) + speed(20), "Lead": at(150, 1, "2") + speed(20)}
    run = start(tmp_path, document(entities), one, two)
    ego = run_to(run, 2.0).travellers["Ego"]
    assert ego.pose[:2] == pytest.approx((520.0, -1.75))
    assert math.remainder(ego.pose[2], 2 * math.pi) == pytest.approx(0.0, abs=1e-9)
    assert "Ego" not in run_to(run, 12.0).travellers, "the entity leaves where the roads end"


def test_a_lane_change_goes_on_in_a_road_that_is_written_backwards(tmp_path):
    """Half way to lane -2 the ego enters the second road, whose left lanes continue those on the right."""
    links = (lane(-n, link=f'<successor id="{n}"/>') for n in (1, 2))
    one = road(sections=section(right=links), link='<successor elementType="road" elementId="2" contactPoint="end"/>')
    backwards = f'<geometry s="0" x="700" y="0" hdg="{math.pi}" length="200"><line/></geometry>'
    two = road(backwards, section(left=[lane(2), lane(1)]), 200, "2")
    text = document({"Ego": at(480) + speed(20)}, act(event(lane_change(-2, "linear", over=2))))
    ego = run_to(start(tmp_path, text, one, two), 1.5).travellers["Ego"]
    assert (ego.road.id, ego.lane) == ("2", 2)
    assert ego.pose[1] == pytest.approx(-1.75 - 3.5 * 0.75, abs=0.02)


def test_a_headway_is_measured_across_roads(tmp_path):
    one = road(
        sections=section(right=[lane(-1, link='<successor id="-1"/>')]),
        link='<successor elementType="road" elementId="2" contactPoint="start"/>',
    )
    two = road(
        '<geometry s="0" x="500" y="0" hdg="0" length="500"><line/></geometry>', section(right=[lane(-1)]), 500, "2"
    )
    entities = {"Ego": at(450) + speed(20), "Lead": at(20, road="2") + speed(0)}
    event_ = event(speed(0), trigger(by_entity(HEADWAY.format(2, "false"))), "e")
    run = start(tmp_path, document(entities, act(event_)), one, two)
    time = first_time(run, lambda run: run.has_state(("event", "e"), "completeState"))
    assert time == pytest.approx(1.5, abs=STEP_S + 1e-9), "(70 - 20 t) / 20 = 2"


def test_conditions_on_an_entity_that_has_left_are_false(tmp_path):
    relative = (
        '<ReachPositionCondition tolerance="900"><Position><RelativeObjectPosition entityRef="Lead" dx="1"/></Position>'
        "</ReachPositionCondition>"
    )
    entities = {"Ego": at(50) + speed(2), "Lead": at(480) + speed(20)}
    events = (
        event(speed(9), trigger(after(2), by_entity(test)), f"e{n}")
        for n, test in enumerate((relative, HEADWAY.format(900, "false"), DISTANCE.format("false", "longitudinal")))
    )
    run = run_to(start(tmp_path, document(entities, act(*events))), 4.0)
    assert list(run.travellers) == ["Ego"]
    assert run.travellers["Ego"].speed == 2.0


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("$a", "3"),
        ("${$a * 2 + 1}", "7.0"),
        ("${max($a, 5) / 2}", "2.5"),
        ("${-$a + pow(2, 3)}", "5.0"),
        ("$unknown", "$unknown"),
        ("${1 / 0}", "${1 / 0}"),
        ("${__import__('os')}", "${__import__('os')}"),
        ("${9**9**9**9}", "${9**9**9**9}"),
        ("plain", "plain"),
    ],
)
def test_expressions_are_arithmetic_of_parameters(text, value):
    assert resolved(text, {"a": "3"}) == value


def test_parameters_of_the_scenario_file_replace_those_of_the_storyboard(tmp_path):
    declared = '<ParameterDeclaration name="v" value="20"/><ParameterDeclaration name="w" value="${$v / 2}"/>'
    text = document({"Ego": at(50) + speed("$w")}, parameters=declared)
    assert start(tmp_path, text).travellers["Ego"].speed == 10.0
    assert start(tmp_path, text, parameters={"v": "30"}).travellers["Ego"].speed == 15.0
    assert start(tmp_path, text, parameters={"w": "7"}).travellers["Ego"].speed == 7.0


def test_positions_relative_to_an_entity_and_in_the_world(tmp_path):
    def place(position):
        return f"<PrivateAction><TeleportAction><Position>{position}</Position></TeleportAction></PrivateAction>"

    entities = {
        "Behind": place('<RelativeLanePosition entityRef="Ego" dLane="-1" ds="-20" offset="0.5"/>'),
        "Ego": at(100),
        "World": place('<WorldPosition x="200" y="-5" h="0"/>'),
        "Oncoming": place('<RelativeObjectPosition entityRef="Ego" dx="50" dy="3"/>'),
        "Left": at(300, lane=1),
        "BehindLeft": place('<RelativeLanePosition entityRef="Left" dLane="0" ds="-20"/>'),
    }
    placed = start(tmp_path, document(entities)).travellers
    assert list(placed) == list(entities)
    assert placed["Behind"].pose == pytest.approx((80.0, -5.25 + 0.5, 0.0))
    assert (placed["World"].pose, placed["World"].lane) == (pytest.approx((200.0, -5.0, 0.0)), -2)
    assert placed["Oncoming"].pose[:2] == pytest.approx((150.0, 1.25))
    assert placed["BehindLeft"].pose[:2] == pytest.approx((320.0, 1.75))
