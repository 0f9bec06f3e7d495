"""Spray: positions of clusters, and beams that hit them."""

from dataclasses import replace
from itertools import combinations
from pathlib import Path

import numpy as np
import pytest
import scipy
from hypothesis import given
from hypothesis import strategies as st
from support.independence import dependence
from support.naive_noise import cluster_echo
from support.noise_scenes import BEAMS, HARD, context, healthy, thresholds, within

from luxloop.sensor_model.bodies.materials import Glass
from luxloop.sensor_model.bodies.scene import BodyFactory
from luxloop.sensor_model.noise.noise_config import FixedOutage, NoiseConfig, Outage, Spray
from luxloop.sensor_model.noise.random_draws import Draws, Purpose
from luxloop.sensor_model.noise.spray import CYCLE_S, Clusters, clusters, spray_echoes
from luxloop.sensor_model.rig.beams import beam_table
from luxloop.sensor_model.rig.rig import load_rig
from luxloop.sensor_model.truth import Cause, Part
from luxloop.sim.world import Actors, Ego, Kind, WorldFrame
from luxloop.tracker.scan import PointFlag

ON = Spray(True, reach_m=200.0)
KM_PER_H = 1 / 3.6
LENGTH = 4.7


def bodies(*cars):
    """Return bodies of cars (id, x, y, yaw, speed along yaw [km/h]) around an ego at rest at the origin."""
    id_, x, y, yaw, speed = np.array(cars, dtype=np.float64).T
    count = len(cars)
    actors = Actors(
        id=id_.astype(np.int64),
        name=np.array([f"car {number:.0f}" for number in id_]),
        kind=np.full(count, Kind.CAR, np.uint8),
        pose_world=np.column_stack([x, y, yaw]),
        velocity_world=speed[:, None] * KM_PER_H * np.column_stack([np.cos(yaw), np.sin(yaw)]),
        acceleration_world=np.zeros((count, 2)),
        yaw_rate=np.zeros(count),
        articulation=np.zeros(count),
        mode=np.zeros(count, np.uint8),
        changes_lane=np.zeros(count, np.bool_),
        deviation=np.zeros((count, 2)),
        ground_z=np.zeros(count),
        attitude=np.zeros((count, 2)),
        size=np.tile([LENGTH, 1.8, 1.45], (count, 1)),
        reflectivity=np.full(count, 0.4),
    )
    ego = Ego(
        np.zeros(3), np.zeros(2), np.zeros(2), 0.0, np.array([4.83, 1.91, 1.67]), False, np.zeros(2), 0.0, np.zeros(2)
    )
    placed = BodyFactory(mirrors=True, plain=False, glass=Glass(), seed=None).place(WorldFrame(0, 0.0, ego, actors))
    return placed, actors.name


def wakes(*cars, config=ON, time=10.0, seed=1):
    return clusters(config, *bodies(*cars), Draws(seed, BEAMS), time)


def test_slow_vehicles_make_no_spray():
    assert len(wakes((1, 10, 0, 0, 49.9)).radius) == 0
    assert len(wakes((1, 10, 0, 0, 80.0)).radius) > 0


@pytest.mark.parametrize(("speed", "film", "births", "lasting"), [(100, 0.5, 10.0, 0.7), (130, 1.0, 24.0, 1.8)])
def test_number_of_clusters_is_that_of_linnhoff(speed, film, births, lasting):
    """(0.2 h + 0.1) (v - 50) per 0.1 s of their life of three time constants 0.02 h (v - 50) + 0.2 s."""
    wet = replace(ON, water_film_mm=film)
    counts = [len(wakes((id_, 0, 0, 0, speed), config=wet, time=10.05).radius) for id_ in range(20)]
    assert np.mean(counts) == pytest.approx(births * 3 * lasting / CYCLE_S, rel=0.03)


def test_clusters_are_in_the_wake():
    """Behind the car, within the plume's width and height, and no farther back than it was when they were born."""
    yaw = 0.7
    cloud = wakes(*((id_, 5.0, 2.0, yaw, 108.0) for id_ in range(30)))
    to = cloud.centre_ego - [5.0, 2.0, 0.0]
    ahead, left = to[:, 0] * np.cos(yaw) + to[:, 1] * np.sin(yaw), to[:, 1] * np.cos(yaw) - to[:, 0] * np.sin(yaw)
    lasting = 0.02 * 0.5 * 58 + 0.2
    assert ahead.max() < -LENGTH / 2 + 0.2
    assert ahead.min() > -LENGTH / 2 - 30 * (3 * lasting + CYCLE_S)
    assert np.abs(left).max() <= 1.7
    assert scipy.stats.kstest(left, scipy.stats.uniform(-1.7, 3.4).cdf).pvalue > 1e-3
    assert scipy.stats.kstest(cloud.centre_ego[:, 2], scipy.stats.uniform(0.0, 1.5).cdf).pvalue > 1e-3
    assert (
        scipy.stats.kstest(
            np.log(cloud.radius[cloud.radius < 1]), scipy.stats.truncnorm(-50, 1.5, -1.2, 0.8).cdf
        ).pvalue
        > 1e-3
    )
    assert cloud.share.max() <= 0.17
    assert cloud.share.min() >= 0.17 * np.exp(-3.0) - 1e-12


def test_clusters_are_born_where_an_accelerating_vehicle_was():
    """Its place at the age t before, from that of an unaccelerated one: + a t^2 / 2, along and across its heading."""
    placed, name = bodies((1, 5.0, 2.0, 0.3, 108.0))
    acceleration = np.array([-4.0, 3.0])
    steady, accelerated = (
        clusters(ON, replace(placed, acceleration_ego=rate[None]), name, Draws(1, BEAMS), 10.0)
        for rate in (np.zeros(2), acceleration)
    )
    age = -0.78 * np.log(steady.share / 0.17)
    assert np.ptp(age) > 1.0
    moved = accelerated.centre_ego - steady.centre_ego
    np.testing.assert_allclose(moved[:, :2], age[:, None] ** 2 / 2 * acceleration, atol=1e-6)
    assert np.array_equal(accelerated.tag, steady.tag)


def test_place_and_radius_of_clusters_are_independent():
    """By their joint histogram: a normal and a uniform number of one draw are uncorrelated, but dependent."""
    cloud = wakes(*((id_, 5.0, 2.0, 0.0, 108.0) for id_ in range(12)))
    whole = cloud.radius < 1.0
    columns = [*cloud.centre_ego[whole].T, cloud.radius[whole]]
    assert min(dependence(one, other) for one, other in combinations(columns, 2)) > 1e-3


def test_clusters_persist_between_frames_and_are_decelerated_by_drag():
    """The same clusters a moment later, moved by the solution of dv/dt = -0.12 v^2 between their two ages.

    Fails if a cluster is redrawn in each frame, or moves with the car.
    """
    speed = 30.0
    before = wakes((1, 0.0, 0.0, 0.0, speed * 3.6), time=10.0)
    after = wakes((1, speed * 0.08, 0.0, 0.0, speed * 3.6), time=10.08)
    tags, i, j = np.intersect1d(before.tag, after.tag, return_indices=True)
    assert len(tags) > 0.9 * len(before.tag)
    moved = after.centre_ego[j] - before.centre_ego[i]
    np.testing.assert_allclose(moved[:, 1:], 0.0, atol=1e-9)
    # Its age from its share: share = 0.17 exp(-age / 0.78 s).
    age = -0.78 * np.log(before.share[i] / 0.17)
    way = np.log1p(0.12 * speed * (age + 0.08)) / 0.12 - np.log1p(0.12 * speed * age) / 0.12
    np.testing.assert_allclose(moved[:, 0], way, atol=1e-6)
    assert np.array_equal(before.radius[i], after.radius[j])


def test_added_vehicle_changes_no_cluster_of_the_first():
    alone, both = wakes((4, 0, 0, 0, 100)), wakes((2, 30, 4, 0, 120), (4, 0, 0, 0, 100))
    assert set(alone.tag) < set(both.tag)
    assert np.array_equal(alone.centre_ego, both.centre_ego[np.isin(both.tag, alone.tag)])


def test_clusters_out_of_reach_are_dropped():
    cloud = wakes((1, 60, 0, 0, 100), config=replace(ON, reach_m=40.0))
    assert 0 < len(cloud.radius) < len(wakes((1, 60, 0, 0, 100)).radius)
    assert np.hypot(*cloud.centre_ego[:, :2].T).max() < 40.0


def on_ego(centre, radius, origin):
    """Return True if a sphere touches the box around all units in plan."""
    return all(origin[:, axis].min() - radius <= centre[axis] <= origin[:, axis].max() + radius for axis in range(2))


LATE = replace(BEAMS, time_offset=BEAMS.time_offset + 0.08)


@pytest.mark.parametrize("beams", [BEAMS, LATE, beam_table(load_rig("roof_spinning_16", Path()))])
@given(seed=st.integers(0, 2**32 - 1))
def test_echoes_equal_reference_implementation(beams, seed):
    """Units at random poses, a fast ego, clusters on all sides, some on the ego; a sweep of a full turn.

    Also units that fire 80 ms late, when the ego has moved up to 4.5 m. All beams that hit a cluster are compared.
    """
    rng = np.random.default_rng(seed)
    cloud = Clusters(
        centre_ego=rng.uniform([-8, -8, -1], [8, 8, 2], (12, 3)),
        radius=rng.uniform(0.05, 1.5, 12),
        share=rng.uniform(0.3, 1.0, 12),
        tag=rng.integers(0, 2**32, 12),
    )
    units = len(beams.units)
    moved = context(
        beams,
        frame_index=7,
        origin_ego=beams.units.origin_ego + rng.normal(0, 0.3, (units, 3)),
        R_ego_unit=beams.units.R_ego_unit @ scipy.spatial.transform.Rotation.random(units, rng=rng).as_matrix(),
        ego_velocity=rng.uniform(-40, 40, 2),
    )
    draws, need = Draws(5, beams), thresholds(beams=beams, names=["unit"] * units)
    result = spray_echoes(ON, cloud, moved, beams.time_offset, beams, need, draws)
    found = np.full(len(beams), np.inf)
    found[result.beam] = result.range
    some = np.concatenate([rng.choice(len(beams), 40), rng.permutation(result.beam)[:40]])
    spheres = [
        sphere
        for sphere in zip(cloud.centre_ego, cloud.radius, cloud.share, cloud.tag.tolist(), strict=True)
        if not on_ego(sphere[0], sphere[1], moved.origin_ego)
    ]
    expected = [
        cluster_echo(
            [5, 0], 7, Purpose.SPRAY_ECHO, spheres, beam, beams, moved.origin_ego, moved.R_ego_unit, moved.ego_velocity
        )
        for beam in some
    ]
    np.testing.assert_allclose(found[some], expected, atol=1e-6)


def echoes(cloud, config=ON, frame=0, need=None):
    need = need or healthy()
    return spray_echoes(config, cloud, context(frame_index=frame), BEAMS.time_offset, BEAMS, need, Draws(1, BEAMS))


def test_echoes_are_on_the_chords_and_have_the_share_of_the_cluster():
    """A cluster ahead, 3 m wide: each beam's echo is uniform over its chord."""
    cloud = Clusters(np.array([[15.0, 0.0, 0.6]]), np.array([1.5]), np.array([0.4]), np.array([77]))
    through = echoes(replace(cloud, share=np.array([1.0])))
    some = [echoes(cloud, frame=frame) for frame in range(50)]
    assert within(sum(map(len, some)), 50 * len(through), 0.4)
    beam, range_ = (np.concatenate([getattr(each, name) for each in some]) for name in ("beam", "range"))
    to = cloud.centre_ego[0] - BEAMS.units.origin_ego[BEAMS.unit[beam]]
    middle = np.einsum("ni,ni->n", to, BEAMS.direction_ego[beam])
    half = np.sqrt(1.5**2 - (to**2).sum(axis=1) + middle**2)
    assert scipy.stats.kstest((range_ - middle) / half, scipy.stats.uniform(-1.0, 2.0).cdf).pvalue > 1e-3
    assert np.all(np.isin(BEAMS.unit[beam], [0, 1]))


def test_spray_echoes_are_droplets_half_of_them_labelled():
    some = [echoes(wakes((1, 12, 0, 0, 110)), frame=frame) for frame in range(10)]
    flags = np.concatenate([each.flags for each in some])
    assert len(flags) > 500
    assert within(np.sum(flags == PointFlag.CLUTTER), len(flags), 0.5)
    assert all(np.all(each.part == Part.DROPLET) and np.all(each.cause == Cause.SPRAY) for each in some)


def test_silent_unit_sees_no_spray():
    out = thresholds(NoiseConfig(dropout=HARD, outage=Outage(True, fixed=(FixedOutage("front left", 0.0, 9.0),))))
    cloud = wakes((1, 12, 0, 0, 110))
    assert 0 in BEAMS.unit[echoes(cloud).beam]
    assert 0 not in BEAMS.unit[echoes(cloud, need=out).beam]


def test_clusters_on_the_ego_are_dropped():
    """Fails if a unit is inside a cluster that hides the scene."""
    for place in ([0.0, 0.0, 0.6], [2.5, 0.75, 0.55]):
        cloud = Clusters(np.array([place]), np.array([0.8]), np.array([1.0]), np.array([77]))
        assert len(echoes(cloud)) == 0
        assert len(echoes(replace(cloud, centre_ego=cloud.centre_ego + np.array([4.0, 0.0, 0.0])))) > 0
