"""Cruise controller: driver model, lead vehicle, surroundings from tracks and truth, and safety metrics."""

import math

import numpy as np
import pytest
import shapely
from hypothesis import given
from hypothesis import strategies as st
from support.frames import DT, Body, Estimate, observe, tracks_of, world_frame

from luxloop.scenarios.control.control_config import CruiseConfig
from luxloop.scenarios.control.ego_driver import (
    NEVER_CLOSING,
    NO_CONTROL,
    NO_FRAME,
    NO_LEAD,
    CruiseController,
    LeadVehicle,
    SafetyLog,
    Surroundings,
    TrackedSurroundings,
    find_lead,
    grade,
    idm_acceleration,
    nearest_in_corridor,
    to_path_frame,
    true_surroundings,
)
from luxloop.scenarios.metrics.definitions import DEFINITIONS
from luxloop.sim.world import Kind
from luxloop.tracker.records import Status

# Published values for a motorway: 120 km/h, 1.6 s, 2 m, 0.73 and 1.67 m/s^2.
PUBLISHED = CruiseConfig("cruise", 120 / 3.6, 1.6, 2.0, 0.73, 1.67)


def around(*bodies, speed=10.0, yaw_rate=0.0):
    """Return surroundings of an ego 4.8 m long; a body is (x, y, yaw, length, width, speed)."""
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
        # 20 m/s, no closing speed: s* = 2 + 32 = 34, (v/v0)^4 = 0.6^4 = 0.1296, (34/68)^2 = 0.25
        (20.0, LeadVehicle(0, 68.0, 20.0), 0.73 * 0.6204),
        # the lead vehicle 2 m/s slower: s* = 34 + 20 * 2 / (2 sqrt(0.73 * 1.67)) = 34 + 18.1141
        (20.0, LeadVehicle(0, 68.0, 18.0), 0.73 * (1 - 0.1296 - (52.1141 / 68.0) ** 2)),
        # the lead vehicle is much faster: s* has the lower bound s0
        (20.0, LeadVehicle(0, 20.0, 40.0), 0.73 * (1 - 0.1296 - 0.01)),
        # stopped at the standstill gap
        (0.0, LeadVehicle(0, 2.0, 0.0), 0.0),
    ],
)
def test_the_acceleration_follows_the_published_equations(speed, lead, expected):
    # Treiber, Hennecke and Helbing 2000, equations (2) and (3)
    assert idm_acceleration(speed, lead, PUBLISHED) == pytest.approx(expected, abs=1e-5)


@pytest.mark.parametrize("gap", [3.0, 0.0, -1.0])
def test_the_deceleration_is_limited_even_in_a_crash(gap):
    assert idm_acceleration(20.0, LeadVehicle(0, gap, 0.0), PUBLISHED) == -8.0


def test_the_commanded_speed_integrates_the_acceleration_and_is_never_negative():
    cruise = CruiseController(CruiseConfig("cruise", 20.0, acceleration_mps2=1.5), DT)
    assert cruise.decide(around(speed=0.0)).speed_mps == pytest.approx(1.5 * DT)
    # the vehicle has not moved yet: the command accumulates and does not restart from the actual speed
    assert cruise.decide(around(speed=0.0)).speed_mps == pytest.approx(3.0 * DT)
    stopped = cruise.decide(around((4.0, 0.0, 0.0, 3.0, 1.8, 0.0), speed=0.0))
    assert (stopped.speed_mps, stopped.lead.gap) == (0.0, pytest.approx(0.1))


def test_the_commanded_speed_has_an_anti_windup_limit():
    cruise = CruiseController(CruiseConfig("cruise", 30.0), DT)
    wanted = [cruise.decide(around(speed=5.0)).speed_mps for _ in range(200)]
    assert wanted[-1] == 8.0


@pytest.mark.parametrize(
    ("key", "value"),
    [("set_speed_mps", 0.0), ("time_gap_s", -1.0), ("corridor_half_width_m", math.nan), ("max_deceleration_mps2", 1.9)],
)
def test_settings_out_of_range_are_a_one_line_error(key, value):
    with pytest.raises(ValueError, match=rf"^{key} = {value} must [^\n]+$"):
        CruiseConfig(**{"kind": "cruise", "set_speed_mps": 20.0, key: value})


# ---- the corridor


def test_the_lead_vehicle_is_the_nearest_in_the_corridor():
    beside, near, far, behind = (20.0, 3.5), (30.0, 0.4), (45.0, 0.0), (-15.0, 0.0)
    others = [(*place, 0.0, 4.6, 1.8, 9.0) for place in (beside, far, near, behind)]
    lead = find_lead(around(*others), 1.3)
    assert (lead.id, lead.gap, lead.speed) == (72, pytest.approx(30.0 - 2.3 - 2.4), 9.0)
    assert find_lead(around(*others[:1], *others[3:]), 1.3) is None
    assert find_lead(around(), 1.3) is None


@pytest.mark.parametrize(("y", "ahead"), [(2.21, False), (2.19, True), (-2.19, True), (-2.21, False)])
def test_a_vehicle_partly_in_the_corridor_is_a_lead_vehicle(y, ahead):
    # 1.3 m of corridor and half of 1.8 m of car: 2.2 m
    assert (find_lead(around((20.0, y, 0.0, 4.6, 1.8, 5.0)), 1.3) is not None) == ahead


def test_the_gap_to_a_slanted_car_ends_at_its_part_in_the_corridor():
    # A square of 2 m by 2 m, turned: its edges rise at 45 degrees from the lowest corner, (20, 2 - sqrt(2)).
    # At y = 1.3 the edge nearer to the ego is 1.3 - 0.5858 before x = 20.
    lead = find_lead(around((20.0, 2.0, math.pi / 4, 2.0, 2.0, 0.0)), 1.3)
    assert lead.gap == pytest.approx(20.0 - (1.3 - (2.0 - math.sqrt(2.0))) - 2.4)


def test_a_wall_across_the_corridor_is_found_although_its_corners_are_outside():
    lead = find_lead(around((25.0, 0.0, math.pi / 2, 30.0, 0.5, 0.0)), 1.3)
    assert lead.gap == pytest.approx(25.0 - 0.25 - 2.4)


@pytest.mark.parametrize("left", [1.0, -1.0])
def test_in_a_bend_the_car_on_the_arc_is_the_lead_vehicle(left):
    # 20 m/s at 0.2 rad/s: a radius of 100 m. At 40 m along it, x = 100 sin 0.4, y = 100 (1 - cos 0.4) = 7.9.
    on_arc = (100 * math.sin(0.4), left * 100 * (1 - math.cos(0.4)), left * 0.4, 4.6, 1.8, 12.0)
    straight_on = (30.0, 0.0, 0.0, 4.6, 1.8, 3.0)
    lead = find_lead(around(on_arc, straight_on, speed=20.0, yaw_rate=left * 0.2), 1.3)
    assert lead.id == 70
    assert lead.gap == pytest.approx(40.0 - 2.3 - 2.4, abs=0.05)  # a straight box on an arc: its sagitta
    assert lead.speed == pytest.approx(12.0)


def test_the_corridor_of_a_stationary_ego_is_straight():
    """Yaw rate divided by speed is undefined at standstill."""
    lead = find_lead(around((20.0, 0.0, 0.0, 4.6, 1.8, 0.0), speed=0.0, yaw_rate=1e-3), 1.3)
    assert lead.gap == pytest.approx(20.0 - 2.3 - 2.4, abs=0.05)


@given(st.floats(20.0, 5000.0), st.sampled_from([-1, 1]), st.floats(0.0, 50.0), st.floats(-10.0, 10.0))
def test_to_path_frame_inverts_the_path_equation(radius, left, way, offset):
    turn = way / radius
    point = [math.sin(turn) * (radius - offset), left * (radius - math.cos(turn) * (radius - offset))]
    assert to_path_frame(np.array(point), left / radius) == pytest.approx([way, left * offset], abs=1e-8)


def test_a_straight_path_frame_is_the_ego_frame():
    points = np.array([[3.0, -4.0], [50.0, 1.0]])
    np.testing.assert_allclose(to_path_frame(points, 0.0), points)
    np.testing.assert_allclose(to_path_frame(points, 2e-6), points, atol=5e-3)


@given(st.lists(st.floats(-6.0, 6.0), min_size=2, max_size=2), st.floats(-4.0, 4.0))
def test_the_nearest_point_in_the_corridor_agrees_with_polygon_clipping(center, yaw):
    half = np.array([[2.3, 0.9], [-2.3, 0.9], [-2.3, -0.9], [2.3, -0.9]])
    cos, sin = math.cos(yaw), math.sin(yaw)
    corners = half @ np.array([[cos, sin], [-sin, cos]]) + center
    clipped = shapely.Polygon(corners).intersection(shapely.box(-50.0, -1.3, 50.0, 1.3))
    expected = math.inf if clipped.is_empty else clipped.bounds[0]
    assert nearest_in_corridor(corners[None], 1.3)[0] == pytest.approx(expected, abs=1e-9)


# ---- surroundings


EGO_STEP = 12.0 * DT
START = (300.0, -40.0, 2.0)
"""Initial pose of the ego of `scene` in the world frame; its odometry starts at 0."""


def scene(index):
    """Return an ego at 12 m/s with a car ahead at 7 m/s, one beside it and one oncoming."""
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


def test_tracked_and_true_surroundings_agree_for_perfect_tracks():
    surroundings = TrackedSurroundings(DT)
    for index in range(3):
        frame, scan, tracks = scene(index)
        seen, true = surroundings.observe(frame.ego, scan, tracks), true_surroundings(frame)
        if index == 0:
            assert seen is None  # a speed needs two poses
            continue
        assert (seen.speed, seen.front_m) == (pytest.approx(12.0), true.front_m)
        assert seen.yaw_rate == pytest.approx(0.0, abs=1e-12)
        assert np.array_equal(seen.id - 100, true.id - 5)
        np.testing.assert_allclose(seen.boxes_ego, true.boxes_ego, atol=1e-9)
        np.testing.assert_allclose(seen.velocity_ego, true.velocity_ego, atol=1e-9)
        lead = find_lead(seen, 1.3)
        assert find_lead(true, 1.3).gap == pytest.approx(lead.gap)
        assert lead.gap == pytest.approx(35.0 - 5.0 * DT * index - 2.3 - 2.4)
        assert lead.speed == pytest.approx(7.0)


def test_odometry_gives_speed_along_the_heading_and_yaw_rate():
    surroundings = TrackedSurroundings(0.1)
    frame, scan, tracks = scene(0)
    # a circle of 50 m radius at 0.2 rad/s, 10 m/s, with headings across the wrap at pi
    for turn, expect in ((math.pi - 0.01, False), (math.pi + 0.01, True)):
        pose = (50 * math.sin(turn), -50 * math.cos(turn), math.remainder(turn, math.tau))
        scan.ego_pose_odom[:] = pose
        seen = surroundings.observe(frame.ego, scan, tracks)
        if expect:
            assert seen.yaw_rate == pytest.approx(0.2)
            assert seen.speed == pytest.approx(10.0, rel=1e-4)
        scan = observe(frame, [], pose)[0]


@pytest.mark.parametrize("status", [Status.TENTATIVE, Status.COASTING])
def test_only_confirmed_tracks_are_used(status):
    surroundings = TrackedSurroundings(DT)
    for index in range(2):
        frame, scan, tracks = scene(index)
        tracks.status[0] = status
        seen = surroundings.observe(frame.ego, scan, tracks)
    assert seen.id.tolist() == [101, 102]


def test_the_tractor_of_an_articulated_truck_is_considered():
    """The trailer is beside the corridor; the tractor, turned by 60 degrees, extends into it."""
    frame = world_frame(0, [Body(9, 25.0, 4.0, size=(16.5, 2.55, 4.0), kind=Kind.TRAILER_TRUCK), Body(11, 60.0, 0.0)])
    assert find_lead(true_surroundings(frame), 1.3).id == 11
    frame.actors.articulation[0] = -math.pi / 3
    true = true_surroundings(frame)
    assert true.id.tolist() == [9, 11, 9]
    assert find_lead(true, 1.3).id == 9


# ---- grading


def logged(*frames, size=4.6):
    """Return a log of frames of (gap to a lead vehicle or None, its speed, the ego's speed, the ego's acceleration)."""
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


def test_time_to_collision_is_the_minimum_of_gap_over_closing_speed():
    # Hayward 1972: 20 m at 5 m/s are 4 s, 12 m at 4 m/s are 3 s, 10 m at -1 m/s are undefined
    by_tracks = logged((20.0, 5.0, 10.0, 0.5), (12.0, 5.0, 9.0, -3.0), (10.0, 9.0, 8.0, -1.0))
    by_truth = logged((30.0, 5.0, 10.0, 0.0))
    metrics, tables = grade({"tracks": by_tracks, "truth": by_truth})
    assert metrics.keys() == {name for name in DEFINITIONS if name.startswith("control.")}
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


def test_each_actor_collided_with_counts_once():
    log = logged((1.0, 0.0, 5.0, 0.0), (-0.2, 0.0, 5.0, 0.0), (-0.4, 0.0, 4.0, 0.0))
    found = values(grade({"tracks": log})[0])
    assert (found["collisions"], found["min_ttc_s"], found["min_gap_m"]) == (1.0, 0.0, pytest.approx(-0.4))


def test_a_vehicle_beside_the_ego_is_not_a_lead_vehicle():
    """The ego is 1.9 m wide and the car 1.8 m: 1.86 m between the centres."""
    log = SafetyLog()
    log.add(world_frame(0, [Body(1, 20.0, 1.86)]), None)
    assert log.table()["gap_m"].isna().all()
    log.add(world_frame(1, [Body(1, 20.0, 1.84)]), None)
    assert log.table()["gap_m"].tolist()[1] == pytest.approx(20.0 - 2.3 - 2.4)


def test_metrics_without_a_value_have_a_reason():
    no_lead, _ = grade({"tracks": logged((None, 0.0, 5.0, 0.0)), "truth": SafetyLog()})
    assert no_lead["control.min_gap_m"].reason == no_lead["control.min_ttc_s"].reason == NO_LEAD
    assert no_lead["control.truth_collisions"].reason == NO_FRAME
    falling_back, _ = grade({"tracks": logged((20.0, 9.0, 5.0, 0.0))})
    assert falling_back["control.min_ttc_s"].reason == NEVER_CLOSING
    no_drives, tables = grade({})
    assert {metric.reason for metric in no_drives.values()} == {NO_CONTROL}
    assert {metric.value for metric in no_drives.values()} == {None}
    assert tables == {}
