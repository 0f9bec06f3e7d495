"""LIDAR simulation: contract of the scan, outcome of every beam, and odometry."""

import math
from dataclasses import replace

import numpy as np
import pytest
from support.sensor_scenes import (
    CENTRE_RAY,
    EGO_FRONT,
    EXACT,
    FOOTPRINT,
    LUX_RIG,
    NO_OBSTACLES,
    PLAIN,
    ActorSpec,
    ahead,
    beam_origins,
    beams_of,
    one_unit_rig,
    scan,
    small_unit,
    wall,
    walls,
    world,
)

from luxloop.sensor_model.lidar import Lidar
from luxloop.sensor_model.noise.noise_config import CalibrationError, NoiseConfig
from luxloop.sensor_model.rig.beams import beam_table
from luxloop.sensor_model.rig.unit import Fan
from luxloop.sensor_model.sensor_config import SensorConfig
from luxloop.sensor_model.truth import NO_ACTOR, Cause, Loss, Part
from luxloop.sim.world import Kind, Obstacles
from luxloop.tracker.scan import PointFlag

BEAMS = beam_table(LUX_RIG)
STREET = (
    ahead(8.0),
    ahead(14.0, y=3.5, kind=Kind.SUV),
    ActorSpec(-12, -3.5, kind=Kind.VAN),
    ActorSpec(5, -8, 1.2, Kind.BUS),
)
FENCE = wall((-40, 9), (40, 9), height=2.0)
DTYPES = {
    "ego_pose_odom": np.float64, "points_ego": np.float32, "time_offset": np.float32, "unit": np.uint8,
    "layer": np.uint8, "echo": np.uint8, "echo_pulse_width": np.float32, "flags": np.uint16,
}  # fmt: skip
TRUTH_DTYPES = {
    "actor_id": np.int64, "part": np.uint8, "cause": np.uint8, "true_range": np.float32, "lost_unit": np.uint8,
    "lost_beam": np.int32, "lost_cause": np.uint8, "unit_hits": np.int32, "unit_hits_alone": np.int32,
    "faces": np.uint8, "view": np.uint8,
}  # fmt: skip


def assert_same(one, other):
    for name in DTYPES:
        assert np.array_equal(getattr(one[0], name), getattr(other[0], name)), name
    for name in TRUTH_DTYPES:
        assert np.array_equal(getattr(one[1], name), getattr(other[1], name)), name


@pytest.mark.parametrize("actors", [STREET, ()], ids=["street", "empty"])
@pytest.mark.parametrize("noise", [NoiseConfig(), PLAIN], ids=["noisy", "plain"])
@pytest.mark.parametrize("sensor", [FOOTPRINT, CENTRE_RAY], ids=["footprint", "centre ray"])
def test_records_fulfil_the_contract(actors, noise, sensor):
    result, truth = scan(*actors, noise=noise, obstacles=FENCE, sensor=sensor)
    for record, dtypes in ((result, DTYPES), (truth, TRUTH_DTYPES)):
        for name, dtype in dtypes.items():
            assert getattr(record, name).dtype == dtype, name
    assert result.points_ego.shape == (len(result), 3)
    assert {len(getattr(truth, name)) for name in ("actor_id", "part", "cause", "true_range")} == {len(result)}
    assert {len(getattr(truth, name)) for name in ("faces", "view", "visible_fraction")} == {len(actors)}
    assert truth.unit_hits.shape == truth.unit_hits_alone.shape == (len(actors), len(LUX_RIG.mounts))
    assert len(truth.lost_unit) == len(truth.lost_beam) == len(truth.lost_cause)
    assert np.all(np.isfinite(result.points_ego))
    assert np.abs(result.time_offset).max() < 0.0134  # 60 degrees at 4500 degrees/s


@pytest.mark.parametrize("sensor", [FOOTPRINT, CENTRE_RAY], ids=["footprint", "centre ray"])
def test_points_lie_on_their_beams_in_the_order_of_the_table(sensor):
    result, truth = scan(*STREET, obstacles=FENCE, sensor=sensor)
    beam = beams_of(result, BEAMS)
    assert np.all(np.diff(beam) >= 0)
    assert np.array_equal(np.diff(beam) == 0, result.echo[1:] > 0)
    expected = beam_origins(result, BEAMS) + truth.true_range[:, None] * BEAMS.direction_ego[beam]
    np.testing.assert_allclose(result.points_ego, expected, atol=1e-4)
    np.testing.assert_allclose(result.time_offset, BEAMS.time_offset[beam], atol=1e-6)


def test_echoes_of_a_beam_are_numbered_by_range_and_separated():
    lines = [np.array([[-40.0, y], [40.0, y]]) for y in (9.0, 14.0)]
    rail_and_facade = Obstacles.from_polygons(lines, [0.75, 6.0], base=[0.45, 0.0])
    result, truth = scan(*STREET, obstacles=rail_and_facade)
    behind = np.flatnonzero(result.echo > 0)
    assert len(behind) > 50
    assert np.array_equal(result.echo[behind], result.echo[behind - 1] + 1)
    assert np.all(np.diff(truth.true_range)[behind - 1] >= BEAMS.units.echo_separation[0] - 1e-4)
    assert np.array_equal(np.flatnonzero(result.flags & PointFlag.TRANSPARENT), behind - 1)
    assert result.echo.max() <= 2


def test_pulse_widths_have_a_minimum_and_are_multiples_of_the_quantum():
    result, _ = scan(*STREET, obstacles=FENCE)
    quanta = result.echo_pulse_width / BEAMS.units.pulse_quantum[0]
    np.testing.assert_allclose(quanta, np.round(quanta), atol=1e-3)
    assert np.median(result.echo_pulse_width) > BEAMS.units.pulse_length[0]


def test_every_beam_has_an_echo_or_is_lost_or_misses():
    """Fails if a beam is counted twice, or if a miss gives a point."""
    result, truth = scan(*STREET, noise=NoiseConfig(ideal=True), obstacles=FENCE)
    exact, exact_truth = scan(*STREET, noise=EXACT, obstacles=FENCE)
    returned = set(beams_of(result, BEAMS)[truth.part != Part.NONE].tolist())
    lost = set(beams_lost(truth))
    met = set(beams_of(exact, BEAMS).tolist()) | set(beams_lost(exact_truth))
    assert not returned & lost
    assert returned | lost == met
    assert len(lost) > 100
    assert set(truth.lost_cause.tolist()) == {Loss.THRESHOLD, Loss.RANDOM}
    assert set(exact_truth.lost_cause.tolist()) == {Loss.THRESHOLD}


def beams_lost(truth):
    return (782 * truth.lost_unit.astype(int) + truth.lost_beam).tolist()


def test_level_units_see_no_ground_in_an_empty_world():
    """Flat ground, at a grazing angle and at least 20 m away, stays below the threshold; its beams are lost."""
    result, truth = scan()
    assert len(result) == 0
    assert set(BEAMS.layer[beams_lost(truth)].tolist()) == {0, 1}


def test_near_ground_is_seen():
    """A layer 6 degrees down hits it at 5.7 m; a footprint 0.784 degrees high begins in front of that."""
    model = small_unit((Fan((0,), 30.0, -30.0, 1.0, (100.0,)),), (-6.0,))
    result, truth = scan(rig=one_unit_rig(model, z=0.6))
    assert len(result) == 61
    assert np.all(truth.part == Part.GROUND)
    assert np.all(truth.actor_id == NO_ACTOR)
    # The centre of the lowest of nine rows of rays is 6.348 degrees down; it decides where P reaches the threshold.
    nearest, centre = (0.6 / math.sin(math.radians(angle)) for angle in (6.0 + 0.784 * 4 / 9, 6.0))
    assert np.all((truth.true_range >= nearest - 1e-4) & (truth.true_range < centre))


def test_actors_may_appear_disappear_and_change():
    """Fails if bodies of the last frame are reused for another actor."""
    lidar = Lidar(LUX_RIG, EXACT, FOOTPRINT, 1, NO_OBSTACLES)
    car, truck, dark = ahead(10.0), ahead(10.0, kind=Kind.TRUCK), ahead(10.0, paint=0.03)
    for actors in ((car,), (truck,), (car, ahead(10.0, y=4.0)), (), (truck,), (dark,), (car,), (ahead(10.0, id=8),)):
        assert_same(lidar.scan(world(*actors)), scan(*actors))


def test_actors_of_a_kind_differ_and_keep_their_proportions():
    """Proportions are drawn per actor from the seed and its id."""
    one, again, other = (scan(ahead(8.0, id=number), sensor=CENTRE_RAY) for number in (3, 3, 4))
    assert_same(one, again)
    assert not np.array_equal(one[1].true_range, other[1].true_range)


def test_odometry_is_relative_to_the_first_scan():
    lidar = Lidar(LUX_RIG, EXACT, FOOTPRINT, 1, NO_OBSTACLES)
    first, _ = lidar.scan(world(ego=ActorSpec(1000.0, -500.0, math.radians(170))))
    assert first.ego_pose_odom.tolist() == [0, 0, 0]
    # 2 m along and 1 m to the left of a heading of 170 degrees, rotated by 30 degrees, across the wrap at 180.
    c, s = math.cos(math.radians(170)), math.sin(math.radians(170))
    pose = ActorSpec(1000.0 + 2 * c - s, -500.0 + 2 * s + c, math.radians(-160))
    second, _ = lidar.scan(world(ego=pose, index=1))
    np.testing.assert_allclose(second.ego_pose_odom, [2.0, 1.0, math.radians(30)], atol=1e-9)


def test_mirror_faces_alternate():
    """Fails if beams of the other face fire or count as lost."""
    sides = (Fan((0,), 30.0, -30.0, 10.0, (100.0,), turn=0), Fan((1,), 30.0, -30.0, 10.0, (100.0,), turn=1))
    rig = one_unit_rig(small_unit(sides, (-1.0, 1.0), turns=2))
    facade = walls(((15, -40), (15, 40)))
    for index in range(4):
        result, truth = scan(rig=rig, obstacles=facade, index=index)
        assert result.layer.tolist() == [index % 2] * 7
        assert len(truth.lost_beam) == 0


def test_points_of_all_units_are_on_the_same_wall():
    """Fails if a unit's rays do not start at its nominal pose."""
    result, truth = scan(obstacles=walls(((-15, -15), (15, -15), (15, 15), (-15, 15))), noise=EXACT, sensor=CENTRE_RAY)
    assert set(result.unit.tolist()) == set(range(6))
    assert np.all(truth.cause == Cause.CLEAN)
    np.testing.assert_allclose(np.abs(result.points_ego[:, :2]).max(axis=1), 15.0, atol=1e-4)


def test_beams_with_hits_only_below_the_minimum_range_are_lost_as_too_near():
    """A car 0.2 m in front of the front left unit, whose minimum range is 0.3 m."""
    car = ActorSpec(EGO_FRONT - 0.25 + 0.2 + 2.35, 0.75)
    result, truth = scan(car)
    near = truth.lost_cause == Loss.TOO_NEAR
    assert near.sum() > 300
    assert set(truth.lost_unit[near].tolist()) <= {0, 1}
    beams = np.array(beams_lost(truth))[near]
    assert not set(beams.tolist()) & set(beams_of(result, BEAMS).tolist())


def test_scan_without_sweep_has_one_time_at_any_synchronisation_error():
    noise = replace(
        EXACT, calibration=CalibrationError(True, 0.0, 0.0, 0.0, xy_sigma_m=0.0, z_sigma_m=0.0, sync_sigma_ms=20.0)
    )
    car = ActorSpec(20.0, 0.0, velocity=(-30.0, 0.0))
    frozen = SensorConfig(sweep=False)
    exact, _ = scan(car, sensor=frozen)
    late, truth = scan(car, sensor=frozen, noise=noise)
    np.testing.assert_array_equal(late.points_ego, exact.points_ego)
    assert not np.any(truth.cause == Cause.DOUBLED)
    assert exact.sweep_limits is None


def test_times_of_a_sweep_are_within_its_limits():
    result, _ = scan(ActorSpec(20.0, 0.0))
    first, last = result.sweep_limits[result.unit, result.layer].T
    assert len(result) > 0
    assert ((first <= result.time_offset) & (result.time_offset <= last)).all()


def test_a_scan_states_the_nominal_positions_of_its_units():
    """Calibration errors move the true units by centimetres; the tracker knows the rig file only."""
    wrong = replace(EXACT, calibration=CalibrationError(True, 0.0, 0.0, 0.0, xy_sigma_m=0.2, z_sigma_m=0.0))
    nominal = [(LUX_RIG.rear_axle_x_m + mount.x_m, mount.y_m) for mount in LUX_RIG.mounts]
    for noise in (EXACT, wrong):
        result, _ = scan(ActorSpec(20.0, 0.0), noise=noise)
        np.testing.assert_allclose(result.unit_positions_ego, nominal)


def test_points_displaced_by_the_ego_rotation_are_doubled():
    """Units that fire 10 ms early or late, a yaw rate of 0.6 rad/s, a parked car 25 m away: displaced by 15 cm."""
    noise = replace(
        EXACT, calibration=CalibrationError(True, 0.0, 0.0, 0.0, xy_sigma_m=0.0, z_sigma_m=0.0, sync_sigma_ms=10.0)
    )
    _, truth = scan(ActorSpec(25.0, 0.0), noise=noise, ego=ActorSpec(0.0, 0.0, yaw_rate=0.6))
    assert np.any(truth.cause == Cause.DOUBLED)
