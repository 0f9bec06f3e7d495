"""Rays on uneven ground: hand calculations, a slow reference implementation, and Embree."""

import math
from dataclasses import replace

import numpy as np
import pytest
from support.few import few
from support.naive_terrain import first_range, triangles_of
from support.optional import need
from support.sensor_scenes import (
    CENTRE_RAY,
    FOOTPRINT,
    LUX_RIG,
    NO_OBSTACLES,
    PLAIN,
    ActorSpec,
    ahead,
    placed_scene,
    small_unit,
    wall,
    world,
)
from support.solid_mesh import embree_ranges

from luxloop.sensor_model.bodies.walls import LONGEST_M, walls_of
from luxloop.sensor_model.ground import UnevenGround
from luxloop.sensor_model.kernels.ground_hits import terrain_hit
from luxloop.sensor_model.lidar import Lidar
from luxloop.sensor_model.raycaster import Raycaster
from luxloop.sensor_model.returns import GROUND
from luxloop.sensor_model.rig.beams import beam_table
from luxloop.sensor_model.rig.rig import Mount, Rig
from luxloop.sensor_model.rig.unit import Fan
from luxloop.sensor_model.truth import Part
from luxloop.sim.world import Terrain

GRADE = 0.06
UNIT_M = 0.5
"""Height of the unit."""


def ramp(foot=0.0, grade=GRADE, length=200.0):
    """Return a terrain that is flat up to x = `foot` and rises from there."""
    x = np.arange(-60.0, length + 1.0, 2.0)
    height = np.repeat(grade * np.maximum(x - foot, 0.0)[:, None], 61, axis=1)
    return Terrain(np.array([-60.0, -60.0]), 2.0, height)


def random_terrain(rng):
    return Terrain(rng.uniform(-40.0, -20.0, 2), rng.uniform(1.5, 3.0), rng.normal(0.0, 0.8, rng.integers(2, 30, 2)))


def rig_ahead(elevation_deg=(-1.5, -0.5, 1.5, 2.5)):
    """Return a rig of one unit at the origin, at the height `UNIT_M`, that looks ahead."""
    fan = Fan(tuple(range(len(elevation_deg))), 20.0, -20.0, 0.5, (100.0,))
    return Rig(0.0, (Mount("0", small_unit((fan,), elevation_deg), 0.0, 0.0, UNIT_M, 0.0, 0.0, 0.0),))


def cast(terrain, frame, rig, sensor=CENTRE_RAY, obstacles=NO_OBSTACLES):
    """Return beam table and echoes on a terrain at the height of the ego's place."""
    z = float(terrain.height_at(frame.ego.pose_world[:2]))
    frame = replace(frame, ego=replace(frame.ego, ground_z=z))
    beams, bodies, walls, context = placed_scene(rig, sensor, frame, obstacles)
    context = replace(context, ground=UnevenGround(terrain).seen_from(frame.ego), threshold=np.full(len(beams), 1e-30))
    return beams, Raycaster(beams, sensor).cast(bodies, walls, context)


@pytest.mark.parametrize(("foot", "elevation_deg"), [(10.0, -1.0), (10.0, 0.0), (10.0, 2.0), (24.0, -1.0), (24.0, 3.0)])
def test_ramp_ahead_is_hit_where_the_hand_calculation_says(foot, elevation_deg):
    """The plane z = g (x - d) and the ray z = h + x tan(e) meet at x = (h + g d) / (g - tan(e)), beyond the foot d."""
    beams, echoes = cast(ramp(foot), world(), rig_ahead((elevation_deg,)))
    middle = np.flatnonzero(np.abs(beams.azimuth[echoes.beam]) < 1e-9)
    x = (UNIT_M + GRADE * foot) / (GRADE - math.tan(math.radians(elevation_deg)))
    assert x > foot
    assert echoes.range[middle] == pytest.approx(x / math.cos(math.radians(elevation_deg)), abs=1e-9)
    normal = np.array([-GRADE, 0.0, 1.0]) / math.hypot(1.0, GRADE)
    cosine = -beams.direction_ego[echoes.beam[middle]] @ normal
    assert echoes.power[middle] * echoes.range[middle] ** 2 == pytest.approx(
        0.2 * cosine * beams.gain[echoes.beam[middle]], rel=1e-9
    )


def test_a_level_unit_above_a_flat_road_misses_the_ramp_of_a_steeper_ray():
    """tan(3.5 deg) = 0.0612 exceeds the slope: the ray never meets it."""
    _, echoes = cast(ramp(10.0, length=2000.0), world(), rig_ahead((3.5,)))
    assert len(echoes.beam) == 0


@pytest.mark.parametrize("seed", few(range(6), 0))
def test_reference_implementation_agrees(seed):
    rng = np.random.default_rng(seed)
    terrain = random_terrain(rng)
    ego = replace(world().ego, pose_world=rng.uniform(-10.0, 10.0, 3), ground_z=float(rng.normal()))
    ground = UnevenGround(terrain).seen_from(ego)
    triangles = triangles_of(terrain, margin=60)
    cos, sin = np.cos(ego.pose_world[2]), np.sin(ego.pose_world[2])
    R_world_ego = np.array([[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]])
    hits = 0
    for _ in range(60):
        origin = np.array([*rng.uniform(-15.0, 15.0, 2), rng.uniform(0.5, 6.0)])
        direction = rng.normal(0.0, (1.0, 1.0, 0.2))
        direction /= np.linalg.norm(direction)
        at, cosine = terrain_hit(tuple(origin), tuple(direction), 40.0, ground)
        start = R_world_ego @ origin + [*ego.pose_world[:2], ego.ground_z]
        if start[2] <= terrain.height_at(start[:2]):
            assert at == math.inf, "a unit below the ground sees none"
            continue
        wanted, wanted_cosine = first_range(start, R_world_ego @ direction, triangles)
        if wanted > 40.0:
            assert at == math.inf
        else:
            hits += 1
            assert (at, cosine) == pytest.approx((wanted, wanted_cosine), abs=1e-9)
    assert hits > 15


def test_rays_along_grid_lines_and_diagonals_hit():
    """Fails if a ray slips through between two cells."""
    terrain = Terrain(np.zeros(2), 1.0, np.zeros((20, 20)))
    ground = UnevenGround(terrain).seen_from(world().ego)
    for x, y in ((5.0, 5.0), (5.0, 5.5), (8.0, 8.0)):
        for turn in range(8):
            dx, dy = round(math.cos(turn * math.pi / 4)), round(math.sin(turn * math.pi / 4))
            at, cosine = terrain_hit((x, y, 1.0), (float(dx), float(dy), -0.25), 100.0, ground)
            assert (at, cosine) == pytest.approx((4.0, 0.25))


def test_embree_agrees_on_a_mesh_of_the_terrain():
    """Embree works in single precision, which resolves 100 m to 1e-5 m, and less at grazing angles."""
    need("dev", "trimesh", "embreex")
    import trimesh

    rng = np.random.default_rng(3)
    terrain = Terrain(
        np.array([-120.0, -120.0]), 3.0, rng.normal(0.0, 0.15, (81, 81)).cumsum(axis=0).cumsum(axis=1) * 0.1
    )
    rig = rig_ahead(tuple(np.linspace(-8.0, 4.0, 16)))
    frame = world()
    beams, echoes = cast(terrain, frame, rig)
    found = np.full(len(beams), np.inf)
    found[echoes.beam] = echoes.range
    triangles = triangles_of(terrain) - [0.0, 0.0, float(terrain.height_at(np.zeros(2)))]
    mesh = trimesh.Trimesh(triangles.reshape(-1, 3), np.arange(3 * len(triangles)).reshape(-1, 3), process=False)
    origins = beams.units.origin_ego[beams.unit]
    traced = embree_ranges(origins, beams.direction_ego, mesh)
    inside = np.hypot(*(origins + np.minimum(found, 200.0)[:, None] * beams.direction_ego)[:, :2].T) < 100.0
    assert inside.sum() > 500
    odd = ~np.isclose(found[inside], traced[inside], rtol=0, atol=1e-3)
    assert odd.mean() < 0.005


def test_flat_terrain_gives_the_echoes_of_the_plane():
    """The two kernels are independent; the tolerance is rounding."""
    frame = world(ahead(12.0), ahead(25.0, y=4.0))
    rig, terrain = rig_ahead((-6.0, -2.0, 0.5)), Terrain(np.array([-100.0, -100.0]), 2.0, np.zeros((101, 101)))
    beams, bodies, walls, context = placed_scene(rig, FOOTPRINT, frame, wall((20.0, -8.0), (40.0, -8.0)))
    caster = Raycaster(beams, FOOTPRINT)
    plane = caster.cast(bodies, walls, context)
    grid = caster.cast(bodies, walls, replace(context, ground=UnevenGround(terrain).seen_from(frame.ego)))
    assert (plane.target == GROUND).sum() > 50
    assert (grid.beam == plane.beam).all()
    assert (grid.target == plane.target).all()
    assert grid.range == pytest.approx(plane.range, abs=1e-9)
    assert grid.power == pytest.approx(plane.power, rel=1e-9)


def test_walls_follow_the_ground():
    """A wall of 1.2 m beside the ramp: each part has this height above the ground under its middle, without gaps."""
    terrain = ramp(0.0)
    static = replace(wall((0.0, -6.0), (100.0, -6.0), height=1.2), terrain=terrain)
    walls = walls_of(static)
    length = np.abs(walls.ends[:, 2] - walls.ends[:, 0])
    assert length.max() < LONGEST_M + 1e-9
    assert length.sum() == pytest.approx(100.0)
    middle = 0.5 * (walls.ends[:, 0] + walls.ends[:, 2])
    assert walls.z[:, 1] == pytest.approx(GRADE * middle + 1.2)
    assert walls.z[:, 0] == pytest.approx(GRADE * walls.ends[:, [0, 2]].min(axis=1))
    seen = walls.seen_from(np.array([50.0, 0.0, 0.0]), 3.0)
    assert seen.z == pytest.approx(walls.z - 3.0)
    assert len(walls_of(replace(static, terrain=None))) == 1


def test_on_a_constant_slope_the_scan_is_that_of_a_flat_road():
    """Ego and cars of one heading stand on one plane, so that the rig sees the same ahead and behind.

    Distances in plan are shorter by the slope's cosine, which is applied to the flat scene. No false ground appears.
    """
    specs = (ahead(12.0), ahead(25.0, y=4.0), ActorSpec(-14.0, 0.5), ActorSpec(-24.0, -3.0))
    flat, _ = Lidar(LUX_RIG, PLAIN, FOOTPRINT, 1, NO_OBSTACLES).scan(world(*specs))
    tilt = math.atan(GRADE)
    frame = world(*(replace(spec, x=spec.x * math.cos(tilt)) for spec in specs))
    x = np.arange(-150.0, 151.0, 2.0)
    terrain = Terrain(np.array([-150.0, -150.0]), 2.0, np.repeat(GRADE * x[:, None], 151, axis=1))
    uphill = np.array([-tilt, 0.0])
    actors = replace(
        frame.actors, ground_z=GRADE * frame.actors.pose_world[:, 0], attitude=np.tile(uphill, (len(specs), 1))
    )
    frame = replace(frame, ego=replace(frame.ego, attitude=uphill), actors=actors)
    static = replace(NO_OBSTACLES, terrain=terrain)
    scan, truth = Lidar(LUX_RIG, PLAIN, FOOTPRINT, 1, static).scan(frame)
    assert set(truth.actor_id[truth.actor_id >= 0]) == {0, 1, 2, 3}
    assert not (truth.part == Part.GROUND).any()
    assert abs(len(scan.points_ego) - len(flat.points_ego)) <= 0.01 * len(flat.points_ego)
    for low, high in ((-30.0, 0.0), (0.0, 40.0)):
        one, other = (
            points[(points[:, 0] > low) & (points[:, 0] < high)] for points in (scan.points_ego, flat.points_ego)
        )
        assert len(one) > 100
        assert one.mean(axis=0) == pytest.approx(other.mean(axis=0), abs=0.02)


def test_a_car_on_the_ramp_is_hit_at_its_height():
    """Its rear is at x = 25 m on a ramp from 10 m on: 0.9 m above the ego's road below, and 2.4 m and more above."""
    spec = ActorSpec(27.35, 0.0, size=(4.7, 1.8, 1.5))
    tilt = math.atan(GRADE)
    frame = world(spec)
    attitude, z = np.array([[-tilt, 0.0]]), np.array([GRADE * (27.35 - 10.0)])
    frame = replace(frame, actors=replace(frame.actors, ground_z=z, attitude=attitude))
    layers = tuple(np.arange(-2.0, 8.0, 0.25).tolist())
    _, echoes = cast(ramp(10.0), frame, rig_ahead(layers))
    beams = beam_table(rig_ahead(layers))
    origin = beams.units.origin_ego[beams.unit[echoes.beam]]
    height = (origin + echoes.range[:, None] * beams.direction_ego[echoes.beam])[echoes.target == 0][:, 2]
    assert height.min() == pytest.approx(0.9, abs=0.2)
    assert height.max() == pytest.approx(2.6, abs=0.25)
