"""The caster against its naive twin and against an independent ray tracer; bodies against their boxes."""

import math

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st
from support.naive_caster import ray_ranges
from support.sensor_scenes import NO_OBSTACLES, PLAIN, Thing, ahead, one_unit_rig, scan, small_unit, wall, world
from support.solid_mesh import body_mesh, corners, placed

from sensor_model.beams import beam_table
from sensor_model.bodies import BodyShop, body_solids
from sensor_model.cast import Caster
from sensor_model.kernels import GROUND, WALL
from sensor_model.shapes import SHAPES
from sensor_model.truth import Part
from sensor_model.unit import Fan
from sensor_model.walls import walls_of
from sim.world import Kind, Obstacles

FULL_TURN = Fan((0, 1, 2), 180.0, -172.0, 8.0, (100.0,))
TWO_FANS = (Fan((0, 2), 100.0, -20.0, 7.5, (100.0,)), Fan((1,), 20.0, -140.0, 10.0, (100.0,)))

things = st.builds(
    Thing,
    x=st.floats(-30, 30),
    y=st.floats(-30, 30),
    yaw=st.floats(-4, 4),
    kind=st.sampled_from(list(Kind)),
    size=st.none() | st.tuples(st.floats(0.3, 12), st.floats(0.3, 3), st.floats(0.5, 4)),
)
rigs = st.builds(
    one_unit_rig,
    model=st.sampled_from([small_unit(), small_unit((FULL_TURN,)), small_unit(TWO_FANS, range_min=4.0)]),
    # Odd offsets, or half of the scenes have a unit exactly in the plane of a wall, where rounding decides.
    x=st.floats(-3, 3).map(lambda x: x + 0.137),
    y=st.floats(-2, 2).map(lambda y: y + 0.071),
    z=st.floats(0.2, 2).map(lambda z: z + 0.0113),
    yaw_deg=st.floats(-180, 180).map(lambda yaw: yaw + 0.77),
    pitch_deg=st.floats(-20, 20),
    roll_deg=st.floats(-20, 20),
)
points = st.tuples(st.floats(-40, 40), st.floats(-40, 40))
obstacles = st.lists(st.tuples(st.lists(points, min_size=2, max_size=4), st.floats(0.1, 6)), max_size=2).map(
    lambda pairs: Obstacles.from_polygons([np.array(corners) for corners, _ in pairs], [height for _, height in pairs])
)


def cast(rig, frame, obstacles, mirrors=True, plain=False):
    beams = beam_table(rig)
    bodies = BodyShop(mirrors=mirrors, plain=plain).place(frame.actors, frame.ego.pose_world)
    walls = walls_of(obstacles).seen_from(frame.ego.pose_world)
    return beams, bodies, walls, Caster(beams).cast(bodies, walls, frame.actors.reflectivity)


@given(rig=rigs, actors=st.lists(things, max_size=4), obstacles=obstacles)
@settings(deadline=None, max_examples=60)
def test_kernel_equals_its_naive_twin(rig, actors, obstacles):
    """Fails when a beam is skipped that should be tested, or a plane, a wall, a limit is got wrong."""
    beams, bodies, walls, hits = cast(rig, world(*actors), obstacles)
    exact, grown, shrunk = (ray_ranges(beams, bodies, walls, grow) for grow in (0.0, 1e-9, -1e-9))
    # A ray that grazes an edge, or starts on a surface, may meet it or not, by rounding: the twin itself changes its
    # mind within a nanometre.
    firm = np.isclose(grown, shrunk, rtol=0, atol=1e-6).all(axis=1) & (exact.min(axis=1) > 1e-6)
    nearest = np.minimum(exact.min(axis=1), np.nextafter(beams.range_max, np.inf))
    expected = np.where((nearest >= beams.range_min) & (nearest < beams.range_max), nearest, np.inf)

    found = np.full(len(beams), np.inf)
    found[hits.beam] = hits.range
    np.testing.assert_allclose(found[firm], expected[firm], rtol=0, atol=1e-9)

    column = np.where(hits.target >= 0, hits.target, np.where(hits.target == WALL, len(bodies) + hits.surface, -1))
    assert np.all((hits.target == GROUND) == (column == -1))
    keep = firm[hits.beam]
    np.testing.assert_allclose(exact[hits.beam, column][keep], hits.range[keep], rtol=0, atol=1e-9)

    open_range = np.minimum(exact[:, -1], beams.range_max)[:, None]
    alone = (exact[:, : len(bodies)] < open_range) & (exact[:, : len(bodies)] >= beams.range_min[:, None])
    assert np.all(np.abs(alone[firm].sum(axis=0) - hits.alone) <= (~firm).sum())


@pytest.mark.parametrize("yaw", [0.3, 2.0, 4.0])
def test_a_unit_under_a_trailer_sees_it_all_around(yaw):
    """Fails when the azimuth interval of a box around the unit leaves directions out."""
    rig = one_unit_rig(small_unit((FULL_TURN,)), x=0.4, y=0.3, z=0.5)
    beams, bodies, walls, hits = cast(rig, world(Thing(1.0, 0.0, yaw, Kind.TRAILER_TRUCK)), NO_OBSTACLES)
    on_trailer, on_ground = ray_ranges(beams, bodies, walls).T
    met = hits.beam[hits.target == 0]
    assert np.array_equal(np.flatnonzero(on_trailer < on_ground), met)
    assert hits.alone[0] == len(met)
    assert np.ptp(beams.azimuth[met]) > np.pi


@pytest.mark.parametrize("quarters", range(4))
def test_a_beam_along_the_axes_of_a_body_meets_it(quarters):
    """Fails when a direction with a component of exactly zero is divided by, or taken for a miss."""
    straight = Fan((0,), 0.0, 0.0, 1.0, (100.0,))
    rig = one_unit_rig(small_unit((straight,), elevation_deg=(0.0,)))
    car = Thing(10.0, 0.0, quarters * np.pi / 2)
    _, _, _, hits = cast(rig, world(car), NO_OBSTACLES)
    depth = car.lwh[quarters % 2] / 2
    assert hits.range == pytest.approx([10.0 - depth], abs=1e-12)


@given(rig=rigs, actors=st.lists(things, min_size=1, max_size=4))
@settings(deadline=None, max_examples=40)
def test_hit_points_lie_on_the_surface_they_name(rig, actors):
    """Fails when plane, part, cosine or body coordinates belong to another surface than the range."""
    beams, bodies, _, hits = cast(rig, world(*actors), wall((50, -50), (50, 50)))
    on_actor = hits.target >= 0
    beam, actor, plane = hits.beam[on_actor], hits.target[on_actor], bodies.planes[hits.surface[on_actor]]
    point_ego = beams.origin_ego[beams.unit[beam]] + hits.range[on_actor, None] * beams.direction_ego[beam]
    x, y, yaw = bodies.pose_ego[actor].T
    dx, dy = point_ego[:, 0] - x, point_ego[:, 1] - y
    along, across = np.cos(yaw) * dx + np.sin(yaw) * dy, np.cos(yaw) * dy - np.sin(yaw) * dx
    np.testing.assert_allclose(hits.point_body[on_actor], np.column_stack([along, across]), atol=1e-9)
    height_over_plane = plane[:, 0] * along + plane[:, 1] * across + plane[:, 2] * point_ego[:, 2] - plane[:, 3]
    np.testing.assert_allclose(height_over_plane, 0.0, atol=1e-9)
    normal = np.column_stack(
        [np.cos(yaw) * plane[:, 0] - np.sin(yaw) * plane[:, 1], np.sin(yaw) * plane[:, 0] + np.cos(yaw) * plane[:, 1]]
    )
    cosine = -(normal * beams.direction_ego[beam, :2]).sum(axis=1) - plane[:, 2] * beams.direction_ego[beam, 2]
    np.testing.assert_allclose(hits.cosine[on_actor], cosine, atol=1e-12)
    assert np.all(hits.cosine > 0.0)
    np.testing.assert_array_equal(hits.part[on_actor], bodies.plane_part[hits.surface[on_actor]])


@pytest.mark.parametrize("seed", range(3))
def test_embree_agrees_on_the_same_bodies_as_meshes(seed):
    """An independent oracle: triangle meshes made by computational geometry, traced by Embree."""
    rng = np.random.default_rng(seed)
    actors = [_random_thing(rng, distance) for distance in rng.uniform(10.0, 45.0, 24)]
    model = small_unit((Fan(tuple(range(8)), 180.0, -179.5, 0.5, (100.0,)),), tuple(rng.uniform(-6.0, 3.0, 8)))
    rig = one_unit_rig(model, z=1.0, pitch_deg=2.0, roll_deg=-3.0)
    beams, bodies, walls, hits = cast(rig, world(*actors), NO_OBSTACLES)
    found = np.full(len(beams), np.inf)
    found[hits.beam] = hits.range

    meshes = [placed(body_mesh(solids_of(thing)), (thing.x, thing.y, thing.yaw)) for thing in actors]
    meshes.append(trimesh.creation.box(bounds=[[-400, -400, -1], [400, 400, 0]]))
    scene = trimesh.util.concatenate(meshes)
    assert type(scene.ray).__module__.endswith("ray_pyembree")
    origins = np.repeat(beams.origin_ego, len(beams), axis=0)
    _, ray, place = scene.ray.intersects_id(origins, beams.direction_ego, multiple_hits=False, return_locations=True)
    traced = np.full(len(beams), np.inf)
    traced[ray] = np.linalg.norm(place - origins[ray], axis=1)
    traced[traced > model.range_max_m] = np.inf

    assert (hits.target >= 0).sum() > 1000
    odd = np.flatnonzero(~np.isclose(found, traced, rtol=0, atol=1e-4))
    assert len(odd) < 0.002 * len(beams)
    # Single precision may see a ray pass by an edge, or not: so would we, were the bodies a little larger or smaller.
    grown, shrunk = (ray_ranges(beams, bodies, walls, grow, odd).min(axis=1) for grow in (1e-4, -1e-4))
    assert np.all((grown - 1e-3 <= traced[odd]) & ((traced[odd] <= shrunk + 1e-3) | (shrunk > model.range_max_m)))


def _random_thing(rng, distance):
    bearing, kind = rng.uniform(-np.pi, np.pi), Kind(rng.integers(len(Kind)))
    size = tuple(SHAPES[kind].size * rng.uniform(0.9, 1.15, 3))
    x, y = distance * np.cos(bearing), distance * np.sin(bearing)
    return Thing(x, y, rng.uniform(-np.pi, np.pi), kind, size)


def solids_of(thing, mirrors=True, plain=False):
    return body_solids(thing.kind, *thing.lwh, mirrors=mirrors, plain=plain)


@pytest.mark.parametrize("kind", list(Kind))
@given(scale=st.tuples(st.floats(0.5, 2), st.floats(0.5, 2), st.floats(0.5, 2)))
@settings(deadline=None, max_examples=5)
def test_bodies_fill_their_box_and_only_mirrors_stick_out(kind, scale):
    """Fails when a profile has a point outside, is not convex (then its corners differ), or does not reach its size."""
    size = np.multiply(SHAPES[kind].size, scale)
    thing = Thing(0, 0, kind=kind, size=tuple(size.tolist()))
    low, high = -0.5 * size * [1, 1, 0], 0.5 * size * [1, 1, 2]
    solids = [(solid.part, corners(solid.planes)) for solid in solids_of(thing)]
    body = np.concatenate([points for part, points in solids if part != Part.MIRROR])
    np.testing.assert_allclose(body.min(axis=0)[:2], low[:2], atol=1e-9)
    assert body[:, 2].min() > -1e-9
    np.testing.assert_allclose(body.max(axis=0), high, atol=1e-9)
    for solid, (part, points) in zip(solids_of(thing), solids, strict=True):
        np.testing.assert_allclose(np.array([points.min(axis=0), points.max(axis=0)]), solid.bounds, atol=1e-9)
        if part == Part.MIRROR:
            assert np.abs(points[:, 1]).max() > 0.5 * size[1]
            assert np.abs(points[:, 0]).max() < 0.5 * size[0]


def test_every_corner_of_a_profile_is_a_corner_of_its_solid():
    """Fails for a profile that is not convex or runs clockwise: its half-spaces would cut corners off."""
    for kind, shape in SHAPES.items():
        solids = body_solids(kind, *shape.size, mirrors=True, plain=False)
        prisms = [piece for piece in shape.pieces if hasattr(piece, "profile")]
        by_profile = [solid for solid in solids if any(_has_profile(solid, prism) for prism in prisms)]
        assert len(by_profile) == len(prisms)


def _has_profile(solid, prism):
    side_view = corners(solid.planes)[:, [0, 2]]
    distance = np.linalg.norm(side_view[:, None] - np.array(prism.profile), axis=2)
    return solid.part == prism.part and np.all(distance.min(axis=0) < 1e-9)


@pytest.mark.parametrize(
    ("kind", "windscreen_deg", "backlight_deg", "tumblehome_deg"),
    # Ranges of an angle study of production cars; see the table of proposed bodies in the sensor facts.
    [
        (Kind.CAR, (28, 32), (25, 35), (15, 22)),
        (Kind.SUV, (30, 38), (55, 75), (12, 18)),
        (Kind.VAN, (40, 50), None, (3, 8)),
    ],
)
def test_glass_leans_as_on_real_cars(kind, windscreen_deg, backlight_deg, tumblehome_deg):
    glass = next(s for s in solids_of(Thing(0, 0, kind=kind)) if s.part == Part.GREENHOUSE)
    nx, ny, nz = glass.planes[:, :3].T
    sloped = nz > 0.0
    lean = np.rad2deg(np.arctan2(np.hypot(nx, ny), nz))  # of the pane from the horizontal
    assert windscreen_deg[0] <= lean[sloped & (nx > 0.1)][0] <= windscreen_deg[1]
    assert tumblehome_deg[0] <= 90 - lean[sloped & (ny > 0.1)][0] <= tumblehome_deg[1]
    if backlight_deg:
        assert backlight_deg[0] <= lean[sloped & (nx < -0.1)][0] <= backlight_deg[1]


def test_without_layer_overlap_all_layers_see_the_same_outline():
    result, truth = scan(ahead(20.0), noise=PLAIN)
    on_car = truth.actor_id == 0
    assert set(result.layer[on_car]) == {0, 1, 2, 3}
    np.testing.assert_allclose(result.points_ego[on_car, 0], ahead(20.0).x - 2.35, atol=1e-5)
    detailed, detailed_truth = scan(ahead(20.0))
    spread = np.ptp(detailed.points_ego[(detailed_truth.actor_id == 0) & (detailed_truth.part == Part.BODY), 0])
    assert spread > 0.1


@given(yaw=st.floats(-3, 3), x=st.floats(-1e5, 1e5), y=st.floats(-1e5, 1e5))
@settings(deadline=None, max_examples=10)
def test_where_in_the_world_it_happens_changes_nothing(yaw, x, y):
    """Fails when single precision or a sign of the ego's yaw gets into the cast."""
    actors = [Thing(12, 3, 0.3), Thing(-9, -4, 2.0, Kind.SUV), Thing(20, -5, -1.0, Kind.BUS)]
    barrier = np.array([[-30.0, 12.0], [40.0, 14.0]])
    cos, sin = math.cos(yaw), math.sin(yaw)
    turn = np.array([[cos, sin], [-sin, cos]])
    moved = [Thing(*([thing.x, thing.y] @ turn + [x, y]), thing.yaw + yaw, thing.kind) for thing in actors]
    here, _ = scan(*actors, noise=PLAIN, obstacles=wall(*barrier))
    there, _ = scan(*moved, noise=PLAIN, obstacles=wall(*(barrier @ turn + [x, y])), ego=(x, y, yaw))
    np.testing.assert_allclose(there.points_ego, here.points_ego, atol=1e-4)


def test_a_polygon_of_two_points_is_one_wall():
    assert len(walls_of(wall((0, 5), (10, 5)))) == 1
    assert len(walls_of(wall((0, 5), (10, 5), (10, 9)))) == 3


def test_walls_end_at_their_height():
    """A unit at 0.55 m looks over a wall of 0.5 m, but for the layers that look down on it."""
    low, truth = scan(obstacles=wall((10, -5), (10, 5), height=0.5))
    on_wall = truth.part == Part.OBSTACLE
    assert set(low.layer[on_wall]) == {0, 1}
    assert low.points_ego[on_wall, 2].max() <= 0.5


def test_a_surface_nearer_than_the_least_range_blocks_the_beam():
    model = small_unit(elevation_deg=(0.0,), range_min=2.0)
    near, _ = scan(
        obstacles=Obstacles.from_polygons(
            [np.array([[1.0, -5.0], [1.0, 5.0]]), np.array([[9.0, -5.0], [9.0, 5.0]])], [3.0, 3.0]
        ),
        rig=one_unit_rig(model),
        noise=PLAIN,
    )
    assert len(near) == 0 or np.hypot(*near.points_ego[:, :2].T).min() >= 2.0
    assert not np.any(np.isclose(near.points_ego[:, 0], 9.0))
