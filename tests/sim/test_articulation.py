"""Articulated trucks: geometry, bodies at an articulation angle, and sensor output."""

from dataclasses import replace

import numpy as np
import pytest
import shapely
from hypothesis import given
from hypothesis import strategies as st
from support.few import few
from support.optional import need
from support.sensor_scenes import EXACT, PLAIN, ActorSpec, one_unit_rig, placed_scene, scan, small_unit, world
from support.solid_mesh import body_mesh, corners, embree_ranges, pieces, placed

from luxloop.sensor_model.bodies.materials import Glass
from luxloop.sensor_model.bodies.scene import Bodies, BodyFactory
from luxloop.sensor_model.raycaster import Raycaster
from luxloop.sensor_model.returns import GROUND
from luxloop.sensor_model.rig.unit import Fan
from luxloop.sensor_model.sensor_config import SensorConfig
from luxloop.sensor_model.truth import Cause, Face, Part
from luxloop.sim.articulation import Hitch, hitch
from luxloop.sim.world import Kind

LENGTH, WIDTH, HEIGHT = 16.5, 2.55, 4.0
KINGPIN = LENGTH / 2 - 4.5
"""In the body frame, from the dimensions of a common combination [m]."""
angles = st.floats(-1.7, 1.7)
seeds = st.none() | st.integers(0, 2**32)


def lorry(articulation, x=0.0, y=0.0, yaw=0.0, **more):
    return ActorSpec(x, y, yaw, Kind.TRAILER_TRUCK, articulation=articulation, **more)


def place(*bodies, plain=False, seed=None):
    return BodyFactory(mirrors=True, plain=plain, glass=Glass(), seed=seed).place(world(*bodies))


def swung(points, angle, kingpin=KINGPIN):
    """Return points (N, 2 or more) rotated about a kingpin, by complex numbers."""
    plan = (points[:, 0] + 1j * points[:, 1] - kingpin) * np.exp(1j * angle) + kingpin
    return np.column_stack([plan.real, plan.imag, points[:, 2:]])


def plan(piece):
    return shapely.convex_hull(shapely.multipoints(corners(piece.planes)[:, :2]))


# ---- geometry


def test_the_common_combination_has_the_dimensions_of_the_directive():
    """96/53/EC, annex I: 16.50 m, 12.00 m from kingpin to rear, 2.04 m to the front's corners, and a swept ring from
    5.30 to 12.50 m, which a trailer's wheelbase of up to sqrt((12.5 - 2.04)^2 - (5.3 + W / 2)^2) fits."""
    ((trailer_front,), (kingpin,), (drive_axle,), (trailer_axles,)) = hitch(np.array([LENGTH]))
    assert LENGTH - kingpin == pytest.approx(12.0)
    assert LENGTH - trailer_front == pytest.approx(13.6)
    assert np.hypot(kingpin - trailer_front, WIDTH / 2) == pytest.approx(2.04, abs=0.01)
    assert trailer_axles - kingpin == pytest.approx(7.7)
    assert trailer_axles - kingpin < np.sqrt((12.5 - 2.04) ** 2 - (5.3 + WIDTH / 2) ** 2)
    assert 0.3 < drive_axle - kingpin < 0.9


def test_tractors_are_equal_and_short_vehicles_are_scaled():
    lengths = np.array([13.5, 16.5, 19.0, 6.75, 38.0])
    places = np.array(hitch(lengths))
    assert Hitch._fields[:3] == ("trailer_front", "kingpin", "drive_axle")
    np.testing.assert_allclose(places[:3, :3], np.repeat(places[:3, :1], 3, axis=1))
    np.testing.assert_allclose((lengths - places[3])[:3], 4.3)
    np.testing.assert_allclose(places[:, 3:], places[:, [0, 2]] * [0.5, 2.0])


@given(length=st.floats(6.0, 25.0), seed=seeds)
def test_wheels_are_at_the_axles_of_the_motion(length, seed):
    """Fails if the sensor's axles differ from those of the motion: wheels would slip sideways."""
    size = (length, WIDTH, HEIGHT)
    wheels = [p for p in pieces(place(lorry(0.0, size=size), seed=seed), 0) if p.part[0] == Part.WHEEL]
    behind = {flag: [] for flag in (True, False)}
    for wheel in wheels:
        behind[wheel.tractor].append(length / 2 - corners(wheel.planes)[:, 0].mean())
    scale = length / np.clip(length, 13.5, 19.0)
    _, kingpin, drive_axle, trailer_axles = (place[0] for place in hitch(np.array([length])))
    assert len(behind[True]) == 4
    assert len(behind[False]) == 6
    assert max(behind[True]) == pytest.approx(drive_axle, abs=0.11 * scale)
    assert max(behind[True]) - kingpin > 0.4 * scale
    assert np.mean(behind[False]) == pytest.approx(trailer_axles, abs=0.16 * scale)


# ---- bodies at an articulation angle


@pytest.mark.parametrize("plain", [False, True])
@given(angle=angles, seed=seeds, length=st.sampled_from([16.5, 8.0]))
def test_the_tractor_rotates_about_the_kingpin_and_the_trailer_stays(plain, angle, seed, length):
    """Compares corners by computational geometry: detects wrong signs, pivots and bounds."""
    size = (length, WIDTH, HEIGHT)
    straight = pieces(place(lorry(0.0, size=size), plain=plain, seed=seed), 0)
    bodies = place(lorry(angle, size=size), plain=plain, seed=seed)
    kingpin = length / 2 - 4.5 * min(length / 13.5, 1.0)
    for before, after in zip(straight, pieces(bodies, 0), strict=True):
        points = corners(after.planes)
        if before.tractor:
            tree = shapely.STRtree(shapely.points(swung(corners(before.planes), angle, kingpin)[:, :2]))
            _, distance = tree.query_nearest(shapely.points(points[:, :2]), return_distance=True, all_matches=False)
            assert distance.max() < 1e-6
        else:
            np.testing.assert_array_equal(before.planes, after.planes)
        np.testing.assert_array_equal(before.part, after.part)
        for around in (after.bounds, bodies.bounds[0]):
            assert np.all(points >= around[0] - 1e-7)
            assert np.all(points <= around[1] + 1e-7)


def test_the_tractor_is_its_cab_wheels_mirrors_and_frame():
    solids = pieces(place(lorry(0.0)), 0)
    tractor = [solid for solid in solids if solid.tractor]
    for part, count in {Part.WHEEL: 4, Part.MIRROR: 2, Part.INTERIOR: 2}.items():
        assert sum(solid.part[0] == part for solid in tractor) == count
    assert all(solid.tractor for solid in solids if Part.GREENHOUSE in solid.part or solid.inner)
    front = [corners(solid.planes)[:, 0].max() for solid in solids if not solid.tractor]
    assert max(front) == pytest.approx(LENGTH / 2 - 2.9, abs=0.16)


@given(angle=angles, seed=seeds)
def test_an_articulated_truck_is_connected_and_its_cab_clears_the_trailer(angle, seed):
    solids = pieces(place(lorry(angle), seed=seed), 0)
    upper = [solid for solid in solids if corners(solid.planes)[:, 2].max() > 2.0]
    cab = shapely.union_all([plan(solid) for solid in upper if solid.tractor and solid.part[0] != Part.MIRROR])
    trailer = shapely.union_all([plan(solid) for solid in upper if not solid.tractor])
    assert 0.05 < cab.distance(trailer) < 1.2
    frames = [solid for solid in solids if np.isclose(np.ptp(solid.bounds[:, 2]), 0.3) and solid.part[0] == Part.BODY]
    assert [frame.tractor for frame in frames] == [True, False]
    assert plan(frames[0]).intersection(plan(frames[1])).area > 0.5


def test_straight_bodies_are_unaffected_by_articulation():
    """Fails if another body's articulation, or an angle of zero, changes a bit."""
    bodies = [ActorSpec(0, 0), lorry(0.0, x=30.0), ActorSpec(9, 9, kind=Kind.BUS, articulation=0.4)]
    alone, beside = place(*bodies), place(*bodies, lorry(0.3, x=60.0))
    assert alone.planes is not beside.planes
    for name in ("bounds", "solid_bounds", "planes", "plane_turn"):
        one, two = getattr(alone, name), getattr(beside, name)
        np.testing.assert_array_equal(one, two[: len(one)], err_msg=name)
    assert not alone.plane_turn.any()
    shop = BodyFactory(mirrors=True, plain=False, glass=Glass(), seed=2)
    before, bent, again = (shop.place(world(lorry(angle))) for angle in (0.0, 0.5, 0.0))
    assert not np.array_equal(before.planes, bent.planes)
    for name in Bodies.__dataclass_fields__:
        np.testing.assert_array_equal(getattr(before, name), getattr(again, name), strict=True, err_msg=name)


# ---- ray casting


@pytest.mark.parametrize("angle", few([-1.2, -0.4, 0.1, 0.8, 1.5], -1.2, 0.8))
def test_embree_agrees_on_articulated_trucks(angle):
    """The meshes are straight trucks whose tractors trimesh rotates, independent of the caster."""
    need("dev", "trimesh", "embreex")
    import trimesh

    elevation_deg = tuple(np.linspace(-8.0, 6.0, 24).tolist())
    model = small_unit((Fan(tuple(range(24)), 180.0, -179.6, 0.4, (100.0,)),), elevation_deg, range_max_m=80.0)
    trucks = [lorry(angle, 14.0, 9.0, 0.3), lorry(-angle, -16.0, 12.0, 2.5), lorry(angle, 3.0, -14.0, 1.1)]
    sensor = SensorConfig(footprint=(1, 1), sweep=False, glass=Glass(transmission=0.0))
    rig = one_unit_rig(model, x=0.0137, y=0.0213, z=1.6137)
    beams, bodies, walls, setting = placed_scene(rig, sensor, world(*trucks))
    echoes = Raycaster(beams, sensor).cast(bodies, walls, replace(setting, threshold=np.full(len(beams), 1e-30)))
    found = np.full(len(beams), np.inf)
    found[echoes.beam] = echoes.range

    straight = pieces(place(lorry(0.0)), 0)
    meshes = [trimesh.creation.box(bounds=[[-400, -400, -1], [400, 400, 0]])]
    for truck in trucks:
        turn = trimesh.transformations.rotation_matrix(truck.articulation, [0, 0, 1], [KINGPIN, 0, 0])
        tractor = body_mesh([solid for solid in straight if solid.tractor and not solid.inner]).apply_transform(turn)
        trailer = body_mesh([solid for solid in straight if not solid.tractor])
        meshes += [placed(mesh, (truck.x, truck.y, truck.yaw)) for mesh in (tractor, trailer)]
    scene = trimesh.util.concatenate(meshes)
    traced = embree_ranges(beams.units.origin_ego[beams.unit], beams.direction_ego, scene)
    traced[traced > model.range_max_m] = np.inf
    assert (echoes.target >= 0).sum() > 3000
    assert (echoes.target == GROUND).any()
    # In single precision, a ray may pass by an edge that it meets in double precision.
    assert np.mean(~np.isclose(found, traced, rtol=0, atol=1e-3)) < 0.0005


# ---- truth


def test_faces_of_a_rotated_cab_are_labelled_in_the_cab_s_frame():
    """From behind, with the tractor turned to the left by a right angle, the cab's left side shows beside the trailer.

    Fails if faces are labelled by their direction in the trailer's frame: the cab's side would not be a face.
    """
    _, straight = scan(lorry(0.0, 20.0), noise=EXACT)
    _, bent = scan(lorry(np.pi / 2, 20.0), noise=EXACT)
    assert straight.faces.tolist() == [Face.REAR]
    assert bent.faces.tolist() == [Face.REAR | Face.LEFT]


@pytest.mark.parametrize("noise", [EXACT, PLAIN], ids=["body", "box"])
def test_points_on_the_side_of_a_rotated_cab_are_on_the_outline(noise):
    """Rotated to the right by 0.35 rad, the cab's left side is well inside the trailer's rectangle."""
    shares, in_rectangle = [], []
    for articulation in (0.0, -0.35):
        result, truth = scan(lorry(articulation, 0.0, -7.0), noise=noise)
        ahead = (truth.actor_id == 0) & (truth.part == Part.BODY) & (result.points_ego[:, 0] > LENGTH / 2 - 2.5)
        clean = truth.cause[ahead] == Cause.CLEAN
        shares.append(clean.mean())
        depth = -7.0 + WIDTH / 2 - result.points_ego[ahead, 1]
        in_rectangle.append((depth[clean] > 0.3).mean())
        assert ahead.sum() > 20
    assert shares[1] == pytest.approx(shares[0], abs=0.1)
    assert in_rectangle[0] < 0.1
    assert in_rectangle[1] > 0.9


def test_a_rotated_cab_occludes_what_is_behind_it():
    """The car beside the truck's front is visible until the tractor turns in front of it."""
    car = ActorSpec(25.0, 2.0, id=9)
    for articulation, visible in ((0.0, 1.0), (np.pi / 2, 0.0)):
        _, truth = scan(lorry(articulation, 14.0, -2.0, id=1), car, noise=EXACT)
        assert truth.visible_fraction[1] == pytest.approx(visible, abs=0.3)
