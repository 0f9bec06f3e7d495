"""Unsupported elements of storyboards: refused in one line that names file, line, element and remedy."""

import pytest
from support.storyboards import (
    CAR,
    act,
    after,
    at,
    by_entity,
    document,
    event,
    lane_change,
    run_to,
    speed,
    start,
    trigger,
)

from luxloop.sim.source import TrafficInputError

EGO = {"Ego": at(50) + speed(20)}
RANDOM = "<PrivateAction><RoutingAction><RandomRouteAction/></RoutingAction></PrivateAction>"
CONTROLLER = "<PrivateAction><ControllerAction><ActivateControllerAction/></ControllerAction></PrivateAction>"
GAP = (
    '<PrivateAction><LongitudinalAction><LongitudinalDistanceAction entityRef="Ego" distance="9"/></LongitudinalAction>'
    "</PrivateAction>"
)
SIGNAL = '<ByValueCondition><TrafficSignalCondition name="a" state="b"/></ByValueCondition>'
UNKNOWN = (
    '<ByValueCondition><StoryboardElementStateCondition storyboardElementType="act" storyboardElementRef="other" '
    'state="completeState"/></ByValueCondition>'
)


def message(folder, text):
    with pytest.raises(TrafficInputError) as error:
        start(folder, text)
    text = str(error.value)
    assert text.startswith("a.xosc, line 1: <")
    assert "\n" not in text
    return text


@pytest.mark.parametrize(
    ("action", "expected"),
    [
        (RANDOM, '<RandomRouteAction> of Action "e action" is not supported; supported are SpeedAction, LaneCh'),
        (CONTROLLER, "<ActivateControllerAction> of Action"),
        (at(10), '<TeleportAction> of Action "e action" is supported in Init only'),
        (GAP, "has no DynamicConstraints"),
        (speed(-3), "value = -3: driving backwards is not supported"),
        (speed("$v"), 'value = "$v" should be a number'),
        (speed(3, "spline"), 'dynamicsShape = "spline" is not supported; use step or linear or cubic or sinusoidal'),
        (lane_change(-2, "step"), "has a step as its dynamics, but bodies cannot jump"),
        (
            lane_change('<RelativeTargetLane entityRef="Eva" value="0"/>'),
            'entityRef = "Eva" is no entity; use one of Ego',
        ),
    ],
)
def test_unsupported_actions(tmp_path, action, expected):
    assert expected in message(tmp_path, document(EGO, act(event(action, name="e"))))


@pytest.mark.parametrize(
    ("condition", "expected"),
    [
        (SIGNAL, "<TrafficSignalCondition> "),
        (UNKNOWN, 'names the act "other", which the storyboard does not have'),
        (by_entity('<EndOfRoadCondition duration="1"/>'), "<EndOfRoadCondition> of Condition"),
        (by_entity("<CollisionCondition/>"), "<CollisionCondition> of Condition"),
        (by_entity('<SpeedCondition value="1" rule="greaterThan" direction="lateral"/>'), "has a direction"),
        (by_entity('<RelativeSpeedCondition value="1" rule="lessThan"/>'), "names no other entity"),
        (by_entity('<SpeedCondition value="1" rule="is"/>'), 'rule = "is" is not supported; use greaterThan or'),
        (
            by_entity(
                '<ReachPositionCondition tolerance="1"><Position><LanePosition roadId="1" laneId="-9" s="5"/>'
                "</Position></ReachPositionCondition>"
            ),
            "laneId = -9 is no lane of road 1 at s = 5",
        ),
        (after("soon"), 'value = "soon" should be a number'),
    ],
)
def test_unsupported_conditions(tmp_path, condition, expected):
    assert expected in message(tmp_path, document(EGO, act(event(speed(1), trigger(condition)))))


@pytest.mark.parametrize(
    ("body", "expected"),
    [
        (
            CAR + '<ObjectController><Controller name="Idm"/></ObjectController>',
            'assigns the controller "Idm", which is',
        ),
        ('<MiscObject name="box"/>', '<MiscObject> "box" is no supported entity'),
        (CAR.replace("car", "tram"), 'vehicleCategory = "tram" is not supported; use car or van'),
        (CAR.replace('"1.8"', '"0"'), "should have a positive length, width and height"),
        (
            '<CatalogReference catalogName="Vehicles" entryName="estate"/>',
            'finds no entry "estate" of catalog "Vehicles"',
        ),
    ],
)
def test_unsupported_entities(tmp_path, body, expected):
    assert expected in message(tmp_path, document(EGO, bodies={"Ego": body}))


@pytest.mark.parametrize(
    ("actions", "expected"),
    [
        ("", 'has no TeleportAction of entity "Ego"; add its position'),
        (at(50, lane=-9), "laneId = -9 is no lane of road 1 at s = 50; use one of -2, -1, 1"),
        (at(501), "s = 501 is outside road 1, which is 500.0 m long"),
        (at(5, road="7"), 'roadId = "7" is no road; use one of 1'),
        (at(5).replace("LanePosition", "GeoPosition"), "<GeoPosition> is not supported; use LanePosition"),
        (
            '<PrivateAction><TeleportAction><Position><WorldPosition x="9" y="50"/></Position></TeleportAction>'
            "</PrivateAction>",
            "x = 9, y = 50 is on no lane",
        ),
        (
            '<PrivateAction><TeleportAction><Position><WorldPosition x="9" y="-2" h="1.5"/></Position></TeleportAction>'
            "</PrivateAction>",
            "is turned by 86 deg from its lane",
        ),
    ],
)
def test_unsupported_positions(tmp_path, actions, expected):
    assert expected in message(tmp_path, document({"Ego": actions}))


def test_positions_in_a_circle(tmp_path):
    relative = (
        '<PrivateAction><TeleportAction><Position><RelativeLanePosition entityRef="{}" dLane="0" ds="9"/></Position>'
        "</TeleportAction></PrivateAction>"
    )
    assert "break the circle" in message(tmp_path, document({"A": relative.format("B"), "B": relative.format("A")}))


def test_another_major_version(tmp_path):
    assert "only OpenSCENARIO XML 1.x" in message(tmp_path, document(EGO).replace('revMajor="1"', 'revMajor="2"'))


def test_an_unknown_parameter(tmp_path):
    with pytest.raises(TrafficInputError, match="declares no parameter v, only none"):
        start(tmp_path, document(EGO), parameters={"v": "1"})


def test_a_lane_change_off_the_road_names_the_place(tmp_path):
    run = start(tmp_path, document(EGO, act(event(lane_change(-7), trigger(after(1))))))
    with pytest.raises(
        TrafficInputError, match=r"leads to lane -7, which road 1 does not have at s = 70\.2 \(1\.01 s\)"
    ):
        run_to(run, 2.0)
