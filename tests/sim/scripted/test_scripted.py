"""Scripted motions: derivatives, hand-computed values, and properties of the scripted scenarios."""

import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from shapely.geometry import LineString, Polygon
from support.paths import CATALOG
from support.traffic import frames

from luxloop.scenarios.files.scenario import Scenario
from luxloop.sim.scripted.motions import Arc, LaneChange, Spin, Static, StopAndGo, Straight, state_at
from luxloop.sim.scripted.script import ScriptedActor, ScriptedEgo, ScriptedObstacle, ScriptedRing
from luxloop.sim.scripted.scripted_source import ScriptedSource, ScriptedTraffic
from luxloop.sim.source import EgoCommand, SimulatorFailedError, TrafficInputError
from luxloop.sim.world import Kind

# x, y, yaw of the six units in the ego frame: sensor facts 1.4, moved from the rear axle, 1.385 m behind the centre
UNITS = [
    (3.55 - 1.385, 0.75, 30.0),
    (3.55 - 1.385, -0.75, -30.0),
    (2.60 - 1.385, 0.93, 95.0),
    (2.60 - 1.385, -0.93, -95.0),
    (-0.85 - 1.385, 0.80, 150.0),
    (-0.85 - 1.385, -0.80, -150.0),
]


def played(config, count, seed=1, range_m=100.0):
    return frames(ScriptedSource(config, Path(), range_m), count, seed)


def scenario_frames(name, seed):
    scenario = Scenario.load(CATALOG / f"{name}.toml")
    return played(scenario.traffic, round(scenario.duration_s / scenario.traffic.dt_s), seed)


def outline(pose, size):
    """Return the corners (4, 2) of a box."""
    corners = np.array([[1, 1], [-1, 1], [-1, -1], [1, -1]]) * (np.asarray(size)[:2] / 2)
    cos, sin = math.cos(pose[2]), math.sin(pose[2])
    return corners @ np.array([[cos, sin], [-sin, cos]]) + pose[:2]


# ---- motions

SPEED = st.floats(0.5, 40.0)
LENGTH = st.floats(1.0, 200.0)
MOTIONS = st.one_of(
    st.just(Static("static")),
    st.builds(Spin, kind=st.just("spin"), rate_deg_per_s=st.floats(-90.0, 90.0)),
    st.builds(Straight, kind=st.just("straight"), speed_mps=SPEED, acceleration_mps2=st.floats(-8.0, 8.0)),
    st.builds(Arc, kind=st.just("arc"), speed_mps=SPEED, radius_m=st.one_of(LENGTH, LENGTH.map(lambda r: -r))),
    st.builds(
        StopAndGo,
        kind=st.just("stop-and-go"),
        peak_speed_mps=SPEED,
        go_s=st.floats(2.0, 20.0),
        stop_s=st.floats(0.0, 5.0),
    ),
    st.builds(
        LaneChange,
        kind=st.just("lane-change"),
        speed_mps=SPEED,
        offset_m=st.floats(-8.0, 8.0),
        change_s=st.floats(1.0, 8.0),
    ),
)


@pytest.mark.parametrize("time", [0.3, 1.1, 1.9, 2.6, 3.7])
@pytest.mark.parametrize(
    "motion",
    [
        Spin("spin", rate_deg_per_s=-40.0),
        Straight("straight", speed_mps=12.0, acceleration_mps2=-2.5),
        Arc("arc", speed_mps=9.0, radius_m=-14.0),
        StopAndGo("stop-and-go", peak_speed_mps=11.0, go_s=5.0, stop_s=1.0),
        LaneChange("lane-change", speed_mps=8.0, offset_m=3.5, change_s=4.0),
    ],
    ids=lambda motion: motion.kind,
)
def test_rates_are_derivatives_within_each_motion(motion, time):
    """Instants inside of every motion: random times miss most lane changes."""
    check_rates(motion, time, yaw=0.7)


@given(MOTIONS, st.floats(0.01, 20.0), st.floats(-4.0, 4.0))
def test_rates_are_derivatives_of_poses_and_course_equals_heading(motion, time, yaw):
    check_rates(motion, time, yaw)


def check_rates(motion, time, yaw):
    start, step = np.array([3.0, -2.0, yaw]), 1e-4
    before, now, after = (state_at([motion], start, time + k * step) for k in (-1, 0, 1))
    quotients = [
        ((after.pose - before.pose)[:2], before.velocity, now.velocity, after.velocity),
        ((after.pose - before.pose)[2], before.yaw_rate, now.yaw_rate, after.yaw_rate),
        (after.velocity - before.velocity, before.acceleration, now.acceleration, after.acceleration),
    ]
    for change, rate_before, rate, rate_after in quotients:
        # where a rate has a kink or jump, as at a stop, the difference quotient is off by its change over the step
        slack = np.abs(np.subtract(rate_after, rate_before)).max() + 1e-5
        assert change / (2 * step) == pytest.approx(rate, abs=slack)
    speed = np.hypot(*now.velocity)
    heading = np.array([math.cos(now.pose[2]), math.sin(now.pose[2])])
    assert heading * speed == pytest.approx(now.velocity, abs=1e-9 * speed)


def test_braking_ends_at_standstill_after_half_v_squared_over_a():
    stopped = Straight("straight", speed_mps=12.0, acceleration_mps2=-4.0).at(10.0)
    assert stopped.pose == pytest.approx([18.0, 0.0, 0.0])  # 144 / 8
    assert (*stopped.velocity, *stopped.acceleration) == (0.0, 0.0, 0.0, 0.0)


def test_backwards_the_heading_stays_against_the_motion():
    backing = Straight("straight", speed_mps=-4.0, acceleration_mps2=2.0)
    assert backing.at(1.0).pose == pytest.approx([-3.0, 0.0, 0.0])
    assert backing.at(1.0).velocity == pytest.approx([-2.0, 0.0])
    assert backing.at(9.0).pose == pytest.approx([-4.0, 0.0, 0.0])  # 16 / 4, at standstill
    assert not backing.at(9.0).velocity.any()
    quarter = Arc("arc", speed_mps=-10.0, radius_m=-20.0).at(math.pi)
    assert quarter.pose == pytest.approx([-20.0, -20.0, math.pi / 2])
    assert quarter.velocity == pytest.approx([0.0, -10.0])


def test_a_quarter_circle_to_the_right():
    quarter = Arc("arc", speed_mps=10.0, radius_m=-20.0).at(math.pi)
    assert quarter.pose == pytest.approx([20.0, -20.0, -math.pi / 2])
    assert quarter.velocity == pytest.approx([0.0, -10.0])
    assert quarter.acceleration == pytest.approx([-5.0, 0.0])  # v^2 / r, to the centre


def test_a_lane_change_has_the_quintic_s_known_extremes():
    # the rest-to-rest minimum-jerk profile peaks at 1.875 d/T half way (Flash and Hogan 1985) and at 10/sqrt(3) d/T^2
    change = LaneChange("lane-change", speed_mps=20.0, offset_m=3.5, change_s=4.0)
    assert change.at(2.0).velocity == pytest.approx([20.0, 1.875 * 3.5 / 4.0])
    assert change.at(2.0).pose[1] == pytest.approx(1.75)
    peak = change.at(4.0 * (3 - math.sqrt(3)) / 6)
    assert peak.acceleration[1] == pytest.approx(10 / math.sqrt(3) * 3.5 / 16.0)
    done = change.at(5.0)
    assert done.pose == pytest.approx([100.0, 3.5, 0.0])
    assert done.velocity == pytest.approx([20.0, 0.0])


def test_stop_and_go_moves_at_half_the_peak_speed_on_average():
    motion = StopAndGo("stop-and-go", peak_speed_mps=8.0, go_s=6.0, stop_s=3.0)
    assert motion.at(3.0).velocity[0] == pytest.approx(8.0)
    assert motion.at(7.5).pose[0] == pytest.approx(24.0)
    assert motion.at(7.5).velocity[0] == 0.0
    assert motion.at(2 * 9.0 + 3.0).pose[0] == pytest.approx(2 * 24.0 + 12.0)


def test_each_motion_starts_at_the_end_of_the_previous_one():
    motions = [
        Straight("straight", 10.0, duration_s=2.0),
        Arc("arc", 10.0, 10.0, duration_s=math.pi / 2),
        Straight("straight", 10.0),
    ]
    assert state_at(motions, np.array([0.0, 0.0, 0.0]), 2.0 + math.pi / 2 + 1.0).pose == pytest.approx(
        [30.0, 20.0, math.pi / 2]
    )
    assert state_at(motions, np.array([0.0, 0.0, 0.0]), 2.0).yaw_rate == pytest.approx(1.0)  # of the later motion


# ---- the source


def test_actors_are_in_the_script_s_order_with_sizes_by_kind():
    config = ScriptedTraffic(
        ego=ScriptedEgo(x_m=1.0, y_m=2.0, yaw_deg=90.0),
        actor=[
            ScriptedActor(10.0, 0.0, kind="trailer-truck", reflectivity=0.3),
            ScriptedActor(0.0, 9.0, size_m=(4.0, 1.7, 1.4), name="small"),
            ScriptedActor(0.0, 9.0 + 200.0),
        ],
        jitter_m=0.0,
        jitter_deg=0.0,
    )
    (frame,) = played(config, 1)
    assert frame.ego.pose_world == pytest.approx([1.0, 2.0, math.pi / 2])
    assert frame.ego.size == pytest.approx([4.83, 1.91, 1.67])
    assert list(frame.actors.name) == ["trailer_truck.1", "small"]
    assert list(frame.actors.kind) == [Kind.TRAILER_TRUCK, Kind.CAR]
    assert frame.actors.size == pytest.approx(np.array([[16.5, 2.55, 4.0], [4.0, 1.7, 1.4]]))
    assert frame.actors.reflectivity[0] == 0.3


def test_jitter_is_bounded_drawn_by_seed_and_excludes_the_ego():
    config = ScriptedTraffic(actor=[ScriptedActor(20.0, 0.0)] * 40, jitter_m=0.3, jitter_deg=2.0)
    (one,), (other,) = played(config, 1, seed=1), played(config, 1, seed=2)
    for frame in (one, other):
        off = frame.actors.pose_world - (20.0, 0.0, 0.0)
        assert (np.abs(off) <= (0.3, 0.3, math.radians(2.0))).all()
        assert (np.abs(off).max(axis=0) > (0.2, 0.2, math.radians(1.5))).all()
        assert list(frame.ego.pose_world) == [0.0, 0.0, 0.0]
    assert not np.array_equal(one.actors.pose_world, other.actors.pose_world)


def test_a_parked_car_is_an_actor_without_motion():
    """Unlike an obstacle, it is therefore graded."""
    config = ScriptedTraffic(
        ego=ScriptedEgo(motion=[Straight("straight", 10.0)]), actor=[ScriptedActor(20.0, -3.0, yaw_deg=5.0)]
    )
    first, *others = (frame.actors for frame in played(config, 4))
    for actors in others:
        assert list(actors.kind) == [Kind.CAR]
        assert np.array_equal(actors.pose_world, first.pose_world)
        assert not actors.velocity_world.any()
        assert not actors.acceleration_world.any()
        assert not actors.yaw_rate.any()


def test_obstacles_match_the_script():
    source = ScriptedSource(
        ScriptedTraffic(
            obstacle=[
                ScriptedObstacle([(0, 5), (9, 5)], 3.0),
                ScriptedObstacle([(0, 0), (1, 0), (1, 1)], 2.0),
                ScriptedObstacle([(0, 9), (4, 9), (8, 9)], kind="wall", base_m=0.4, reflectivity=0.6),
                ScriptedObstacle([(20, 3)], kind="pole", diameter_m=0.3),
            ]
        ),
        Path(),
        50.0,
    )
    obstacles = source.reset(1)
    assert list(obstacles.offset) == [0, 2, 5, 7, 9, 17]
    assert list(obstacles.height) == [3.0, 2.0, 2.0, 2.0, 8.0]
    assert list(obstacles.base) == [0.0, 0.0, 0.4, 0.4, 0.0]
    assert list(obstacles.reflectivity) == [0.3, 0.3, 0.6, 0.6, 0.3]
    assert np.ptp(obstacles.vertices_world[9:], axis=0) == pytest.approx([0.3, 0.3], abs=0.02)
    source.close()
    with pytest.raises(SimulatorFailedError, match="call reset before step"):
        source.step()


def test_a_script_rejects_commands():
    source = ScriptedSource(ScriptedTraffic(actor=[ScriptedActor(9.0, 4.0)]), Path(), 50.0)
    source.reset(1)
    with pytest.raises(TrafficInputError, match=r"^scripted traffic .*speed_mps=3\.0.*sumo"):
        source.apply(EgoCommand(speed_mps=3.0))
    frame = source.step()
    assert list(source.origin) == [0.0, 0.0]
    assert not np.any(frame.ego.deviation)
    assert not np.any(np.column_stack([frame.actors.deviation, frame.actors.articulation, frame.actors.changes_lane]))


@pytest.mark.parametrize(
    "make",
    [
        lambda: ScriptedTraffic(dt_s=0.0),
        lambda: ScriptedTraffic(jitter_m=-1.0),
        lambda: ScriptedActor(0.0, 0.0, size_m=(4.0, 0.0, 1.0)),
        lambda: ScriptedActor(0.0, 0.0, reflectivity=1.5),
        lambda: ScriptedActor(0.0, 0.0, motion=[]),
        lambda: ScriptedActor(0.0, 0.0, motion=[Static("static"), Straight("straight", 1.0)]),
        lambda: ScriptedEgo(size_m=(-1.0, 1.0, 1.0)),
        lambda: ScriptedRing([], 10.0),
        lambda: ScriptedRing([8.0, 0.0], 10.0),
        lambda: ScriptedObstacle([(0, 0)], 2.0),
        lambda: ScriptedObstacle([(0, 0), (1, 0)], 0.0),
        lambda: ScriptedObstacle([], kind="pole"),
        lambda: ScriptedObstacle([(0, 0), (1, 0)], 1.0, base_m=1.0),
        lambda: Arc("arc", 1.0, 0.0),
        lambda: StopAndGo("stop-and-go", 1.0, 0.0, 1.0),
        lambda: LaneChange("lane-change", 0.0, 3.5, 4.0),
    ],
)
def test_invalid_settings_are_rejected_in_one_line(make):
    with pytest.raises(ValueError, match=r"^[^\n]+$"):
        make()


# ---- the ring


@pytest.mark.parametrize("name", ["fitting/ring", "fitting/ring-clean"])
def test_the_ring_shows_every_aspect_at_every_range(name):
    seen = scenario_frames(name, seed=3)
    pose = np.array([frame.actors.pose_world for frame in seen])  # (frames, cars, 3)
    aspect = np.degrees(pose[..., 2] - np.arctan2(pose[..., 1], pose[..., 0])) % 360.0
    for car in aspect.T:
        gaps = np.diff(np.append(np.sort(car), np.sort(car)[0] + 360.0))
        assert gaps.max() < 1.1
        fraction = np.sort(car % 1.0)
        assert np.diff(fraction).max() < 0.05, (
            "aspects must not coincide with the fitters' search grid of whole degrees"
        )
    ranges = np.sort(np.hypot(*pose[0, :, :2].T))
    assert ranges[0] == pytest.approx(8.0, abs=0.1)
    assert ranges[-1] == pytest.approx(35.0, abs=0.1)
    assert all((frame.actors.velocity_world == 0).all() for frame in seen)


def test_no_car_of_the_ring_occludes_another():
    frame = scenario_frames("fitting/ring", seed=1)[0]
    reach = np.hypot(*frame.actors.size[:, :2].T) / 2 + 0.1  # circles that hold a car at any aspect, and its jitter
    for x, y, _ in UNITS:
        to_car = frame.actors.pose_world[:, :2] - (x, y)
        bearing = np.arctan2(to_car[:, 1], to_car[:, 0])
        half_width = np.arcsin(reach / np.hypot(*to_car.T))
        for i in range(len(bearing)):
            for j in range(i):
                apart = abs((bearing[i] - bearing[j] + math.pi) % (2 * math.pi) - math.pi)
                assert apart > half_width[i] + half_width[j]


# ---- the truck


def clear_lines(frame):
    """Count unoccluded lines of sight from units to points around the hidden car, within fields of view."""
    truck, car = (list(frame.actors.name).index(name) for name in ("truck", "hidden car"))
    shrunk = Polygon(outline(frame.actors.pose_world[truck], frame.actors.size[truck] - 0.2))
    corners = outline(frame.actors.pose_world[car], frame.actors.size[car])
    around = [
        a + (b - a) * s
        for a, b in zip(corners, np.roll(corners, -1, axis=0), strict=True)
        for s in (0, 0.25, 0.5, 0.75)
    ]
    clear = total = 0
    for x, y, yaw in UNITS:
        eye = frame.ego.pose_world[:2] + np.array([x, y])
        for point in around:
            azimuth = math.degrees(math.atan2(*(point - eye)[::-1])) - yaw
            if -60.0 <= (azimuth + 180.0) % 360.0 - 180.0 <= 50.0:  # the LUX looks 50 deg left and 60 deg right
                total += 1
                clear += not LineString([eye, point]).intersects(shrunk)
    return clear, total


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_the_truck_occludes_the_car_for_the_time_in_the_description(seed):
    for frame in scenario_frames("occlusion/truck-shadow", seed)[::2]:
        assert frame.ego.pose_world[2] == 0.0
        clear, total = clear_lines(frame)
        if 3.5 <= frame.time <= 4.9:
            assert clear == 0
        elif frame.time <= 2.2 or frame.time >= 6.4:
            assert clear == total > 0
