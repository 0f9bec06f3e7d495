"""Physical truth layer: feasible motions are preserved, infeasible ones become feasible."""

import math
from dataclasses import fields
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from support import naive_physical
from support.few import few
from support.naive_rolling import follow

from luxloop.sim.articulation import hitch
from luxloop.sim.kinematics import RawFrame, wrap_angle
from luxloop.sim.physical.body_tables import REAR_AXLE
from luxloop.sim.physical.layer import PhysicalTruth
from luxloop.sim.physical.physical_config import PhysicalConfig
from luxloop.sim.physical.spline import acceleration_weights, smoothing_weights, velocity_weights
from luxloop.sim.roster import Roster
from luxloop.sim.scripted.motions import Arc, LaneChange, StopAndGo, Straight, state_at
from luxloop.sim.world import Kind

DT = 0.08
SIZE = (4.6, 1.8, 1.5)
LONG = 16.5
LEAD, ARM = REAR_AXLE * SIZE[0], (REAR_AXLE - 0.5) * SIZE[0]
LATE = PhysicalConfig()
AT_ONCE = PhysicalConfig(lookahead_s=0.0)


def member(kind=Kind.CAR, size=SIZE):
    roster = Roster(1)
    roster.add("ego", Kind.CAR, SIZE)
    return roster.add("it", kind, size, "it")


def driven(fronts, yaws, speeds, config=LATE, road_user=None, rolling=True):
    """Return the kinematics of one body from its raw fronts (T, 2), yaws (T,) and speeds (T,), frame by frame."""
    road_user = road_user or member()
    back = 0.5 * road_user.size[0] * np.column_stack([np.cos(yaws), np.sin(yaws)]) * rolling
    layer, out = PhysicalTruth(DT, config, rolling=rolling), []
    for centre, yaw, speed in zip(np.asarray(fronts, float) - back, yaws, speeds, strict=True):
        layer.push(RawFrame([road_user], np.array([[*centre, yaw]]), np.array([speed], dtype=float)))
        while settled := layer.pop():
            out.append(settled[1])
    layer.end()
    while settled := layer.pop():
        out.append(settled[1])
    assert len(out) == len(fronts)
    return out


def column(frames, name):
    return np.array([getattr(frame, name)[0] for frame in frames])


def along_x(speeds, start=0.0):
    """Return fronts, yaws and speeds of a body that drives along x as in SUMO: each step at its new speed."""
    x = start + np.cumsum(np.asarray(speeds, float)) * DT
    return np.column_stack([x, np.zeros(len(x))]), np.zeros(len(x)), np.asarray(speeds, float)


def scripted(motions, count=150):
    states = [state_at(motions, np.zeros(3), n * DT) for n in range(count)]
    return (
        np.array([state.pose[:2] for state in states]),
        np.array([state.pose[2] for state in states]),
        np.array([np.hypot(*state.velocity) for state in states]),
        states,
    )


# ---- the smoothing


@pytest.mark.parametrize("half", [1, 2, 4, 15])
def test_weights_are_exact_for_constant_speed_and_acceleration(half):
    t = DT * np.arange(-half, half + 1)
    assert smoothing_weights(half) @ np.ones_like(t) == pytest.approx(1.0)
    assert smoothing_weights(half) @ (3.0 * t) == pytest.approx(0.0, abs=1e-12)
    assert velocity_weights(half, DT) @ (7.0 + 3.0 * t) == pytest.approx(3.0)
    assert acceleration_weights(half, DT) @ (7.0 + 3.0 * t + 2.0 * t**2) == pytest.approx(4.0)


def test_the_kernel_is_as_wide_as_a_cubic_b_spline():
    # its variance is a third of the squared distance of knots, 4/12 (de Boor 1978); half a window of 16 has 8 of it
    half = 15
    assert smoothing_weights(half) @ np.arange(-half, half + 1) ** 2 == pytest.approx(8.0**2 / 3, rel=1e-3)


# ---- feasible motions are preserved


def test_a_straight_drive_is_preserved():
    fronts, yaws, speeds = along_x(np.full(120, 13.0))
    out = driven(fronts, yaws, speeds)
    assert column(out, "pose_world")[:, 0] == pytest.approx(fronts[:, 0] - SIZE[0] / 2, abs=1e-9)
    assert column(out, "velocity_world") == pytest.approx(np.tile([13.0, 0.0], (120, 1)), abs=1e-9)
    assert np.abs(column(out, "deviation")).max() < 1e-9


def test_on_a_circle_the_rear_axle_runs_inside_the_front():
    """The rear axle of a tractrix on a circle of radius R runs on sqrt(R^2 - b^2), and v_axle = v sqrt(1 - (b/R)^2)."""
    radius, speed = 20.0, 6.0
    fronts, yaws, speeds, _ = scripted([Arc("arc", speed, radius)], 200)
    out = driven(fronts, yaws, speeds)[60:-20]
    cut = speed**2 / radius * (8 * DT) ** 2 / 3 / 2  # smoothing with this variance cuts the bend
    axle = math.sqrt((radius - cut) ** 2 - LEAD**2)
    centre = np.hypot(column(out, "pose_world")[:, 0], column(out, "pose_world")[:, 1] - radius)
    assert centre == pytest.approx(np.full(len(out), math.hypot(axle, ARM)), abs=0.03)
    assert column(out, "yaw_rate") == pytest.approx(np.full(len(out), speed / radius), rel=0.01)
    assert np.hypot(*column(out, "velocity_world").T) == pytest.approx(speed / radius * centre, rel=0.01)
    # toward the centre with v^2 / r
    assert np.hypot(*column(out, "acceleration_world").T) == pytest.approx((speed / radius) ** 2 * centre, rel=0.03)


def test_a_body_already_in_motion_is_only_smoothed():
    """As for highway-env: poses of the centre, slip included; a bend of 4 m/s^2 shifts by a * variance / 2."""
    config = PhysicalConfig(smoothing_s=0.32, lookahead_s=0.32)
    fronts, yaws, speeds, states = scripted([Arc("arc", 10.0, 25.0)], 80)
    out = driven(fronts, yaws, speeds, config, rolling=False)[5:-5]
    states = states[5:-5]
    assert column(out, "pose_world")[:, :2] == pytest.approx(np.array([s.pose[:2] for s in states]), abs=0.03)
    assert column(out, "yaw_rate") == pytest.approx(np.full(len(out), 0.4), abs=1e-6)
    assert column(out, "velocity_world") == pytest.approx(np.array([s.velocity for s in states]), abs=0.05)


def test_front_and_trailer_match_an_integration_in_small_steps():
    """Compares with an integration of the no-slip conditions in steps of 0.1 ms."""
    truck = member(Kind.TRAILER_TRUCK, (LONG, 2.55, 4.0))
    radius, speed, count = 25.0, 5.0, 120
    fronts, yaws, speeds, _ = scripted([Arc("arc", speed, radius)], count + 40)
    out = driven(fronts, yaws, speeds, PhysicalConfig(smoothing_s=0.0), truck)
    place = hitch(np.array([LONG]))
    drive, pin, axles = (float(x[0]) for x in (place.drive_axle, place.kingpin, place.trailer_axles))

    def path(t):
        return speed * math.cos(speed / radius * t), speed * math.sin(speed / radius * t)

    (x, y, yaw), trailer = follow(path, drive, 0.0, count * DT, (drive - pin, axles - pin, 0.0))
    pose, bend = out[count].pose_world[0], out[count].articulation[0]
    # the circle begins with a jump of curvature, to which the tractor adapts in a tenth of a second
    assert pose[2] == pytest.approx(trailer, abs=0.03)
    assert bend == pytest.approx(yaw - trailer, abs=0.02)
    assert bend > 0.15
    assert np.abs(column(out[15:], "deviation")).max() < 0.15, "the tractor's front left the path"
    pinned = np.array([x, y]) + (drive - pin) * np.array([math.cos(yaw), math.sin(yaw)])
    centre = pinned + (pin - LONG / 2) * np.array([math.cos(trailer), math.sin(trailer)])
    assert pose[:2] == pytest.approx(centre, abs=0.2)


def test_the_steady_articulation_angle_follows_from_the_circle():
    """Kingpin on radius k, axles on sqrt(k^2 - base^2): the tractor stands to the trailer by atan(base / axles' radius)
    minus the lead of the kingpin, ahead of the drive axle (Pythagoras on the two right triangles)."""
    truck = member(Kind.TRAILER_TRUCK, (LONG, 2.55, 4.0))
    radius = 20.0
    fronts, yaws, speeds, _ = scripted([Arc("arc", 5.0, radius)], 500)
    out = driven(fronts, yaws, speeds, PhysicalConfig(smoothing_s=0.0), truck)
    place = hitch(np.array([LONG]))
    drive, pin, axles = (float(x[0]) for x in (place.drive_axle, place.kingpin, place.trailer_axles))
    rear = math.sqrt(radius**2 - drive**2)
    kingpin = math.hypot(rear, drive - pin)
    trailer = math.sqrt(kingpin**2 - (axles - pin) ** 2)
    bend = math.atan2(axles - pin, trailer) - math.atan2(drive - pin, rear)
    assert out[450].articulation[0] == pytest.approx(bend, abs=0.005)


# ---- infeasible motions become feasible


def jumping(speed, count=200, at=100, width=3.2):
    """Return SUMO's default lane change: one step to the next lane, and two more steps with a diagonal angle."""
    fronts, yaws, speeds = along_x(np.full(count, float(speed)))
    fronts[at:, 1] = width
    yaws[at : at + 2] = math.asin(min(width / SIZE[0], 1.0))
    return fronts, yaws, speeds


def spell(out, width=3.2):
    """Return the time [s] of the front between 2 % and 98 % of the lateral shift."""
    pose = column(out, "pose_world")
    front = pose[:, 1] + SIZE[0] / 2 * np.sin(pose[:, 2])
    return DT * np.sum((front > 0.02 * width) & (front < 0.98 * width)), front


@pytest.mark.parametrize("speed", [6.0, 13.9, 25.0, 36.0])
@pytest.mark.parametrize("config", [LATE, AT_ONCE], ids=["ahead", "at once"])
def test_a_lane_jump_takes_three_to_five_seconds(speed, config):
    out = driven(*jumping(speed), config)
    took, front = spell(out)
    assert 3.0 <= took <= 5.0
    assert np.abs(np.diff(front)).max() < 2.6 * DT
    assert front[-1] == pytest.approx(3.2, abs=0.02)
    assert np.hypot(*column(out, "acceleration_world").T).max() < 3.0
    assert column(out, "changes_lane").sum() * DT == pytest.approx(3.6, abs=0.2)


def test_with_look_ahead_the_lane_change_is_centred_on_the_jump():
    _, front = spell(driven(*jumping(13.9)))
    assert front[100] == pytest.approx(1.6, abs=0.2)
    _, front = spell(driven(*jumping(13.9), AT_ONCE))
    assert front[100] == pytest.approx(0.0, abs=0.05)


def test_a_standing_body_does_not_slide_sideways():
    """SUMO changes lanes in a queue, too; a real lane change needs forward motion."""
    speeds = np.concatenate([np.zeros(80), np.linspace(0, 8, 60), np.full(120, 8.0)])
    fronts, yaws, _ = along_x(speeds)
    fronts[40:, 1] = 3.2
    out = driven(fronts, yaws, speeds)
    pose = column(out, "pose_world")
    assert (pose[:60] == pose[0]).all()
    assert pose[-1, 1] == pytest.approx(3.2, abs=0.05)


def test_a_person_steps_aside_within_two_seconds():
    """SUMO moves people sideways in one step where a sidewalk begins; as a lane change this would take 12 s."""
    size = (0.3, 0.48, 1.72)
    fronts, yaws, speeds = along_x(np.full(200, 1.2))
    fronts[100:, 1] = 0.7
    out = driven(fronts, yaws, speeds, road_user=member(Kind.PEDESTRIAN, size))
    y = column(out, "pose_world")[:, 1]
    assert np.abs(y[:80]).max() < 0.02
    assert y[120:] == pytest.approx(0.7, abs=0.05)
    assert np.abs(np.diff(y)).max() < 1.0 * DT
    assert not column(out, "changes_lane").any()


def test_a_stopped_body_is_exactly_still():
    speeds = np.concatenate([np.maximum(12.0 - 4.5 * DT * np.arange(60), 0.0), np.zeros(60)])
    out = driven(*along_x(speeds))
    pose, velocity = column(out, "pose_world")[85:], column(out, "velocity_world")[85:]
    assert (pose == pose[0]).all()
    assert (velocity == 0).all()
    assert np.abs(column(out, "deviation")[85:, 0]).max() < 0.05


def test_a_corner_of_the_lane_is_rounded():
    turn, speed, count = math.radians(30), 9.0, 120
    distance = speed * DT * np.arange(count) - 45.0
    fronts = np.where(distance[:, None] < 0, [[1.0, 0.0]], [[math.cos(turn), math.sin(turn)]]) * distance[:, None]
    yaws = np.where(distance < 0, 0.0, turn)
    out = driven(fronts, yaws, np.full(count, speed))
    assert np.hypot(*column(out, "acceleration_world").T).max() < 6.0
    assert np.abs(column(out, "deviation")).max() < 0.7
    assert column(out, "pose_world")[-1, 2] == pytest.approx(turn, abs=0.01)


def test_a_turn_on_the_spot_becomes_a_turn_of_feasible_radius():
    """SUMO at a dead end: 180 degrees in one step, onto the neighbouring lane."""
    speed, half = 4.0, 100
    fronts, yaws, _ = along_x(np.full(2 * half, speed))
    fronts[half:, 0] = 2 * fronts[half, 0] - fronts[half:, 0]
    fronts[half:, 1] = 3.2
    yaws = np.where(np.arange(2 * half) < half, 0.0, math.pi)
    out = driven(fronts, yaws, np.full(2 * half, speed))
    pose, velocity = column(out, "pose_world"), column(out, "velocity_world")
    forward = velocity[:, 0] * np.cos(pose[:, 2]) + velocity[:, 1] * np.sin(pose[:, 2])
    assert forward.min() > -1e-9
    assert np.abs(column(out, "yaw_rate")).max() < 1.2
    assert abs(pose[-1, 2]) == pytest.approx(math.pi, abs=0.2)


@given(
    seed=st.integers(0, 2**32),
    step_m=st.sampled_from([0.01, 0.3, 3.0]),
    ahead=st.booleans(),
    kind=st.sampled_from([Kind.CAR, Kind.BUS, Kind.MOTORCYCLE, Kind.PEDESTRIAN]),
)
def test_output_is_feasible_for_any_input(seed, step_m, ahead, kind):
    """Poses are noise. Accelerations and jerks may be somewhat larger than with simulated traffic, which
    test_motion_limits.py limits to 10 m/s^2 and 60 m/s^3."""
    length = {Kind.CAR: 4.6, Kind.BUS: 12.0, Kind.MOTORCYCLE: 2.1, Kind.PEDESTRIAN: 0.21}[kind]
    rng, road_user = np.random.default_rng(seed), member(kind, (length, 1.0, 1.5))
    fronts = np.cumsum(rng.normal(0.0, step_m, (60, 2)), axis=0)
    yaws, speeds = rng.uniform(-np.pi, np.pi, 60), rng.uniform(0.0, 40.0, 60) * rng.integers(0, 2, 60)
    out = driven(fronts, yaws, speeds, LATE if ahead else AT_ONCE, road_user)[1:]
    pose, velocity = column(out, "pose_world"), column(out, "velocity_world")
    acceleration = column(out, "acceleration_world")
    u = np.column_stack([np.cos(pose[:, 2]), np.sin(pose[:, 2])])
    assert np.isfinite(pose).all()
    assert np.hypot(*acceleration.T).max() <= 15.0
    assert np.abs(column(out, "yaw_rate")).max() <= (3.0 if kind is Kind.PEDESTRIAN else 1.2)
    assert np.einsum("nc,nc->n", velocity, u).min() >= -1e-9
    mean = 0.5 * (velocity[1:] + velocity[:-1])
    assert np.hypot(*(np.diff(pose[:, :2], axis=0) / DT - mean).T).max() <= 0.15
    assert np.hypot(*np.diff(acceleration, axis=0).T).max() / DT <= 200.0


# ---- presence and order


def test_members_appear_and_leave_in_the_frames_of_the_input():
    roster = Roster(1)
    one, two = (roster.add(name, Kind.CAR, SIZE, name) for name in ("one", "two"))
    layer, settled = PhysicalTruth(DT, LATE, rolling=True), []
    for n in range(100):
        there = [one, two] if 20 <= n < 50 else [one]
        pose = np.array([[n * DT * 8.0, 10.0 * road_user.id, 0.0] for road_user in there])
        layer.push(RawFrame(there, pose, np.full(len(there), 8.0)))
        settled += filter(None, [layer.pop()])
    layer.end()
    while (out := layer.pop()) is not None:
        settled.append(out)
    assert len(settled) == 100
    assert [n for n, (there, _) in enumerate(settled) if two in there] == list(range(20, 50))
    for n, (_, motion) in enumerate(settled):
        assert motion.pose_world[:, 0] == pytest.approx(n * DT * 8.0, abs=1e-9)


def test_frames_are_delivered_as_soon_as_the_look_ahead_allows():
    layer, road_user = PhysicalTruth(DT, PhysicalConfig(lookahead_s=0.4), rolling=True), member()
    came = []
    for n in range(12):
        layer.push(RawFrame([road_user], np.array([[n * 1.0, 0.0, 0.0]]), np.array([12.5])))
        came.append(sum(1 for _ in iter(layer.pop, None)))
    assert came == [0] * 5 + [1] * 7


def test_rows_are_reused_for_hundreds_of_successive_members():
    roster, layer = Roster(1), PhysicalTruth(DT, AT_ONCE, rolling=True)
    for n in range(300):
        road_user = roster.add(n, Kind.CAR, SIZE)
        layer.push(RawFrame([road_user], np.array([[5.0, float(n), 0.3]]), np.array([0.0])))
        ((there, motion),) = [layer.pop()]
        assert there == [road_user]
        assert motion.pose_world[0] == pytest.approx([5.0, n, 0.3])


@pytest.mark.parametrize(
    "motion", [StopAndGo("stop-and-go", 10.0, 6.0, 2.0), LaneChange("lane-change", 15.0, 3.5, 4.0)]
)
def test_rates_are_derivatives_of_the_poses(motion):
    fronts, yaws, speeds, _ = scripted([Straight("straight", 15.0, 0.0, 1.0), motion][isinstance(motion, StopAndGo) :])
    out = driven(fronts, yaws, speeds)
    for before, after in pairwise(out):
        step = (after.pose_world[0, :2] - before.pose_world[0, :2]) / DT
        assert step == pytest.approx(0.5 * (before.velocity_world[0] + after.velocity_world[0]), abs=0.02)
        turn = (after.pose_world[0, 2] - before.pose_world[0, 2]) / DT
        assert turn == pytest.approx(0.5 * (before.yaw_rate[0] + after.yaw_rate[0]), abs=0.02)


def test_an_articulated_ego_is_rigid():
    """The ego record has no articulation angle; the rig is on the tractor."""
    ego = Roster(1).add("ego", Kind.TRAILER_TRUCK, (LONG, 2.55, 4.0))
    fronts, yaws, speeds, _ = scripted([Arc("arc", 5.0, 25.0)], 100)
    assert not column(driven(fronts, yaws, speeds, road_user=ego), "articulation").any()


@pytest.mark.parametrize("keys", [{"smoothing_s": -0.1}, {"lane_change_s": 0.0}, {"lookahead_s": -1.0}])
def test_settings_out_of_range_are_rejected(keys):
    with pytest.raises(ValueError, match="must"):
        PhysicalConfig(**keys)


# ---- the kernels


def crowd(seed, count=100):
    """Return raw frames of road users of four kinds that appear, jump, stop, turn, also through west, and leave."""
    rng, roster = np.random.default_rng(seed), Roster(1)
    sizes = {Kind.CAR: SIZE, Kind.TRAILER_TRUCK: (LONG, 2.5, 4.0), Kind.MOTORCYCLE: (2.2, 0.8, 1.5)}
    kinds = [*sizes, Kind.PEDESTRIAN]
    members = [roster.add(n, kind, sizes.get(kind, (0.22, 0.5, 1.7))) for n, kind in enumerate(kinds)]
    speed = np.maximum(np.cumsum(rng.normal(0.0, 0.4, (count, 4)), axis=0) + rng.uniform(-2.0, 15.0, 4), 0.0)
    speed[:, 3] *= 0.1  # on foot
    course = np.pi + np.cumsum(rng.normal(0.0, 0.03, (count, 4)) * (rng.random((count, 4)) < 0.3), axis=0)
    course[:, 1] += rng.uniform(-np.pi, np.pi)
    step = speed[:, :, None] * DT * np.stack([np.cos(course), np.sin(course)], axis=2)
    jumped = (rng.random((count, 4)) < 0.01).cumsum(axis=0) * [3.2, 3.2, 3.2, 3.2 if seed % 2 else 0.8]
    front = np.cumsum(step, axis=0) + jumped[:, :, None] * np.stack([-np.sin(course), np.cos(course)], axis=2)
    coming, going = rng.integers(0, 40, 4), rng.integers(60, count, 4)
    coming[0], going[0] = 0, count
    for n in range(count):
        here = np.flatnonzero((coming <= n) & (n < going))
        pose = np.column_stack([front[n, here], wrap_angle(course[n, here])])
        yield RawFrame([members[row] for row in here], pose, speed[n, here])


@pytest.mark.parametrize("rolling", [True, False])
@pytest.mark.parametrize("config", [LATE, AT_ONCE, PhysicalConfig(0.32, lookahead_s=0.16)])
@pytest.mark.parametrize("seed", few(range(4), 0))
def test_the_kernels_equal_their_naive_twin(seed, config, rolling):
    layers = PhysicalTruth(DT, config, rolling=rolling), naive_physical.PhysicalTruth(DT, config, rolling=rolling)
    came = 0
    for raw in crowd(seed):
        for layer in layers:
            layer.push(raw)
        ours, twin = (layer.pop() for layer in layers)
        assert (ours is None) == (twin is None)
        if ours is None:
            continue
        came += 1
        assert ours[0] == twin[0]
        for part in fields(ours[1]):
            mine, other = getattr(ours[1], part.name), getattr(twin[1], part.name)
            assert (mine is None) == (other is None)
            if mine is not None:
                # limits that are just reached magnify differences of rounding
                np.testing.assert_allclose(mine, other, rtol=0, atol=1e-4)
    assert came > 50
