"""Bodies tilted by pitch and roll and raised by the road, and the tilt of the ego's units, by hand."""

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from support.sensor_scenes import (
    CENTRE_RAY,
    EXACT,
    LUX_RIG,
    PLAIN,
    STILL,
    ActorSpec,
    ahead,
    beams_of,
    one_unit_rig,
    placed_scene,
    scan,
    small_unit,
    world,
)
from support.solid_mesh import corners

from luxloop.sensor_model.bodies.rotation import tilt_rotations
from luxloop.sensor_model.lidar import Lidar
from luxloop.sensor_model.noise.attitude import Attitude, AttitudeNoise
from luxloop.sensor_model.noise.random_draws import Draws
from luxloop.sensor_model.raycaster import Raycaster
from luxloop.sensor_model.rig.beams import beam_table
from luxloop.sensor_model.rig.unit import Fan
from luxloop.sensor_model.truth import Part
from luxloop.sim.scripted.motions import Straight
from luxloop.sim.scripted.script import ScriptedEgo
from luxloop.sim.scripted.scripted_source import ScriptedSource, ScriptedTraffic
from luxloop.sim.world import Kind

FAN = (Fan((0, 1, 2), 9.0, -9.0, 0.5, (100.0,)),)
LEVEL = np.zeros(2)


def points_of(specs, elevation_deg, z, noise=PLAIN, **ego):
    """Return the exact points (N, 3) in the ego frame, truth and beams of a scan by one unit above the ego's origin."""
    rig = one_unit_rig(small_unit(FAN, elevation_deg), z=z)
    level, truth = scan(*specs, noise=noise, sensor=CENTRE_RAY, rig=rig, ego=replace(STILL, **ego))
    beams = beam_table(rig)
    beam = beams_of(level, beams)
    body = beams.units.origin_ego[0] + truth.true_range[:, None].astype(float) * beams.direction_ego[beam]
    R_ego_body = tilt_rotations(np.array([ego.get("attitude", LEVEL)]))[0]
    return body @ R_ego_body.T, truth, beams.layer[beam]


@given(pitch=st.floats(-0.1, 0.1), roll=st.floats(-0.7, 0.7))
def test_rotation_lowers_the_front_by_positive_pitch_and_the_right_by_positive_roll(pitch, roll):
    R = tilt_rotations(np.array([[pitch, roll]]))[0]
    assert pytest.approx(np.eye(3), abs=1e-12) == R @ R.T
    front, right = R @ [1.0, 0.0, 0.0], tilt_rotations(np.array([[0.0, roll]]))[0] @ [0.0, -1.0, 0.0]
    assert front[2] == pytest.approx(-math.sin(pitch))
    assert right[2] == pytest.approx(-math.sin(roll))


@pytest.mark.parametrize("pitch_deg", [-2.0, 1.2, 3.0])
def test_rear_of_a_pitched_box_is_the_analytic_plane(pitch_deg):
    pitch, length = math.radians(pitch_deg), 4.4
    car = ActorSpec(14.0, 0.3, size=(length, 1.8, 1.5), attitude=(pitch, 0.0))
    points, truth, _ = points_of([car], (-1.0, 0.5, 2.0), 0.7)
    rear = points[truth.actor_id == 0] - [car.x, car.y, 0.0]
    # The rear face has the normal (-1, 0, 0) and the offset L / 2 in the body's frame.
    assert len(rear) > 20
    assert rear @ [-math.cos(pitch), 0.0, math.sin(pitch)] == pytest.approx(length / 2, abs=2e-6 * 14.0)


@pytest.mark.parametrize(("pitch_deg", "roll_deg"), [(0.0, 0.0), (1.22, 0.0), (-0.8, 0.0), (1.0, 2.5)])
def test_ground_hits_of_a_pitching_ego_move_nearer(pitch_deg, roll_deg):
    """By hand: straight ahead, a beam of elevation e at height h meets the ground at h cos(p) / tan(p - e)."""
    height, elevations = 0.6, (-8.0, -6.0, -5.0)
    attitude = (math.radians(pitch_deg), math.radians(roll_deg))
    points, truth, layer = points_of([], elevations, height, attitude=attitude)
    assert np.all(truth.part == Part.GROUND)
    assert points[:, 2] == pytest.approx(0.0, abs=2e-6 * 20.0)
    if roll_deg:
        return
    ground = points[np.abs(points[:, 1]) < 1e-9]
    ahead_of_unit = ground[:, 0] - height * math.sin(attitude[0])
    expected = [height * math.cos(attitude[0]) / math.tan(attitude[0] - math.radians(e)) for e in elevations]
    assert ahead_of_unit == pytest.approx(expected, rel=1e-5)
    assert layer[np.abs(points[:, 1]) < 1e-9].tolist() == [0, 1, 2]


def test_ground_hits_of_layers_under_braking_of_4_mps2():
    """By hand, as in docs/sensor.md: the ego, a car, pitches by 0.815 degrees, and the unit 2.415 m ahead sinks.

    The height falls from 0.55 m to 0.55 cos p - 2.415 sin p = 0.5156 m; the layers at -1.2 and -0.4 degrees meet the
    road 0.516 / tan(p + 1.2 deg) = 14.65 m and 0.516 / tan(p + 0.4 deg) = 24.3 m ahead, instead of 26.3 m and 78.8 m.
    """
    ego = ScriptedEgo(motion=[Straight("straight", speed_mps=15.0, acceleration_mps2=-4.0)])
    narrow = small_unit(FAN, (-1.2, -0.4, 9.0), beam_height_deg=1e-4, reference_reflectivity=1e-9)
    rig, found = one_unit_rig(narrow, x=2.415, z=0.55), {}
    for suspension in (False, True):
        source = ScriptedSource(ScriptedTraffic(ego=ego, suspension=suspension), Path(), 100.0)
        lidar = Lidar(rig, PLAIN, CENTRE_RAY, 1, source.reset(1))
        points, truth = lidar.scan(source.step())
        middle = np.abs(points.points_ego[:, 1]) < 1e-6
        down = np.radians([1.2, 0.4]) + (math.radians(2.0 * 4.0 / 9.81) if suspension else 0.0)
        found[suspension] = truth.true_range[middle] * np.cos(down)
    assert found[False] == pytest.approx([26.26, 78.78], abs=0.01)
    assert found[True] == pytest.approx([14.65, 24.30], abs=0.01)


def test_points_stay_along_the_nominal_beams():
    """The pitch of 1.22 degrees under 4 m/s^2 lowers points 20 m ahead by 0.43 m; the scan does not show it."""
    car, pitch = ahead(20.0, size=(4.4, 1.8, 1.5)), math.radians(1.22)
    level, pitched = (scan(car, ego=replace(STILL, attitude=a)) for a in ((0.0, 0.0), (pitch, 0.0)))
    for points, truth in (level, pitched):
        beams = beam_table(LUX_RIG)
        beam = beams_of(points, beams)
        along = points.points_ego - beams.units.origin_ego[beams.unit[beam]]
        straight = np.linalg.norm(np.cross(along, beams.direction_ego[beam]), axis=1)
        assert straight.max() < 1e-4 * truth.true_range.max()
    assert len(level[0]) > 30
    assert len(pitched[0]) > 30


@given(
    pitch=st.floats(-0.15, 0.15),
    roll=st.floats(-0.7, 0.7),
    ground_z=st.floats(-0.4, 0.4),
    yaw=st.floats(-3, 3),
    yaw_rate=st.floats(-0.5, 0.5),
    articulation=st.just(0.0) | st.floats(-1.0, 1.0),
    kind=st.sampled_from(list(Kind)),
)
def test_points_in_the_frame_of_their_body_lie_on_its_planes(kind, pitch, roll, **spec):
    car = ActorSpec(12.0, 1.0, kind=kind, attitude=(pitch, roll), velocity=(3.0, 1.0), **spec)
    frame = world(car, ego=ActorSpec(0.0, 0.0, velocity=(9.0, 0.0), yaw_rate=0.1, ground_z=0.1))
    beams, bodies, walls, context = placed_scene(LUX_RIG, CENTRE_RAY, frame)
    echoes = Raycaster(beams, CENTRE_RAY).cast(bodies, walls, context)
    on_body = echoes.target == 0
    plane, point = bodies.planes_body[echoes.surface[on_body]], echoes.point_body[on_body]
    assert (plane[:, :3] * point).sum(axis=1) == pytest.approx(plane[:, 3], abs=1e-7)
    facing = (plane[:, :3] * echoes.direction_body[on_body]).sum(axis=1)
    assert np.all(facing < 0.0)


def test_level_body_beside_a_tilted_one_gives_the_same_bits():
    """The tilt of an unseen body makes all bodies take the way of tilted ones."""
    seen = ahead(12.0, y=0.5, id=1)
    hidden = ActorSpec(-150.0, 0.0, id=2)
    for noise in (EXACT, PLAIN):
        one, one_truth = scan(seen, hidden, noise=noise)
        other, other_truth = scan(seen, replace(hidden, attitude=(0.02, 0.01)), noise=noise)
        assert one.points_ego.tobytes() == other.points_ego.tobytes()
        for name in ("actor_id", "cause", "part", "true_range", "faces"):
            assert getattr(one_truth, name).tobytes() == getattr(other_truth, name).tobytes()


def test_level_bodies_are_not_copied():
    _, bodies, *_ = placed_scene(LUX_RIG, CENTRE_RAY, world(ahead(10.0)))
    assert bodies.planes is bodies.planes_body


def test_level_road_under_ego_and_actors_may_have_any_height():
    car = ahead(12.0)
    low, _ = scan(car)
    high, _ = scan(replace(car, ground_z=31.25), ego=replace(STILL, ground_z=31.25))
    assert low.points_ego.tobytes() == high.points_ego.tobytes()


def test_body_on_a_higher_road_is_raised():
    car = ActorSpec(14.0, 0.0, size=(4.4, 1.8, 1.5), ground_z=0.5)
    points, truth, _ = points_of([car], (-1.4, 0.1, 7.0), 0.7)
    on_car = points[truth.actor_id == 0]
    # The rear is at 11.8 m: the beams arrive at 0.41 m, 0.72 m and 2.15 m; the box is from 0.5 m to 2.0 m.
    assert on_car[:, 2].min() > 0.7
    assert on_car[:, 2].max() < 0.75


@pytest.mark.parametrize("noise", [PLAIN, EXACT])
def test_raised_side_of_a_tilted_body_still_stands_on_the_road(noise):
    """A nose-down pitch of 2 degrees raises the rear of a car by 8 cm; a beam 3 cm above the road meets box or tyre."""
    car = ActorSpec(12.0, 0.0, size=(4.4, 1.8, 1.5), attitude=(math.radians(2.0), 0.0))
    _, truth, _ = points_of([car], (0.0, 8.0, 9.0), 0.03, noise)
    tyres = {Part.BODY} if noise is PLAIN else {Part.WHEEL}
    assert set(truth.part[truth.actor_id == 0].tolist()) == tyres


@pytest.mark.parametrize("attitude", [(0.1, 0.0), (-0.1, 0.0), (0.0, 0.1), (0.0, -0.1)])
def test_all_corners_of_a_tilted_box_reach_the_road(attitude):
    specs = world(ActorSpec(12.0, 1.0, attitude=attitude))
    _, bodies, *_ = placed_scene(LUX_RIG, CENTRE_RAY, specs, plain=True, mirrors=False)
    height = np.sort(corners(bodies.planes[slice(*bodies.solid_plane[:2])])[:, 2])
    assert height[:4].max() <= 1e-9


def test_the_noise_of_the_attitude_is_relative_to_the_attitude_of_the_ego():
    """Rotations do not commute: in the other order the ground is up to 1.3 mm off."""
    noise = replace(PLAIN, attitude=AttitudeNoise(True, pitch_sigma_deg=2.0, roll_sigma_deg=2.0))
    rig, attitude = one_unit_rig(small_unit(FAN, (-14.0, -12.0, -11.0))), (0.1, 0.3)
    ego = replace(STILL, velocity=(10.0, 0.0), attitude=attitude)
    level, truth = scan(noise=noise, sensor=replace(CENTRE_RAY, sweep=False), rig=rig, ego=ego, seed=3)
    beams = beam_table(rig)
    along = truth.true_range[:, None].astype(float) * beams.direction_ego[beams_of(level, beams)]
    R_body = Attitude(noise.attitude, Draws(3, beams)).at(0.0, 10.0)
    ground = (beams.units.origin_ego[0] + along) @ (tilt_rotations(np.array([attitude]))[0] @ R_body).T
    assert len(ground) > 20
    assert ground[:, 2] == pytest.approx(0.0, abs=1e-4)


@pytest.mark.parametrize(
    ("kind", "attitude"), [(Kind.CAR, (0.02, 0.05)), (Kind.VAN, (-0.02, -0.06)), (Kind.MOTORCYCLE, (0.0, 0.2))]
)
def test_faces_are_those_of_the_body_not_of_its_tilt(kind, attitude):
    specs = [ActorSpec(12.0, 4.0, kind=kind, attitude=tilt) for tilt in ((0.0, 0.0), attitude)]
    level, tilted = (scan(spec)[1] for spec in specs)
    assert level.faces[0] == tilted.faces[0] != 0


@given(
    attitude=st.tuples(st.floats(-0.15, 0.15), st.floats(-0.7, 0.7)),
    ground_z=st.floats(-2, 2),
    articulation=st.just(0.0) | st.floats(-1.0, 1.0),
    kind=st.sampled_from([Kind.CAR, Kind.TRAILER_TRUCK, Kind.BICYCLE]),
)
def test_tilted_solids_have_the_tilted_corners(kind, **spec):
    """Each corner, rotated by the matrix, lies on the tilted planes that it lay on, and in the boxes."""
    _, bodies, *_ = placed_scene(LUX_RIG, CENTRE_RAY, world(ActorSpec(12.0, 1.0, kind=kind, **spec)))
    for p in range(bodies.body_solid[1]):
        planes = slice(*bodies.solid_plane[p : p + 2])
        body = corners(bodies.planes_body[planes])
        level = body @ bodies.R_level_body[0].T + [0.0, 0.0, bodies.ground_z[0]]
        inside, tilted = bodies.planes_body[planes], bodies.planes[planes]
        assert level @ tilted[:, :3].T - tilted[:, 3] == pytest.approx(body @ inside[:, :3].T - inside[:, 3], abs=1e-9)
        for low, high in (bodies.solid_bounds[p], bodies.bounds[0]):
            assert np.all(level >= low - 1e-9)
            assert np.all(level <= high + 1e-9)
