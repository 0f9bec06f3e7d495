"""Properties of the whole sensor that hold in every scene."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from support.sensor_scenes import (
    CENTRE_RAY,
    EXACT,
    FOOTPRINT,
    LUX_RIG,
    PLAIN,
    ActorSpec,
    ahead,
    beam_origins,
    one_unit_rig,
    only,
    scan,
    small_unit,
    wall,
    walls,
    world,
)

from luxloop.sensor_model.lidar import Lidar
from luxloop.sensor_model.noise.noise_config import KINDS, FixedOutage, NoiseConfig
from luxloop.sensor_model.rig.beams import beam_table
from luxloop.sensor_model.rig.rig import Rig
from luxloop.sensor_model.rig.unit import Fan
from luxloop.sensor_model.truth import NO_ACTOR, Cause, Part
from luxloop.sim.world import Kind

STREET = (
    ahead(8.0, velocity=(4.0, 0.5), acceleration=(-2.0, 0.0)),
    ahead(14.0, y=3.5, kind=Kind.SUV, velocity=(9.0, 0.0), yaw_rate=0.1),
    ActorSpec(-12, -3.5, kind=Kind.VAN, velocity=(12.0, 0.0)),
    ActorSpec(5, -8, 1.2, Kind.BUS),
)
FENCE_Y_M = 9.0
FENCE = wall((-40, FENCE_Y_M), (40, FENCE_Y_M), height=2.0)
OCCLUDER_REACH_M = 9.0
"""Half the diagonal of the longest body, and the length of an echo [m]."""
MOVING = ActorSpec(0.0, 0.0, velocity=(10.0, 0.3), acceleration=(1.0, 0.0), yaw_rate=0.05)
GRIDS = pytest.mark.parametrize("sensor", [CENTRE_RAY, FOOTPRINT], ids=["centre ray", "footprint"])


def rotated(vector, yaw):
    cos, sin = math.cos(yaw), math.sin(yaw)
    return np.array(vector) @ np.array([[cos, sin], [-sin, cos]])


def rotated_actor(spec, yaw, shift=(0.0, 0.0)):
    x, y = rotated([spec.x, spec.y], yaw) + shift
    return replace(
        spec,
        x=x,
        y=y,
        yaw=spec.yaw + yaw,
        velocity=tuple(rotated(spec.velocity, yaw)),
        acceleration=tuple(rotated(spec.acceleration, yaw)),
    )


def points_of(result):
    """Return a scan as a dictionary from beam and echo to the values of the point."""
    beam = zip(result.unit.tolist(), result.layer.tolist(), result.time_offset.tolist(), strict=True)
    rows = zip(result.points_ego.tolist(), result.echo_pulse_width.tolist(), result.flags.tolist(), strict=True)
    return {(*where, echo): row for where, echo, row in zip(beam, result.echo.tolist(), rows, strict=True)}


@given(yaw=st.floats(-3, 3), x=st.floats(-1e5, 1e5), y=st.floats(-1e5, 1e5))
def test_scans_do_not_depend_on_the_position_in_the_world(yaw, x, y):
    """Fails if poses or motions use single precision, or the wrong sign of the ego's yaw."""
    barrier = np.array([[-30.0, 12.0], [40.0, 14.0]])
    here, _ = scan(*STREET, obstacles=wall(*barrier), ego=MOVING)
    there, _ = scan(
        *(rotated_actor(spec, yaw, (x, y)) for spec in STREET),
        obstacles=wall(*(rotated(barrier, yaw) + np.array([x, y]))),
        ego=rotated_actor(MOVING, yaw, (x, y)),
    )
    np.testing.assert_allclose(there.points_ego, here.points_ego, atol=1e-4)
    assert np.array_equal(there.time_offset, here.time_offset)


@pytest.mark.parametrize("yaw", [0.5, -2.0])
def test_rig_rotated_with_the_world_gives_the_same_scan(yaw):
    """Fails if a unit's pose is composed in the wrong order, or if results depend on the ego's axes."""
    rotated_rig = Rig(
        0.0,
        tuple(
            replace(mount, x_m=x, y_m=y, yaw_deg=mount.yaw_deg + math.degrees(yaw))
            for mount in LUX_RIG.mounts
            for x, y in [rotated([mount.x_m + LUX_RIG.rear_axle_x_m, mount.y_m], yaw)]
        ),
    )
    barrier = np.array([[-30.0, 12.0], [40.0, 14.0]])
    here, here_truth = scan(*STREET, obstacles=wall(*barrier), ego=MOVING)
    ego = replace(rotated_actor(MOVING, yaw), yaw=0.0)
    actors = [rotated_actor(spec, yaw) for spec in STREET]
    there, there_truth = scan(*actors, obstacles=wall(*rotated(barrier, yaw)), ego=ego, rig=rotated_rig)
    np.testing.assert_allclose(there.points_ego[:, :2], rotated(here.points_ego[:, :2], yaw), atol=1e-4)
    np.testing.assert_allclose(there_truth.true_range, here_truth.true_range, atol=1e-4)
    assert np.array_equal(there_truth.unit_hits, here_truth.unit_hits)


occluders = st.builds(
    lambda bearing, distance, **rest: ActorSpec(distance * np.cos(bearing), distance * np.sin(bearing), **rest),
    bearing=st.floats(-3, 3),
    distance=st.floats(5, 25),
    yaw=st.floats(-3, 3),
    kind=st.sampled_from(list(Kind)),
)
SENSITIVE = (Fan((0, 1, 2, 3), 180.0, -177.5, 2.5, (100.0,)),)


@GRIDS
@given(occluder=occluders)
def test_occluder_only_shortens_ranges(sensor, occluder):
    """For a unit without lower limits of power and range. Fails if occluded objects return points.

    The echo of an occluder that touches the fence merges with that of the fence, between both.
    """
    assume(abs(occluder.y - FENCE_Y_M) > OCCLUDER_REACH_M)
    model = small_unit(SENSITIVE, (-4.0, -1.2, -0.4, 0.4), reference_range_m=1e6, range_min_m=0.0)
    rig = one_unit_rig(model, z=0.8)
    actors = (ActorSpec(20.0, 3.0, 0.4), ActorSpec(-15.0, 8.0, kind=Kind.TRUCK), ActorSpec(4.0, -22.0, kind=Kind.SUV))
    without, _ = scan(*actors, rig=rig, sensor=sensor, obstacles=FENCE)
    within, _ = scan(*actors, occluder, rig=rig, sensor=sensor, obstacles=FENCE)
    first = [
        {key[:3]: np.linalg.norm(point[0]) for key, point in points_of(one).items() if key[3] == 0}
        for one in (nearest_to_unit(without, rig), nearest_to_unit(within, rig))
    ]
    assert first[0].keys() <= first[1].keys()
    assert all(first[1][beam] <= reach + 1e-5 for beam, reach in first[0].items())


def nearest_to_unit(result, rig):
    return replace(result, points_ego=result.points_ego - beam_origins(result, beam_table(rig)))


@GRIDS
def test_visible_fraction_never_rises_as_an_occluder_moves_in(sensor):
    """Fails if hits on the occluder count for the actor, or if hits alone depend on the occluder."""
    fractions, alone = [], set()
    for edge in np.arange(-3.0, 3.01, 0.15):
        _, truth = scan(ActorSpec(20, 0), obstacles=wall((12, -9), (12, edge)), sensor=sensor)
        fractions.append(truth.visible_fraction[0])
        alone.add(tuple(truth.unit_hits_alone[0].tolist()))
    assert len(alone) == 1
    assert (fractions[0], fractions[-1]) == (1.0, 0.0)
    assert np.all(np.diff(fractions) <= 0.0)
    assert np.any((np.array(fractions) > 0.3) & (np.array(fractions) < 0.7))


@GRIDS
@pytest.mark.parametrize(
    ("actors", "obstacles"),
    [
        ([ActorSpec(20, 0)], wall((15, -15), (15, 15))),
        (
            [ActorSpec(0, 7), ActorSpec(0, 3.6, kind=Kind.BUS, size=(14.0, 2.5, 3.0))],
            walls(((-7, 4.85), (7, 4.85)), height=1.5),
        ),
    ],
    ids=["behind a wall", "behind a bus and its apron"],
)
def test_hidden_car_has_no_points(sensor, actors, obstacles):
    """scenario_simulator_v2#1227: hidden objects appeared in the output."""
    for noise in (EXACT, PLAIN, NoiseConfig()):
        _, truth = scan(*actors, obstacles=obstacles, noise=noise, sensor=sensor)
        assert not np.any(truth.actor_id == 0)
        assert truth.hits[0] == 0
        assert truth.hits_alone[0] > 50
        assert truth.visible_fraction[0] == 0.0


@GRIDS
@given(bearing=st.floats(-3, 3), distance=st.floats(7, 60), yaw=st.floats(-3, 3), kind=st.sampled_from(list(Kind)))
def test_lone_actor_is_fully_visible(sensor, bearing, distance, yaw, kind):
    _, truth = scan(ActorSpec(distance * np.cos(bearing), distance * np.sin(bearing), yaw, kind), sensor=sensor)
    assert np.array_equal(truth.unit_hits, truth.unit_hits_alone)
    assert truth.visible_fraction[0] == (1.0 if truth.hits[0] else 0.0)


@pytest.mark.parametrize("noise", [EXACT, NoiseConfig()], ids=["exact", "noisy"])
def test_hidden_actor_changes_no_point(noise):
    """Fails if draws come from a sequence instead of counters."""
    hidden = ActorSpec(25.0, 14.0, id=40)  # behind the fence, which is higher
    fence = wall((-40, 9), (90, 9), height=3.0)
    alone, alone_truth = scan(*STREET, noise=noise, obstacles=fence, ego=MOVING)
    joined, joined_truth = scan(*STREET, hidden, noise=noise, obstacles=fence, ego=MOVING)
    assert joined_truth.unit_hits[-1].sum() == 0
    assert joined_truth.unit_hits_alone[-1].sum() > 50
    assert points_of(joined) == points_of(alone)
    assert np.array_equal(joined_truth.cause, alone_truth.cause)


def test_added_unit_changes_no_point_of_the_others():
    extra = replace(LUX_RIG.mounts[0], name="extra", x_m=0.5, y_m=0.0, z_m=2.1)
    rig = replace(LUX_RIG, mounts=(*LUX_RIG.mounts, extra))
    as_shipped = points_of(scan(*STREET, noise=NoiseConfig(), obstacles=FENCE, ego=MOVING)[0])
    extended = points_of(scan(*STREET, noise=NoiseConfig(), obstacles=FENCE, ego=MOVING, rig=rig)[0])
    assert {key: row for key, row in extended.items() if key[0] < len(LUX_RIG.mounts)} == as_shipped
    assert len(extended) > len(as_shipped)


def noise_with(*kinds):
    """Return these kinds of noise, at strengths that have an effect in one scan."""
    config = only(*kinds)
    return replace(
        config,
        outliers=replace(config.outliers, rate=0.05),
        false_alarms=replace(config.false_alarms, rate=0.01),
        rain=replace(config.rain, rate_mm_per_h=30.0),
        ghost=replace(config.ghost, glass_quality=1.0, paint_quality=1.0),
        outage=replace(config.outage, fixed=(FixedOutage("side left", -1.0, 1.0),)),
    )


BUSY = (
    *STREET,
    ahead(19.0, y=-3.5, velocity=(25.0, 0.0)),
    ahead(28.0, y=1.0, velocity=(30.0, 0.0)),
    ActorSpec(8.0, 4.0, 0.05, Kind.BUS, velocity=(22.0, 0.0)),
)
FACADE = walls(((-40, 9), (40, 9)), ((40, 40), (40, -40)), height=6.0, reflectivity=0.9)


OTHERS = ("range", "dropout", "mirror", "layer_overlap", "false_alarms")
GEOMETRY = {"calibration", "attitude"}
POSE = {"odometry"}


def test_odometry_errors_move_no_point():
    before, after = (
        by_surface_point(*scan(*BUSY, noise=noise_with(*kinds), obstacles=FACADE, ego=MOVING))
        for kinds in (OTHERS, {*OTHERS, *POSE})
    )
    assert before == after


@pytest.mark.parametrize("kind", [kind for kind in KINDS if kind not in GEOMETRY | POSE])
def test_each_kind_of_noise_has_independent_draws(kind):
    """A kind removes, moves or adds only its own points; the others stay equal, bit by bit."""
    before, after = (
        by_surface_point(*scan(*BUSY, noise=noise_with(*kinds), obstacles=FACADE, ego=MOVING))
        for kinds in (set(OTHERS) - {kind}, {*OTHERS, kind})
    )
    common = before.keys() & after.keys()
    assert before != after
    assert len(common) > 0.75 * min(len(before), len(after))
    if kind == "range":
        assert all(before[key] != after[key] for key in common if key[-1] == Cause.CLEAN)
    else:
        assert all(before[key] == after[key] for key in common)


def by_surface_point(result, truth):
    """Return the position of each point, keyed by beam, true range and cause."""
    rows = zip(result.unit, result.layer, result.time_offset, truth.true_range, truth.cause, strict=True)
    return {tuple(map(float, row)): tuple(place) for row, place in zip(rows, result.points_ego.tolist(), strict=True)}


@pytest.mark.parametrize("kind", sorted(GEOMETRY))
def test_geometry_errors_do_not_change_false_alarms(kind):
    """Errors of mounts or attitude move all hits on surfaces; false alarms stay."""
    without, within = (scan(*STREET, noise=noise_with(*OTHERS, *kinds), obstacles=FACADE) for kinds in ((), (kind,)))
    before, after = (
        {key: place for key, place in by_surface_point(*one).items() if key[-1] == Cause.FALSE_ALARM}
        for one in (without, within)
    )
    common = before.keys() & after.keys()
    assert len(common) > 0.8 * len(before) > 10
    assert all(before[key] == after[key] for key in common)


def test_same_seed_gives_same_scans_in_any_order_and_from_a_new_lidar():
    frames = [world(*STREET, ego=MOVING, index=index) for index in range(4)]
    lidar = Lidar(LUX_RIG, NoiseConfig(), FOOTPRINT, 9, FENCE)
    scans = [points_of(lidar.scan(frame)[0]) for frame in frames]
    for index in (2, 0, 3):
        fresh = Lidar(LUX_RIG, NoiseConfig(), FOOTPRINT, 9, FENCE)
        assert points_of(fresh.scan(frames[index])[0]) == scans[index]
    other_seed = Lidar(LUX_RIG, NoiseConfig(), FOOTPRINT, 10, FENCE).scan(frames[0])[0]
    assert points_of(other_seed) != scans[0]
    still = [points_of(scan(index=index, noise=NoiseConfig(), obstacles=FENCE)[0]) for index in (0, 1)]
    assert still[0] != still[1]


def outline_distance(places, spec, tau):
    """Return the (N,) distance of points in plan from the outline of an actor at the times of the points."""
    tau = np.asarray(tau)[:, None]
    moved = np.multiply(spec.velocity, tau) + np.multiply(spec.acceleration, tau**2 / 2)
    yaw = spec.yaw + spec.yaw_rate * tau[:, 0]
    x, y = (places - [spec.x, spec.y] - moved).T
    local = np.abs([np.cos(yaw) * x + np.sin(yaw) * y, np.cos(yaw) * y - np.sin(yaw) * x])
    return np.abs(np.max(local - np.array(spec.lwh[:2])[:, None] / 2, axis=0))


CROSSING = ActorSpec(15.0, -4.0, 1.4, velocity=(0.0, 30.0), acceleration=(2.0, -5.0), yaw_rate=0.8)


def test_each_point_is_on_its_car_at_its_firing_time():
    """LGSVL#649: truth and points had different times. A car that crosses at 30 m/s moves 0.7 m in a scan."""
    result, truth = scan(CROSSING, noise=PLAIN, sensor=CENTRE_RAY)
    on_car = truth.actor_id == 0
    places, tau = result.points_ego[on_car, :2].astype(float), result.time_offset[on_car]
    assert on_car.sum() > 50
    assert np.ptp(tau) > 0.003
    assert outline_distance(places, CROSSING, tau).max() < 1e-4
    assert outline_distance(places, CROSSING, 0.0 * tau).max() > 0.1


def test_scan_without_sweep_is_instantaneous():
    result, truth = scan(CROSSING, noise=PLAIN, sensor=replace(CENTRE_RAY, sweep=False), ego=MOVING)
    on_car = truth.actor_id == 0
    assert not result.time_offset.any()
    assert outline_distance(result.points_ego[on_car, :2].astype(float), CROSSING, np.zeros(on_car.sum())).max() < 1e-4


def test_ego_motion_skews_static_objects():
    """A wall 30 m ahead of a turning ego at 30 m/s: a point in the ego frame of its firing time, with the pose of that
    frame, lies on the wall."""
    ego = ActorSpec(0.0, 0.0, velocity=(30.0, 0.0), acceleration=(-4.0, 0.0), yaw_rate=0.4)
    result, truth = scan(obstacles=wall((30, -60), (30, 60)), ego=ego, sensor=CENTRE_RAY)
    tau = result.time_offset.astype(float)
    yaw = ego.yaw_rate * tau
    x, y, _ = result.points_ego.astype(float).T
    on_wall = truth.part == Part.OBSTACLE
    ahead_of_start = ego.velocity[0] * tau + ego.acceleration[0] * tau**2 / 2 + np.cos(yaw) * x - np.sin(yaw) * y
    assert on_wall.sum() > 500
    np.testing.assert_allclose(ahead_of_start[on_wall], 30.0, atol=1e-4)
    assert np.ptp(x[on_wall]) > 0.5


def test_time_offsets_are_those_of_the_beams():
    """At 4500 degrees/s from 11.1 ms before the frame's time, 50 degrees to the left, to 13.3 ms after it."""
    room = walls(((-10, -10), (10, -10), (10, 10), (-10, 10)))
    result, _ = scan(obstacles=room)
    assert result.time_offset.min() == pytest.approx(-50.0 / 4500.0, abs=1e-6)
    assert result.time_offset.max() == pytest.approx(59.75 / 4500.0, abs=1e-6)


def test_beams_without_a_hit_give_no_point():
    """Another simulator made points of range noise on misses (drcsim#288). Only false alarms and droplets give points
    without a surface."""
    with_air = {"false_alarms", "rain", "spray", "snow", "fog"}
    empty, truth = scan(noise=noise_with(*(set(KINDS) - with_air - GEOMETRY)))
    layer = beam_table(LUX_RIG).layer
    assert len(empty) == 0
    assert set(layer[782 * truth.lost_unit.astype(int) + truth.lost_beam].tolist()) <= {0, 1}  # on the ground, too weak
    _, with_alarms = scan(noise=noise_with(*OTHERS))
    assert set(with_alarms.cause) == {Cause.FALSE_ALARM}
    assert set(with_alarms.actor_id) == {NO_ACTOR}


def test_noise_statistics_hold_over_long_runs():
    """webots#2139: noise became a fixed pattern after minutes; #4786: it was wrong after a reset. Range errors on the
    walls of a room in 20 frames: at the start, after 10^5 frames, and again from a new sensor."""
    rig = one_unit_rig(small_unit((Fan((0,), 50.0, -50.0, 0.5, (100.0,)),), (0.0,), range_quantum_m=1e-6))
    room = walls(((-20, -20), (20, -20), (20, 20), (-20, 20)), reflectivity=0.8)
    errors = []
    for start in (0, 100_000, 0):
        lidar = Lidar(rig, only("range", "dropout"), CENTRE_RAY, 5, room)
        scans = [lidar.scan(world(index=start + frame)) for frame in range(20)]
        counts = [len(result) for result, _ in scans]
        assert 0.97 < np.mean(counts) / 201 < 1.0  # 1 % are lost at random
        errors.append(np.concatenate([range_error(*one, rig) for one in scans]))
    # Four standard deviations of the mean and of the standard deviation of 4000 normal draws.
    for error in errors[:2]:
        assert abs(error.mean()) < 4 * 0.025 / 4000**0.5
        assert error.std() == pytest.approx(0.025, abs=4 * 0.025 / 8000**0.5)
    assert np.array_equal(errors[0], errors[2])
    shared = min(map(len, errors))
    assert abs(np.corrcoef(errors[0][:shared], errors[1][:shared])[0, 1]) < 4 / shared**0.5


def range_error(result, truth, rig):
    origin = beam_origins(result, beam_table(rig))
    return np.linalg.norm(result.points_ego - origin, axis=1) - truth.true_range
