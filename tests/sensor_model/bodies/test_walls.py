"""Static obstacles in the scan: positions of their faces, and occlusion."""

import math
from dataclasses import fields

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from support.sensor_scenes import (
    CENTRE_RAY,
    LUX_RIG,
    PLAIN,
    ActorSpec,
    ahead,
    one_unit_rig,
    only,
    scan,
    small_unit,
    wall,
    walls,
    world,
)

from luxloop.sensor_model.bodies.walls import STRIDE, NearbyWalls, walls_of
from luxloop.sensor_model.kernels.culling import rig_reach
from luxloop.sensor_model.kernels.records import EgoDrive
from luxloop.sensor_model.lidar import Lidar
from luxloop.sensor_model.noise.noise_config import KINDS
from luxloop.sensor_model.raycaster import Raycaster
from luxloop.sensor_model.rig.unit import Fan
from luxloop.sensor_model.truth import Cause, Part
from luxloop.sim.obstacles import build, obstacles
from luxloop.sim.world import Kind, Obstacles

FRONT_UNITS_X = 3.55 - 1.385
"""[m] Position of the two forward units, at a height of 0.55 m."""


def street(*specs):
    """Return obstacles of (kind, points, sizes)."""
    return obstacles([p for kind, points, sizes in specs for p in build(kind, np.array(points, float), **sizes)])


def on_obstacles(scene):
    """Return the first echoes from obstacles, and their layers."""
    seen, truth = scene
    rows = np.flatnonzero((truth.part == Part.OBSTACLE) & (seen.echo == 0))
    return seen.points_ego[rows].astype(float), seen.layer[rows]


# ---- faces


def test_each_side_of_a_polygon_is_a_face_with_its_heights():
    square = np.array([[0.0, 0], [2, 0], [2, 2], [2, 2], [0, 2]])
    walls = walls_of(Obstacles.from_polygons([square, square[:2]], [3.0, 1.0], [0.2, 0.4], [0.0, 0.5]))
    assert walls.ends.tolist() == [[0, 0, 2, 0], [2, 0, 2, 2], [2, 2, 0, 2], [0, 2, 0, 0], [0, 0, 2, 0]]
    assert walls.z.tolist() == [[0.0, 3.0]] * 4 + [[0.5, 1.0]]
    assert walls.reflectivity.tolist() == [0.2] * 4 + [0.4]


def test_no_obstacles_no_faces():
    walls = walls_of(Obstacles.from_polygons([], []))
    assert len(walls) == 0
    assert walls.z.shape == (0, 2)
    assert len(walls.seen_from(np.zeros(3))) == 0


def test_faces_are_transformed_to_the_frame_of_a_pose():
    walls = walls_of(wall((10.0, 5.0), (10.0, 8.0))).seen_from(np.array([10.0, 2.0, math.pi / 2]))
    assert walls.ends == pytest.approx(np.array([[3.0, 0.0, 6.0, 0.0]]))  # north of an ego that heads north
    assert walls.z.tolist() == [[0.0, 3.0]]


# ---- visibility


def test_a_pole_is_seen_by_several_layers_at_its_place_and_size():
    points, layer = on_obstacles(scan(obstacles=street(("pole", [(8.0, 0.5)], {"diameter": 0.4}))))
    assert len(points) >= 12
    assert set(layer) == {0, 1, 2, 3}
    off = np.hypot(*(points[:, :2] - (8.0, 0.5)).T)
    # a footprint is 0.08 degrees wide: beams just beside the pole may still get an echo of it
    assert (off < 0.2 * 1.05 + 0.01).all()
    assert (points[:, 0] < 8.0 + 0.06).all(), "its rear is not seen"
    assert 0.25 < np.ptp(points[:, 1]) < 0.43


def test_beams_pass_below_and_above_a_guard_rail():
    """The top layer passes over a rail at 20 m, the lowest one under it between its posts; the third hits it."""
    rail = ("guard-rail", [(FRONT_UNITS_X + 20, -9.0), (FRONT_UNITS_X + 20, 9.0)], {})
    house = ("building", [(FRONT_UNITS_X + 21.5, -30.0), (FRONT_UNITS_X + 21.5, 30.0)], {})
    points, layer = on_obstacles(scan(obstacles=street(rail, house)))
    near = np.abs(points[:, 1]) < 5.0
    points, layer = points[near], layer[near]
    behind = points[:, 0] > FRONT_UNITS_X + 21.0
    assert behind[layer == 3].all()
    assert not behind[layer == 2].any()
    below = behind[layer == 0]
    assert 0.5 < below.mean() < 1.0, "some beams hit a post"


def test_raised_wall_hides_no_object_below_it():
    car, corners = ahead(10.0), [(8.0, -9.0), (8.0, 9.0)]
    free, _ = scan(car)
    under, _ = scan(car, obstacles=street(("wall", corners, {"base": 2.0, "height": 4.0})))
    assert np.array_equal(under.points_ego, free.points_ego)
    _, behind = scan(car, obstacles=street(("wall", corners, {"height": 4.0})))
    assert not (behind.actor_id >= 0).any()


# ---- walls within reach


ALL_NOISE = only(*KINDS)
HEADS_ON = small_unit([Fan((0,), 45.0, -45.0, 7.5, (100.0,))], (0.0,), range_max_m=60.0, reference_range_m=1000.0)
"""A unit with level beams, sensitive enough for mirror images up to its range."""

WALL = st.tuples(st.floats(-280, 280), st.floats(-280, 280), st.floats(0.1, 300), st.floats(-4, 4), st.floats(0.1, 20))
STEP = st.tuples(st.floats(-40, 40), st.floats(-40, 40), st.floats(-1, 1))


LIMIT = st.tuples(st.floats(-4, 4), st.sampled_from((-1.0, 0.0, 1.0)) | st.floats(-4, 4))


def at_the_limit(place, limits):
    """Yield walls for `town` across the view of a LUX, 200 m away plus an excess, each of (bearing, excess)."""
    for bearing, beyond in limits:
        cos, sin, far = math.cos(bearing), math.sin(bearing), 200.0 + beyond
        yield place[0] + far * cos + 30.0 * sin, place[1] + far * sin - 30.0 * cos, 60.0, bearing + math.pi / 2, 9.0


def town(sides):
    """Return walls of (x, y, length, direction, height), each starting at x, y."""
    ends = [((x, y), (x + length * math.cos(a), y + length * math.sin(a))) for x, y, length, a, _ in sides]
    return Obstacles.from_polygons([np.array(pair) for pair in ends], [side[-1] for side in sides])


def reversed_order(obstacles):
    polygons = np.split(obstacles.vertices_world, obstacles.offset[1:-1])
    return Obstacles.from_polygons(polygons[::-1], obstacles.height[::-1], obstacles.reflectivity[::-1])


def drive(poses):
    """Yield frames of a fast ego at each pose, between the same two cars; the one beside it acts as a mirror."""
    for index, (x, y, yaw) in enumerate(poses):
        cos, sin = math.cos(yaw), math.sin(yaw)
        cars = [
            ActorSpec(x + cos * a - sin * b, y + sin * a + cos * b, yaw, id=id) for a, b, id in ((9, 0, 1), (4, -3, 2))
        ]
        ego = ActorSpec(x, y, yaw, velocity=(30.0 * cos, 30.0 * sin), acceleration=(-3.0, 1.0), yaw_rate=0.3)
        yield world(*cars, ego=ego, index=index)


def scans(obstacles, poses, *, all_walls=False):
    """Return all scan and truth fields of a drive, optionally with culling of walls disabled."""
    with pytest.MonkeyPatch.context() as patch:
        if all_walls:
            patch.setattr(Raycaster, "reach", lambda *_: math.inf)
        lidar = Lidar(LUX_RIG, ALL_NOISE, CENTRE_RAY, 1, obstacles)
        parts = [part for frame in drive(poses) for part in lidar.scan(frame)]
    return [getattr(part, field.name) for part in parts for field in fields(part)]


def assert_same(some, others):
    for one, other in zip(some, others, strict=True):
        np.testing.assert_array_equal(one, other)


@given(
    sides=st.lists(WALL, max_size=20), limits=st.lists(LIMIT, max_size=9), steps=st.lists(STEP, min_size=1, max_size=4)
)
def test_culling_of_walls_changes_no_scan(sides, limits, steps):
    """Fails if culling drops a wall that a beam may hit, directly or by a mirror, or changes the order of walls."""
    poses = np.cumsum(steps, axis=0)
    obstacles = town([*sides, *at_the_limit(poses[-1], limits)])
    assert_same(scans(obstacles, poses), scans(obstacles, poses, all_walls=True))


@given(seed=st.integers(0, 1000))
def test_order_of_obstacles_changes_no_scan(seed):
    """Fails if results depend on a wall's index. Here no walls coincide; of coinciding walls the first is hit."""
    rng = np.random.default_rng(seed)
    low, high = (-100, -100, 5, -3, 1), (100, 100, 60, 3, 9)
    obstacles, poses = town(rng.uniform(low, high, (60, 5)).tolist()), [(0.0, 0.0, 0.1), (15.0, 2.0, 0.3)]
    assert_same(scans(obstacles, poses), scans(reversed_order(obstacles), poses))


@pytest.mark.parametrize(("beyond", "seen"), [(-0.01, True), (0.0, False), (0.01, False)])
@pytest.mark.parametrize("x", [0.0, STRIDE, STRIDE + 1.0])
def test_wall_is_seen_up_to_the_range_of_a_unit_at_its_firing_position(x, beyond, seen):
    """The unit is ahead of the ego's centre and fires late: fails if the reach omits either."""
    rig = one_unit_rig(HEADS_ON, x=3.0, phase_ms=40.0)
    at = x + 3.0 + 0.04 * 25.0 + 60.0 + beyond
    lidar = Lidar(rig, PLAIN, CENTRE_RAY, 1, wall((at, -0.1), (at, 0.1)))
    for index, place in enumerate((0.0, x)):
        points, truth = lidar.scan(world(ego=ActorSpec(place, 0.0, velocity=(25.0, 0.0)), index=index))
    assert len(points) == seen
    assert (truth.part == Part.OBSTACLE).all()


@pytest.mark.parametrize("x", [0.0, STRIDE])
def test_wall_seen_only_in_a_mirror_is_kept(x):
    """A beam 15 degrees to the left hits a truck's flank, and from there a wall between two other beams."""
    lidar = Lidar(one_unit_rig(HEADS_ON), only("ghost"), CENTRE_RAY, 1, wall((x + 57.9, -14.0), (x + 57.9, -8.0)))
    for index, place in enumerate((0.0, x)):
        truck = ActorSpec(place + 10.0, 3.5, kind=Kind.TRUCK, size=(20.0, 2.5, 4.0))
        _, truth = lidar.scan(world(truck, ego=ActorSpec(place, 0.0), index=index))
    assert not (truth.part == Part.OBSTACLE).any()
    ghosts = truth.true_range[truth.cause == Cause.GHOST]
    assert ghosts == pytest.approx([57.9 / math.cos(math.radians(15.0))], abs=2e-3)


def test_reach_of_a_rig_is_that_of_its_farthest_beam():
    """5 m from the centre, 0.1 s early or late: 3 m by speed, 0.05 m by acceleration, 0.1 m by turning."""
    origin = np.array([[0.0, 0.0, 1.0], [3.0, 4.0, 0.5]])
    turning = EgoDrive(30.0, 0.0, 0.0, -10.0, -0.2)
    assert rig_reach(origin, np.array([50.0, 60.0]), 0.1, turning) == pytest.approx(5.0 + 60.0 + 3.0 + 0.05 + 0.1)
    assert rig_reach(origin, np.array([70.0, 60.0]), 0.1, turning) == pytest.approx(70.0 + 3.0 + 0.05)


def test_nearby_walls_are_near_or_long_and_keep_their_order():
    """A long noise barrier passes near by although its middle is far; a short wall at that distance is dropped."""
    barrier, far, near = ((-20.0, 30.0), (400.0, 30.0)), ((190.0, 40.0), (191.0, 40.0)), ((5.0, 5.0), (6.0, 5.0))
    nearby = NearbyWalls(walls_of(walls(far, barrier, far, near)))
    pose = np.zeros(3)
    around = nearby.seen_from(pose, 50.0)
    assert around.ends.tolist() == [[-20, 30, 400, 30], [5, 5, 6, 5]]
    pose[0] = 140.0
    assert len(nearby.seen_from(pose, 50.0)) == 3, "the ego approached the others and left one"
    pose[0] = 0.0
    assert len(nearby.seen_from(pose, 50.0)) == 2, "and returned"


def test_nearby_walls_follow_a_larger_reach_of_a_standing_ego():
    """The reach grows with the delays of the units and the speed of the ego."""
    nearby, pose = NearbyWalls(walls_of(walls(((60.0, 0.0), (61.0, 0.0))))), np.zeros(3)
    assert [len(nearby.seen_from(pose, reach)) for reach in (20.0, 60.0)] == [0, 1]
