"""Bent trucks: two boxes, and no grade while one rectangle does not describe them."""

import cmath
import math
from dataclasses import replace

import numpy as np
import pytest
import shapely
from hypothesis import given
from hypothesis import strategies as st
from support.frames import DT, Body, Estimate, Scripted, follow, grade_run

from luxloop.scenarios.grading.articulated import parts, section_boxes
from luxloop.scenarios.grading.grading_config import GradingConfig
from luxloop.scenarios.grading.plane_geometry import CORNER_SIGNS, corner
from luxloop.sim.world import JOINTS, Kind

SIZE = (16.5, 2.55, 4.0)
LORRY = Body(0, 0.0, 15.0, kind=Kind.TRAILER_TRUCK, size=SIZE)
FRAMES = 10
coordinates, turns = st.floats(-50, 50), st.floats(-3, 3)


def bent(deg, **changes):
    return replace(LORRY, articulation=math.radians(deg), **changes)


def first(*angles):
    """Angles (N, JOINTS) of vehicles with one joint."""
    return np.pad(np.array(angles)[:, None], ((0, 0), (0, JOINTS - 1)))


def outline(pose, size):
    return shapely.Polygon(corner(np.hstack([pose, size])[:, None], CORNER_SIGNS)[0])


def cab(body):
    """Box of a truck's tractor: 2.9 m long, from 1.6 m ahead of the kingpin, which is 4.5 m behind the front."""
    along = cmath.exp(1j * body.yaw)
    kingpin = complex(body.x, body.y) + (8.25 - 4.5) * along
    middle = kingpin + (1.6 + 1.45) * along * cmath.exp(1j * body.articulation)
    return middle.real, middle.imag, body.yaw + body.articulation, 2.9, 2.55


# ---- geometry


@given(x=coordinates, y=coordinates, yaw=turns, articulation=turns)
def test_tractor_rotates_about_the_kingpin(x, y, yaw, articulation):
    body = replace(LORRY, x=x, y=y, yaw=yaw, articulation=articulation)
    _, section, pose, size = section_boxes(
        np.array([[x, y, yaw]]), np.array([SIZE[:2]]), first(articulation), np.array([Kind.TRAILER_TRUCK])
    )
    assert section.tolist() == [1, 0]
    np.testing.assert_allclose(np.hstack([pose, size])[1], cab(body), atol=1e-9)


@given(yaw=turns, length=st.floats(5, 25))
def test_parts_of_a_straight_truck_fill_its_box(yaw, length):
    pose, size = np.array([[3.0, -2.0, yaw]]), np.array([[length, 2.55]])
    _, _, poses, sizes = section_boxes(pose, size, first(0.0), np.array([Kind.TRAILER_TRUCK]))
    trailer, tractor = outline(poses[:1], sizes[:1]), outline(poses[1:], sizes[1:])
    whole = outline(pose, size)
    assert trailer.area + tractor.area == pytest.approx(whole.area)
    assert shapely.union(trailer, tractor).buffer(1e-6).contains(whole)


def test_only_bent_trucks_have_two_boxes():
    pose, size = np.array([[0.0, 0, 0], [10, 5, 1], [20, 5, 2]]), np.array([SIZE, SIZE, (4.5, 1.8, 1.5)])
    row, poses, sizes = parts(pose, size, first(0.0, 0.3, 0.0), np.array([Kind.TRAILER_TRUCK] * 2 + [Kind.CAR]))
    assert row.tolist() == [0, 1, 2, 1]
    np.testing.assert_array_equal(poses[[0, 2]], pose[[0, 2]])
    np.testing.assert_array_equal(sizes[[0, 2]], size[[0, 2]])
    np.testing.assert_allclose(sizes[[1, 3]], [(13.6, 2.55, 4.0), (2.9, 2.55, 4.0)])
    assert poses[[1, 3], 2] == pytest.approx([1.0, 1.3])


# ---- graded trucks


@pytest.mark.parametrize("sign", [1, -1])
def test_only_poses_of_trucks_bent_by_more_than_the_limit_are_not_graded(sign):
    scene = [[bent(sign * deg)] for deg in (0.0, 4.99, 5.01, 40.0)]
    script = [[follow(body, track_id=4)] for (body,) in scene]
    _, tables, grades = grade_run(scene, Scripted(script))
    assert all(grade.graded[0] for grade in grades)
    assert tables["tracks"].judged.tolist() == [True, True, False, False]
    _, tables, _ = grade_run(scene, Scripted(script), config=GradingConfig(bent_deg=45.0))
    assert tables["tracks"].judged.all()
    with pytest.raises(ValueError, match="bent_deg"):
        GradingConfig(bent_deg=0.0)


def test_a_bent_truck_without_a_track_is_missed():
    metrics, _, _ = grade_run([[bent(85.0)]] * FRAMES, Scripted([[]] * FRAMES))
    assert metrics["track.missed"].value == FRAMES
    assert metrics["track.hota"].value == 0.0


def test_one_track_of_a_bent_truck_is_graded_and_the_one_on_its_other_part_is_neither_right_nor_wrong():
    """Fails when a track on a tractor outside of the truck's straight box counts as false."""
    truck = bent(85.0)
    on_cab, on_whole = Estimate(4, *cab(truck)[:3], size=(2.9, 2.55)), follow(truck, track_id=5)
    x, y = cab(truck)[:2]
    box = outline(np.array([[truck.x, truck.y, 0.0]]), np.array([SIZE[:2]]))
    assert box.distance(outline(np.array([cab(truck)[:3]]), np.array([cab(truck)[3:]]))) > 0.2
    beyond = Estimate(6, x, y + 6.0, size=(2.9, 2.55))
    metrics, tables, _ = grade_run([[truck]] * FRAMES, Scripted([[on_cab, on_whole, beyond]] * FRAMES))
    verdicts = tables["tracks"].groupby("track_id").verdict.unique().map(list).to_dict()
    assert sorted(map(str, (verdicts[4], verdicts[5]))) == ["['graded']", "['ungraded']"]
    assert verdicts[6] == ["false"]
    assert metrics["track.false"].value == FRAMES
    assert metrics["track.missed"].value == 0


def test_a_second_track_on_a_straight_truck_is_false():
    truck = bent(0.0)
    whole, rear = follow(truck, track_id=4), Estimate(5, truck.x - 4.0, truck.y, 0.0, size=(8.0, 2.55))
    _, tables, _ = grade_run([[truck]] * FRAMES, Scripted([[whole, rear]] * FRAMES))
    assert tables["tracks"].groupby("track_id").verdict.unique().map(list).to_dict() == {4: ["graded"], 5: ["false"]}


def test_truck_keeps_its_track_while_bent():
    bends = [0.0] * 5 + [10.0, 30.0, 60.0, 30.0, 10.0] + [0.0] * 5
    scene = [[bent(deg)] for deg in bends]
    # Far bent, the tracker only sees the tractor.
    script = [
        [Estimate(4, *cab(body)[:3], size=(2.9, 2.55)) if body.articulation > 0.5 else follow(body, track_id=4)]
        for (body,) in scene
    ]
    metrics, tables, _ = grade_run(scene, Scripted(script))
    assert (tables["tracks"].actor_id == 0).all()
    assert (tables["tracks"].verdict == "graded").all()
    assert tables["truth"].graded.all()
    assert tables["tracks"].judged.sum() == 10
    assert metrics["track.hota"].value == pytest.approx(1.0)
    assert metrics["track.id_switches"].value == 0
    np.testing.assert_allclose(tables["truth"].articulation_rad, np.radians(bends))


def survival(scene, tracks):
    script = [
        [] if track is None else [follow(body, track_id=track)] for (body,), track in zip(scene, tracks, strict=True)
    ]
    metric = grade_run(scene, Scripted(script))[0]["track.occlusion_survival"]
    return metric.value, metric.n


def test_bend_is_not_an_occlusion_but_may_include_one():
    """Fails when a visible bent truck counts as occluded, or when an occlusion during a bend does not count."""
    straight, turning = bent(0.0), bent(30.0)
    hidden = bent(30.0, visible=0.0, points=0)
    assert GradingConfig().memory_s > 3 * 6 * DT
    assert survival([[straight]] * 6 + [[turning]] * 6 + [[straight]] * 6, [4] * 18) == (None, 0)
    scene = [[straight]] * 6 + [[turning]] * 6 + [[hidden]] * 6 + [[turning]] * 6 + [[straight]] * 6
    assert survival(scene, [4] * 12 + [None] * 6 + [4] * 12) == (1.0, 1)
    assert survival(scene, [4] * 12 + [None] * 6 + [9] * 12) == (0.0, 1)
