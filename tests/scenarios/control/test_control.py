"""The ego's controller: its model, whom it takes for the vehicle ahead, its two eyes, and how its drives are graded."""

import math

import numpy as np
import pytest
import shapely
from hypothesis import given
from hypothesis import strategies as st
from support.frames import DT, Body, Estimate, observe, tracks_of, world_frame

from scenarios.control.control_config import CruiseConfig
from scenarios.control.corridor import Lead, along_path, lead_of, nearest_inside
from scenarios.control.cruise import Cruise, idm_acceleration
from scenarios.control.safety import NEVER_CLOSING, NO_CONTROL, NO_FRAME, NOBODY_AHEAD, SafetyLog, grade
from scenarios.control.surroundings import Surroundings, TrackEye, truth_around
from scenarios.grading.metric_names import CONTROL
from sim.world import Kind
from tracker.records import Status

# The model's authors' values for a motorway: 120 km/h, 1.6 s, 2 m, 0.73 and 1.67 m/s^2.
PUBLISHED = CruiseConfig("cruise", 120 / 3.6, 1.6, 2.0, 0.73, 1.67)


def around(*bodies, speed=10.0, yaw_rate=0.0):
    """Surroundings of an ego 4.8 m long; a body is (x, y, yaw, length, width, speed)."""
    table = np.array(bodies, dtype=np.float64).reshape(-1, 6)
    velocity = table[:, 5:] * np.column_stack([np.cos(table[:, 2]), np.sin(table[:, 2])])
    return Surroundings(speed, yaw_rate, 2.4, np.arange(len(table)) + 70, table[:, :5], velocity)


# ---- the model


@pytest.mark.parametrize(
    ("speed", "lead", "expected"),
    [
        (0.0, None, 0.73),
        # half the set speed: 0.73 (1 - 1/16)
        (120 / 7.2, None, 0.684375),
        (120 / 3.6, None, 0.0),
        # 20 m/s, nobody closing: s* = 2 + 32 = 34, (v/v0)^4 = 0.6^4 = 0.1296, (34/68)^2 = 0.25
        (20.0, Lead(0, 68.0, 20.0), 0.73 * 0.6204),
        # the leader 2 m/s slower: s* = 34 + 20 * 2 / (2 sqrt(0.73 * 1.67)) = 34 + 18.1141
        (20.0, Lead(0, 68.0, 18.0), 0.73 * (1 - 0.1296 - (52.1141 / 68.0) ** 2)),
        # the leader runs away: s* falls to s0, no lower
        (20.0, Lead(0, 20.0, 40.0), 0.73 * (1 - 0.1296 - 0.01)),
        # stopped at the standstill gap
        (0.0, Lead(0, 2.0, 0.0), 0.0),
    ],
)
def test_the_model_accelerates_as_its_authors_equations_say(speed, lead, expected):
    # Treiber, Hennecke and Helbing 2000, equations (2) and (3)
    assert idm_acceleration(speed, lead, PUBLISHED) == pytest.approx(expected, abs=1e-5)


@pytest.mark.parametrize("gap", [3.0, 0.0, -1.0])
def test_it_brakes_no_harder_than_it_may_even_in_a_crash(gap):
    assert idm_acceleration(20.0, Lead(0, gap, 0.0), PUBLISHED) == -8.0


def test_the_wanted_speed_is_the_sum_of_accelerations_and_never_negative():
    cruise = Cruise(CruiseConfig("cruise", 20.0, acceleration_mps2=1.5), DT)
    assert cruise.decide(around(speed=0.0)).speed_mps == pytest.approx(1.5 * DT)
    # the vehicle has not moved yet: the next step adds on, and does not start from its speed again
    assert cruise.decide(around(speed=0.0)).speed_mps == pytest.approx(3.0 * DT)
    stopped = cruise.decide(around((4.0, 0.0, 0.0, 3.0, 1.8, 0.0), speed=0.0))
    assert (stopped.speed_mps, stopped.lead.gap) == (0.0, pytest.approx(0.1))


def test_the_wanted_speed_does_not_run_away_from_a_vehicle_that_is_held_back():
    cruise = Cruise(CruiseConfig("cruise", 30.0), DT)
    wanted = [cruise.decide(around(speed=5.0)).speed_mps for _ in range(200)]
    assert wanted[-1] == 8.0


@pytest.mark.parametrize(
    ("key", "value"),
    [("set_speed_mps", 0.0), ("time_gap_s", -1.0), ("corridor_half_width_m", math.nan), ("max_deceleration_mps2", 1.9)],
)
def test_settings_out_of_range_are_refused_in_one_line(key, value):
    with pytest.raises(ValueError, match=rf"^{key} = {value} must [^\n]+$"):
        CruiseConfig(**{"kind": "cruise", "set_speed_mps": 20.0, key: value})


# ---- the corridor


def test_the_nearest_of_those_who_reach_into_the_corridor_is_ahead():
    beside, near, far, behind = (20.0, 3.5), (30.0, 0.4), (45.0, 0.0), (-15.0, 0.0)
    others = [(*place, 0.0, 4.6, 1.8, 9.0) for place in (beside, far, near, behind)]
    lead = lead_of(around(*others), 1.3)
    assert (lead.id, lead.gap, lead.speed) == (72, pytest.approx(30.0 - 2.3 - 2.4), 9.0)
    assert lead_of(around(*others[:1], *others[3:]), 1.3) is None
    assert lead_of(around(), 1.3) is None


@pytest.mark.parametrize(("y", "ahead"), [(2.21, False), (2.19, True), (-2.19, True), (-2.21, False)])
def test_whoever_reaches_in_with_its_side_is_ahead(y, ahead):
    # 1.3 m of corridor and half of 1.8 m of car: 2.2 m
    assert (lead_of(around((20.0, y, 0.0, 4.6, 1.8, 5.0)), 1.3) is not None) == ahead


def test_of_a_slanted_car_that_cuts_in_only_what_is_in_the_corridor_counts():
    # A square of 2 m by 2 m on its tip: its edges rise at 45 degrees from the lowest corner, (20, 2 - sqrt(2)).
    # At y = 1.3 the edge that is nearer to the ego is 1.3 - 0.5858 before x = 20.
    lead = lead_of(around((20.0, 2.0, math.pi / 4, 2.0, 2.0, 0.0)), 1.3)
    assert lead.gap == pytest.approx(20.0 - (1.3 - (2.0 - math.sqrt(2.0))) - 2.4)


def test_a_wall_across_the_corridor_is_met_though_its_corners_are_outside():
    lead = lead_of(around((25.0, 0.0, math.pi / 2, 30.0, 0.5, 0.0)), 1.3)
    assert lead.gap == pytest.approx(25.0 - 0.25 - 2.4)


@pytest.mark.parametrize("left", [1.0, -1.0])
def test_in_a_bend_the_car_on_the_arc_is_ahead_and_the_one_straight_on_is_not(left):
    # 20 m/s at 0.2 rad/s: a radius of 100 m. At 40 m along it, x = 100 sin 0.4, y = 100 (1 - cos 0.4) = 7.9.
    on_arc = (100 * math.sin(0.4), left * 100 * (1 - math.cos(0.4)), left * 0.4, 4.6, 1.8, 12.0)
    straight_on = (30.0, 0.0, 0.0, 4.6, 1.8, 3.0)
    lead = lead_of(around(on_arc, straight_on, speed=20.0, yaw_rate=left * 0.2), 1.3)
    assert lead.id == 70
    assert lead.gap == pytest.approx(40.0 - 2.3 - 2.4, abs=0.05)  # a straight box on an arc: its sagitta
    assert lead.speed == pytest.approx(12.0)


def test_a_standing_ego_looks_straight_ahead():
    """Its yaw rate over its speed would be anything."""
    lead = lead_of(around((20.0, 0.0, 0.0, 4.6, 1.8, 0.0), speed=0.0, yaw_rate=1e-3), 1.3)
    assert lead.gap == pytest.approx(20.0 - 2.3 - 2.4, abs=0.05)


@given(st.floats(20.0, 5000.0), st.sampled_from([-1, 1]), st.floats(0.0, 50.0), st.floats(-10.0, 10.0))
def test_along_the_path_undoes_going_along_it(radius, left, way, offset):
    turn = way / radius
    point = [math.sin(turn) * (radius - offset), left * (radius - math.cos(turn) * (radius - offset))]
    assert along_path(np.array(point), left / radius) == pytest.approx([way, left * offset], abs=1e-8)


def test_a_straight_path_leaves_points_where_they_are():
    points = np.array([[3.0, -4.0], [50.0, 1.0]])
    np.testing.assert_allclose(along_path(points, 0.0), points)
    np.testing.assert_allclose(along_path(points, 2e-6), points, atol=5e-3)


@given(st.lists(st.floats(-6.0, 6.0), min_size=2, max_size=2), st.floats(-4.0, 4.0))
def test_the_nearest_point_in_the_strip_is_that_of_a_clipped_polygon(center, yaw):
    half = np.array([[2.3, 0.9], [-2.3, 0.9], [-2.3, -0.9], [2.3, -0.9]])
    cos, sin = math.cos(yaw), math.sin(yaw)
    corners = half @ np.array([[cos, sin], [-sin, cos]]) + center
    clipped = shapely.Polygon(corners).intersection(shapely.box(-50.0, -1.3, 50.0, 1.3))
    expected = math.inf if clipped.is_empty else clipped.bounds[0]
    assert nearest_inside(corners[None], 1.3)[0] == pytest.approx(expected, abs=1e-9)


# ---- the eyes


EGO_STEP = 12.0 * DT
START = (300.0, -40.0, 2.0)
"""Where the ego of `scene` is in the world at first; its odometry starts at 0."""


def scene(index):
    """An ego at 12 m/s, and a car before it at 7 m/s, one beside it, one that comes the other way."""
    cos, sin = math.cos(START[2]), math.sin(START[2])

    def place(x, y, yaw=0.0):
        return START[0] + cos * x - sin * y, START[1] + sin * x + cos * y, START[2] + yaw

    ego = place(EGO_STEP * index, 0.0)
    spots = [(35.0, 0.3, 0.0, 7.0), (10.0, 3.6, 0.0, 11.0), (60.0, 7.0, math.pi, 9.0)]
    bodies = [
        Body(5 + n, *place(x + speed * math.cos(yaw) * index * DT, y, yaw), speed=speed)
        for n, (x, y, yaw, speed) in enumerate(spots)
    ]
    frame = world_frame(index, bodies, ego)
    frame.ego.velocity_world[:] = 12.0 * cos, 12.0 * sin
    odometry = (EGO_STEP * index, 0.0, 0.0)
    estimates = [
        Estimate(100 + n, x + speed * math.cos(yaw) * index * DT, y, yaw, bodies[n].size[:2])
        for n, (x, y, yaw, speed) in enumerate(spots)
    ]
    tracks = tracks_of(estimates)
    tracks.mean[:, 2:4] = [(speed * math.cos(yaw), 0.0) for *_, yaw, speed in spots]
    return frame, observe(frame, bodies, odometry)[0], tracks


def test_both_eyes_see_the_same_where_tracks_are_true():
    eye = TrackEye(DT)
    for index in range(3):
        frame, scan, tracks = scene(index)
        seen, true = eye.look(frame.ego, scan, tracks), truth_around(frame)
        if index == 0:
            assert seen is None  # one pose makes no speed
            continue
        assert (seen.speed, seen.front_m) == (pytest.approx(12.0), true.front_m)
        assert seen.yaw_rate == pytest.approx(0.0, abs=1e-12)
        assert np.array_equal(seen.id - 100, true.id - 5)
        np.testing.assert_allclose(seen.boxes_ego, true.boxes_ego, atol=1e-9)
        np.testing.assert_allclose(seen.velocity_ego, true.velocity_ego, atol=1e-9)
        lead = lead_of(seen, 1.3)
        assert lead_of(true, 1.3).gap == pytest.approx(lead.gap)
        assert lead.gap == pytest.approx(35.0 - 5.0 * DT * index - 2.3 - 2.4)
        assert lead.speed == pytest.approx(7.0)


def test_odometry_gives_speed_along_the_heading_and_yaw_rate():
    eye = TrackEye(0.1)
    frame, scan, tracks = scene(0)
    # a circle of 50 m radius at 0.2 rad/s, 10 m/s, from a heading near the jump of angles
    for turn, expect in ((math.pi - 0.01, False), (math.pi + 0.01, True)):
        pose = (50 * math.sin(turn), -50 * math.cos(turn), math.remainder(turn, math.tau))
        scan.ego_pose_odom[:] = pose
        seen = eye.look(frame.ego, scan, tracks)
        if expect:
            assert seen.yaw_rate == pytest.approx(0.2)
            assert seen.speed == pytest.approx(10.0, rel=1e-4)
        scan = observe(frame, [], pose)[0]


@pytest.mark.parametrize("status", [Status.TENTATIVE, Status.COASTING])
def test_the_tracks_eye_sees_confirmed_tracks_only(status):
    eye = TrackEye(DT)
    for index in range(2):
        frame, scan, tracks = scene(index)
        tracks.status[0] = status
        seen = eye.look(frame.ego, scan, tracks)
    assert seen.id.tolist() == [101, 102]


def test_a_bent_truck_is_in_the_way_with_its_tractor_as_well():
    """Its trailer stands beside the corridor; the tractor, turned by 60 degrees, reaches into it."""
    frame = world_frame(0, [Body(9, 25.0, 4.0, size=(16.5, 2.55, 4.0), kind=Kind.TRAILER_TRUCK), Body(11, 60.0, 0.0)])
    assert lead_of(truth_around(frame), 1.3).id == 11
    frame.actors.articulation[0] = -math.pi / 3
    true = truth_around(frame)
    assert true.id.tolist() == [9, 11, 9]
    assert lead_of(true, 1.3).id == 9


# ---- grading


def logged(*frames, size=4.6):
    """A log of frames of (gap to a car ahead or None, its speed, the ego's speed, the ego's acceleration)."""
    log = SafetyLog()
    for index, (gap, speed, ego_speed, acceleration) in enumerate(frames):
        bodies = [] if gap is None else [Body(3, 2.4 + gap + size / 2, 0.0, 0.0, speed)]
        frame = world_frame(index, bodies)
        frame.ego.velocity_world[:] = ego_speed, 0.0
        frame.ego.acceleration_world[:] = acceleration, 0.0
        log.add(frame, wanted_mps=None)
    return log


def values(metrics):
    return {name.removeprefix("control."): metric.value for name, metric in metrics.items()}


def test_time_to_collision_is_gap_over_closing_speed_at_its_least():
    # Hayward 1972: 20 m at 5 m/s are 4 s, 12 m at 4 m/s are 3 s, 10 m at -1 m/s are none
    by_tracks = logged((20.0, 5.0, 10.0, 0.5), (12.0, 5.0, 9.0, -3.0), (10.0, 9.0, 8.0, -1.0))
    by_truth = logged((30.0, 5.0, 10.0, 0.0))
    metrics, tables = grade({"tracks": by_tracks, "truth": by_truth})
    assert metrics.keys() == CONTROL.keys()
    assert values(metrics) == {
        "min_ttc_s": pytest.approx(3.0),
        "min_gap_m": pytest.approx(10.0),
        "max_deceleration_mps2": 3.0,
        "collisions": 0.0,
        "truth_min_ttc_s": pytest.approx(6.0),
        "truth_min_gap_m": pytest.approx(30.0),
        "truth_max_deceleration_mps2": 0.0,
        "truth_collisions": 0.0,
    }
    assert metrics["control.min_ttc_s"].n == 2
    assert tables["control"]["driver"].tolist() == ["tracks"] * 3 + ["truth"]


def test_each_other_that_is_hit_counts_once_and_leaves_no_time():
    log = logged((1.0, 0.0, 5.0, 0.0), (-0.2, 0.0, 5.0, 0.0), (-0.4, 0.0, 4.0, 0.0))
    found = values(grade({"tracks": log})[0])
    assert (found["collisions"], found["min_ttc_s"], found["min_gap_m"]) == (1.0, 0.0, pytest.approx(-0.4))


def test_what_is_beside_the_ego_s_body_is_not_in_its_way():
    """The ego is 1.9 m wide and the car 1.8 m: 1.86 m from middle to middle."""
    log = SafetyLog()
    log.add(world_frame(0, [Body(1, 20.0, 1.86)]), None)
    assert log.table()["gap_m"].isna().all()
    log.add(world_frame(1, [Body(1, 20.0, 1.84)]), None)
    assert log.table()["gap_m"].tolist()[1] == pytest.approx(20.0 - 2.3 - 2.4)


def test_what_does_not_apply_is_none_with_its_reason():
    nobody, _ = grade({"tracks": logged((None, 0.0, 5.0, 0.0)), "truth": SafetyLog()})
    assert nobody["control.min_gap_m"].reason == nobody["control.min_ttc_s"].reason == NOBODY_AHEAD
    assert nobody["control.truth_collisions"].reason == NO_FRAME
    falling_back, _ = grade({"tracks": logged((20.0, 9.0, 5.0, 0.0))})
    assert falling_back["control.min_ttc_s"].reason == NEVER_CLOSING
    nothing, tables = grade({})
    assert {metric.reason for metric in nothing.values()} == {NO_CONTROL}
    assert {metric.value for metric in nothing.values()} == {None}
    assert tables == {}
