"""CommonRoad files, read by commonroad-io."""

from pathlib import Path

import numpy as np
import pytest
from support.optional import need
from support.traffic import frames

from luxloop.sim.commonroad.commonroad_recording import read_traffic
from luxloop.sim.replay.recording import ReplayType
from luxloop.sim.replay.replay_config import ReplayTraffic
from luxloop.sim.replay.replay_source import ReplaySource
from luxloop.sim.source import TrafficInputError
from luxloop.sim.world import Kind

need("commonroad")

HEAD = """<?xml version="1.0" ?>
<commonRoad timeStepSize="0.1" commonRoadVersion="2020a" author="" affiliation="" source="" benchmarkID="DEU_A-1_1_T-1"
    date="2024-01-01"><location><geoNameId>-999</geoNameId><gpsLatitude>999</gpsLatitude>
    <gpsLongitude>999</gpsLongitude></location><scenarioTags><urban/></scenarioTags>
<lanelet id="1"><leftBound><point><x>0</x><y>2</y></point><point><x>99</x><y>2</y></point></leftBound>
<rightBound><point><x>0</x><y>-2</y></point><point><x>99</x><y>-2</y></point></rightBound>
<laneletType>urban</laneletType></lanelet>"""
CAR = "<rectangle><length>4.4</length><width>1.8</width></rectangle>"


def state(step, x, y, yaw, tag="state"):
    return (
        f"<{tag}><time><exact>{step}</exact></time><position><point><x>{x}</x><y>{y}</y></point></position>"
        f"<orientation><exact>{yaw}</exact></orientation><velocity><exact>10</exact></velocity></{tag}>"
    )


def dynamic(number, word, shape, poses, first=0):
    start, *later = [(first + step, *pose) for step, pose in enumerate(poses)]
    return (
        f'<dynamicObstacle id="{number}"><type>{word}</type><shape>{shape}</shape>{state(*start, tag="initialState")}'
        f"<trajectory>{''.join(state(*pose) for pose in later)}</trajectory></dynamicObstacle>"
    )


def static(number, word, shape, x, y, yaw):
    return (
        f'<staticObstacle id="{number}"><type>{word}</type><shape>{shape}</shape>'
        f"{state(0, x, y, yaw, tag='initialState')}</staticObstacle>"
    )


def drive(count, y=0.0):
    return [(float(step), y, 0.0) for step in range(count)]


@pytest.fixture
def write(tmp_path):
    def write(*obstacles) -> Path:
        path = tmp_path / "a.xml"
        path.write_text(HEAD + "".join(obstacles) + "</commonRoad>")
        return path

    return write


def test_road_users_are_read_with_their_boxes(write):
    behind = "<rectangle><length>8</length><width>2.5</width><originXShift>-3</originXShift></rectangle>"
    round_one = "<circle><radius>0.3</radius></circle>"
    read = read_traffic(
        write(
            dynamic(11, "car", CAR, drive(20)),
            dynamic(12, "truck", behind, [(5.0, 9.0, np.pi / 2)] * 3, first=4),
            dynamic(13, "pedestrian", round_one, drive(5, 4.0)),
            static(14, "parkedVehicle", CAR, 3.0, -4.0, 0.1),
        ),
        {"car": ReplayType("suv")},
    )
    assert [(user.name, user.kind) for user in read.users] == [
        ("11", Kind.SUV),
        ("12", Kind.TRUCK),
        ("13", Kind.PEDESTRIAN),
        ("14", Kind.CAR),
    ]
    assert [user.size for user in read.users] == [
        pytest.approx((4.4, 1.8, 1.7)),
        pytest.approx((8.0, 2.5, 3.2)),
        pytest.approx((0.6, 0.6, 1.72)),
        pytest.approx((4.4, 1.8, 1.46)),
    ]
    truck = read.user == 1
    assert read.time[truck] == pytest.approx([0.4, 0.5, 0.6])
    # its position is 3 m behind the centre of its box, and it faces north
    assert read.pose[truck][0] == pytest.approx([5.0, 12.0, np.pi / 2])
    parked = read.user == 3
    assert read.time[parked] == pytest.approx(np.arange(20) * 0.1)
    assert not np.diff(read.pose[parked], axis=0).any()


def test_the_box_of_an_outline_beside_its_position_is_turned_with_it(write):
    """Positions are the rear right corner; ahead is north, and left is west."""
    corners = "".join(f"<point><x>{x}</x><y>{y}</y></point>" for x, y in ((0, 0), (4, 0), (4, 2), (0, 2)))
    path = write(dynamic(11, "car", f"<polygon>{corners}</polygon>", [(5.0, 9.0, np.pi / 2)] * 3))
    read = read_traffic(path, {})
    assert read.users[0].size[:2] == pytest.approx((4.0, 2.0))
    assert read.pose[0] == pytest.approx([5.0 - 1.0, 9.0 + 2.0, np.pi / 2])


def test_other_types_are_static_obstacles(write):
    building = (
        '<environmentObstacle id="21"><type>building</type><shape><polygon><point><x>10</x><y>5</y></point>'
        "<point><x>20</x><y>5</y></point><point><x>20</x><y>9</y></point></polygon></shape></environmentObstacle>"
    )
    site = static(22, "constructionZone", "<rectangle><length>6</length><width>2</width></rectangle>", 30.0, 0.0, 1.57)
    read = read_traffic(write(dynamic(11, "car", CAR, drive(20)), site, building), {})
    assert [user.name for user in read.users] == ["11"]
    assert [prism.height for prism in read.street] == [1.0, 10.0]
    assert np.ptp(read.street[0].corners, axis=0) == pytest.approx([2.0, 6.0], abs=0.01)
    assert sorted(map(tuple, read.street[1].corners)) == [(10, 5), (20, 5), (20, 9)]


def test_a_file_can_be_played(write):
    oncoming = [(40.0 - x, y, np.pi) for x, y, _ in drive(40, 4.0)]
    path = write(dynamic(11, "car", CAR, drive(40)), dynamic(12, "car", CAR, oncoming))
    seen = frames(ReplaySource(ReplayTraffic(file="a.xml", ego="11"), path.parent, 100.0), 40)
    assert seen[-1].ego.velocity_world == pytest.approx([10.0, 0.0], abs=0.01)
    assert seen[-1].actors.velocity_world[0] == pytest.approx([-10.0, 0.0], abs=0.01)


@pytest.mark.parametrize(
    ("inside", "message"),
    [
        (static(14, "car", CAR, 0.0, 0.0, 0.0), "has no dynamic obstacle with a trajectory"),
        (
            dynamic(11, "car", CAR, drive(3)).replace("<exact>2<", "<exact>two<"),
            "commonroad-io cannot read it: ",
        ),
        (
            dynamic(11, "car", CAR, drive(3)).replace(
                "<orientation><exact>0.0</exact>",
                "<orientation><intervalStart>0.0</intervalStart><intervalEnd>0.1</intervalEnd>",
            ),
            "obstacle 11 at time step 0: position and orientation should be exact",
        ),
    ],
)
def test_invalid_files_are_errors_of_one_line(write, inside, message):
    with pytest.raises(TrafficInputError) as error:
        read_traffic(write(inside), {})
    assert message in str(error.value)
    assert "\n" not in str(error.value)
