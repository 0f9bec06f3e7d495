"""Truth events on hand-made frames: overlaps with known areas, jumps, insertions, removals, changes of id, limits."""

import math
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
import shapely
from hypothesis import given
from hypothesis import strategies as st
from support.frames import DT, Body, world_frame

from luxloop.scenarios.grading.truth_events.bodies import Bodies, overlaps
from luxloop.scenarios.grading.truth_events.event_log import EventLog
from luxloop.scenarios.grading.truth_events.truth_event import ACCELERATION_MPS2, JERK_MPS3, MASK_S, OVERLAP_M2
from luxloop.sim.world import Kind

FAR = 30.0
"""[m] Out of the ego's way."""


def seen(frame, hidden=()):
    """Return the truth of a scan in which all actors are visible, except those with a hidden id."""
    visible = ~np.isin(frame.actors.id, hidden)
    return SimpleNamespace(hits=100 * visible, visible_fraction=visible.astype(float))


def log_of(scene, hidden=(), delivered_m=200.0):
    """Return the table of events of a scene (a list of bodies per frame), and what each frame says."""
    log = EventLog(0.1, 50.0, delivered_m)
    frames = [world_frame(index, bodies) for index, bodies in enumerate(scene)]
    said = [log.add(frame, seen(frame, hidden)) for frame in frames]
    return log.table(), said


def kinds(scene, **keys):
    return list(log_of(scene, **keys)[0]["kind"])


def driving(index, id=1, x=0.0, speed=10.0, **keys):
    return Body(id, x + speed * DT * index, FAR, speed=speed, **keys)


# ---- overlaps


def area(*bodies, ego=(-100.0, 0.0, 0.0)):
    """Return the pairs and areas of overlaps in a frame."""
    found = overlaps(Bodies.of(world_frame(0, bodies, ego)))
    return list(zip(found.first.tolist(), found.second.tolist(), found.area.tolist(), strict=True))


def test_two_cars_side_by_side_share_a_strip():
    # 4.6 m x 1.8 m each, 1.5 m apart sideways and 1 m along: 3.6 m x 0.3 m
    assert area(Body(1, 0, 0), Body(2, 1.0, 1.5)) == [(1, 2, pytest.approx(3.6 * 0.3))]


def test_a_car_across_another_shares_a_square():
    # the widths cross: 1.8 m x 1.8 m
    assert area(Body(1, 0, 0), Body(2, 0.3, 0.2, yaw=math.pi / 2)) == [(1, 2, pytest.approx(1.8**2))]


def test_bodies_that_touch_do_not_overlap():
    assert area(Body(1, 0, 0), Body(2, 4.6, 0), Body(3, 0, 1.8)) == []


def test_overlaps_below_the_rounding_of_corners_are_no_events():
    strip = OVERLAP_M2 / 1.8
    assert area(Body(1, 0, 0), Body(2, 4.6 - 0.9 * strip, 0)) == []
    assert len(area(Body(1, 0, 0), Body(2, 4.6 - 1.1 * strip, 0))) == 1


def test_the_tractor_of_a_bent_truck_overlaps_and_its_straight_box_does_not():
    truck = Body(1, 0, 0, size=(16.5, 2.5, 4.0), kind=Kind.TRAILER_TRUCK, articulation=math.radians(70.0))
    ahead = Body(2, 7.6, -1.0, size=(1.0, 0.5, 1.5))  # in the straight box, beside the tractor, which turns left
    assert area(truck, ahead) == []
    assert len(area(replace(truck, articulation=0.0), ahead)) == 1


poses = st.tuples(st.floats(-6, 6), st.floats(-6, 6), st.floats(-3.1, 3.1))


@given(st.lists(poses, min_size=2, max_size=5))
def test_overlaps_equal_those_of_polygons(places):
    bodies = [Body(n + 1, x, y, yaw) for n, (x, y, yaw) in enumerate(places)]
    boxes = [shapely.affinity.translate(_turned(yaw), x, y) for x, y, yaw in places]
    expected = {
        (i + 1, j + 1): boxes[i].intersection(boxes[j]).area
        for i in range(len(boxes))
        for j in range(i + 1, len(boxes))
    }
    found = {(first, second): value for first, second, value in area(*bodies)}
    assert found.keys() <= expected.keys()
    for pair, value in expected.items():
        if abs(value - OVERLAP_M2) > 1e-9:
            assert found.get(pair, 0.0) == pytest.approx(value if value > OVERLAP_M2 else 0.0, abs=1e-9)


def _turned(yaw):
    return shapely.affinity.rotate(shapely.box(-2.3, -0.9, 2.3, 0.9), yaw, origin=(0, 0), use_radians=True)


def test_a_collision_with_the_ego_is_one_event_with_its_largest_overlap():
    # the ego is 4.8 m x 1.9 m; a car drives through it, 0.5 m to the left
    scene = [[Body(1, -10 + 10 * DT * n, 0.5, speed=10.0)] for n in range(30)]
    (event,) = log_of(scene)[0].to_dict("records")
    assert (event["kind"], event["name"], event["other"]) == ("ego_collision", "car1", "ego")
    # at most 0.4 m from the ego's centre: 1.9 m + 2.4 m along, 0.95 m + 0.4 m across
    assert event["value"] == pytest.approx(4.3 * 1.35)
    first = next(n for n in range(30) if -10 + 10 * DT * n + 2.3 > -2.4 + OVERLAP_M2 / 1.35)
    last = max(n for n in range(30) if -10 + 10 * DT * n - 2.3 < 2.4 - OVERLAP_M2 / 1.35)
    assert (event["frame"], event["end_frame"]) == (first, last)


def test_overlapping_actors_are_masked_while_they_overlap():
    scene = [
        [Body(1, 10, FAR), Body(2, 20 - 10 * DT * n, FAR, yaw=math.pi, speed=10.0), Body(3, 0, 9)] for n in range(25)
    ]
    table, said = log_of(scene)
    assert list(table["kind"]) == ["overlap"]
    for n, frame in enumerate(said):
        strip = 4.6 - abs(10 - 10 * DT * n)
        assert list(frame.masked) == [1.8 * strip > OVERLAP_M2] * 2 + [False], n


# ---- presence


def test_an_actor_that_appears_in_view_is_masked_for_a_time():
    table, said = log_of([[driving(n)] if n >= 5 else [] for n in range(30)])
    assert list(table["kind"]) == ["insertion"]
    assert (table["frame"][0], table["speed_mps"][0]) == (5, 10.0)
    masked = [frame.masked.tolist() for frame in said]
    count = math.ceil(MASK_S / DT - 1e-9)
    assert masked == [[]] * 5 + [[True]] * count + [[False]] * (25 - count)


@pytest.mark.parametrize("start", [{"x": 70.0}, {"x": -49.0, "hidden": [1]}])
def test_actors_appear_out_of_range_and_behind_others_without_an_event(start):
    hidden = start.pop("hidden", ())
    assert kinds([[driving(n, **start)] if n >= 5 else [] for n in range(20)], hidden=hidden) == []


def test_actors_enter_and_leave_at_the_border_of_the_delivered_range():
    # LIDARs with 50 m: at 30 m to the side and 32 m ahead an actor is 44 m away
    scene = [[driving(n, x=32.0)] if 5 <= n < 9 else [] for n in range(20)]
    assert kinds(scene, delivered_m=50.0) == []
    assert kinds(scene, delivered_m=200.0) == ["removal", "insertion"][::-1]


def test_an_actor_that_vanishes_in_view_leaves_a_ghost_that_drives_on():
    table, said = log_of([[driving(n)] if n < 10 else [] for n in range(30)])
    assert list(table["kind"]) == ["removal"]
    assert table["frame"][0] == 9  # its last frame
    assert said[9].ghosts_world.shape == (0, 5)
    assert said[12].ghosts_world == pytest.approx(np.array([[10 * DT * 12, FAR, 0, 4.6, 1.8]]))
    assert said[10 + math.ceil(MASK_S / DT)].ghosts_world.shape == (0, 5)


@pytest.mark.parametrize("gap", [1, 6, 12])
def test_an_actor_of_the_same_size_in_the_same_place_is_a_change_of_id(gap):
    scene = [[driving(n, id=1)] if n < 10 else [driving(n, id=2)] if n >= 9 + gap else [] for n in range(40)]
    table, _ = log_of(scene)
    assert [(row["kind"], row["name"], row["other"]) for _, row in table.iterrows()] == [("id_change", "car2", "car1")]


@pytest.mark.parametrize(
    "change", [{"size": (4.7, 1.8, 1.5)}, {"x": 1.5}, {"kind": Kind.VAN}], ids=["size", "place", "kind"]
)
def test_another_body_is_no_change_of_id(change):
    scene = [[driving(n)] if n < 10 else [driving(n, id=2, **change)] for n in range(30)]
    assert sorted(kinds(scene)) == ["insertion", "removal"]


def test_a_jump_with_the_same_id_is_a_teleport_with_its_distance():
    scene = [[driving(n, x=0.0 if n < 10 else 3.4)] for n in range(30)]
    table, said = log_of(scene)
    assert list(table["kind"]) == ["teleport"]
    assert table["value"][0] == pytest.approx(3.4)
    assert [bool(frame.masked[0]) for frame in said[8:12]] == [False, False, True, True]


# ---- limits


def test_braking_at_more_than_tyres_can_is_a_violation():
    for deceleration in (0.9 * ACCELERATION_MPS2, 1.1 * ACCELERATION_MPS2):
        scene = []
        for n in range(20):
            t = n * DT
            braking = Body(1, 20 * t - deceleration * t**2 / 2, FAR, speed=20 - deceleration * t)
            scene.append([replace(braking, acceleration=(-deceleration, 0.0))])
        expected = ["limit_violation"] if deceleration > ACCELERATION_MPS2 else []
        assert kinds(scene) == expected


def test_the_acceleration_of_poses_counts_even_if_another_is_claimed():
    # 12 m/s^2 on a circle of 12 m^2/s^2: 12 m/s on a radius of 12 m
    scene = []
    for n in range(20):
        angle = 12 * n * DT / 12
        scene.append([Body(1, 12 * math.sin(angle), FAR - 12 * math.cos(angle), yaw=angle, speed=12.0)])
    (event,) = log_of(scene)[0].to_dict("records")
    assert (event["kind"], event["quantity"]) == ("limit_violation", "acceleration_mps2")
    assert event["value"] == pytest.approx(12.0, rel=0.01)


def test_a_step_of_acceleration_is_a_jerk():
    step = 1.1 * JERK_MPS3 * DT
    scene = [[driving(n, acceleration=(step if n >= 5 else 0.0, 0.0))] for n in range(10)]
    (event,) = log_of(scene)[0].to_dict("records")
    assert (event["quantity"], event["value"]) == ("jerk_mps3", pytest.approx(1.1 * JERK_MPS3))


@given(
    st.lists(st.tuples(st.floats(2, 14), st.floats(-0.4, 0.4), st.floats(-3, 3)), min_size=1, max_size=4),
    st.floats(-3.1, 3.1),
)
def test_smooth_traffic_without_overlap_has_no_events(drives, heading):
    """Cars on circles and lines with less than 6 m/s^2, each 40 m from the next."""
    scene = []
    for n in range(40):
        bodies = []
        for k, (speed, yaw_rate, start) in enumerate(drives):
            rate = yaw_rate if abs(yaw_rate) > 1e-3 else 1e-3
            yaw = heading + start + rate * n * DT
            radius = speed / rate
            away = 60.0 + 2 * abs(radius) if abs(radius) < 30 else 200.0
            x, y = radius * math.sin(yaw), away * (k + 1) * 4 - radius * math.cos(yaw)
            normal = speed * rate
            lateral = (-normal * math.sin(yaw), normal * math.cos(yaw))
            bodies.append(Body(k + 1, x, y, yaw, speed, acceleration=lateral, yaw_rate=rate))
        scene.append(bodies)
    assert kinds(scene) == []
