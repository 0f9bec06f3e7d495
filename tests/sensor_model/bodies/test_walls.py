"""Static things as the sensor sees them: where their faces are, and what they hide and leave open."""

import math
from dataclasses import fields

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from support.sensor_scenes import (
    CENTRE_RAY,
    LUX_RIG,
    PLAIN,
    Thing,
    ahead,
    one_unit_rig,
    only,
    scan,
    small_unit,
    wall,
    walls,
    world,
)

from sensor_model.bodies.walls import STRIDE, Vicinity, walls_of
from sensor_model.kernels.culling import reach_of_rig
from sensor_model.kernels.records import EgoDrive
from sensor_model.lidar import Lidar
from sensor_model.noise.noise_config import NoiseConfig
from sensor_model.raycaster import Raycaster
from sensor_model.rig.unit import Fan
from sensor_model.truth import Cause, Part
from sim.obstacles import build, obstacles
from sim.world import Kind, Obstacles

FRONT_UNITS_X = 3.55 - 1.385
"""[m] Of the two units that look ahead, at a height of 0.55 m."""


def street(*things):
    """Obstacles of (kind, points, sizes)."""
    return obstacles([p for kind, points, sizes in things for p in build(kind, np.array(points, float), **sizes)])


def on_obstacles(scene):
    """First echoes from obstacles, and their layers."""
    seen, truth = scene
    rows = np.flatnonzero((truth.part == Part.OBSTACLE) & (seen.echo == 0))
    return seen.points_ego[rows].astype(float), seen.layer[rows]


# ---- faces


def test_each_side_is_a_face_with_its_polygon_s_edges():
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


def test_seen_from_a_pose_a_face_is_turned_back():
    walls = walls_of(wall((10.0, 5.0), (10.0, 8.0))).seen_from(np.array([10.0, 2.0, math.pi / 2]))
    assert walls.ends == pytest.approx(np.array([[3.0, 0.0, 6.0, 0.0]]))  # north of an ego that looks north
    assert walls.z.tolist() == [[0.0, 3.0]]


# ---- what is seen of them


def test_a_pole_is_seen_by_several_layers_at_its_place_and_size():
    points, layer = on_obstacles(scan(obstacles=street(("pole", [(8.0, 0.5)], {"diameter": 0.4}))))
    assert len(points) >= 12
    assert set(layer) == {0, 1, 2, 3}
    off = np.hypot(*(points[:, :2] - (8.0, 0.5)).T)
    # a footprint is 0.08 degrees wide: beams just beside the pole may still get an echo of it
    assert (off < 0.2 * 1.05 + 0.01).all()
    assert (points[:, 0] < 8.0 + 0.06).all(), "its rear is not seen"
    assert 0.25 < np.ptp(points[:, 1]) < 0.43


def test_a_guard_rail_is_seen_through_below_and_above():
    """The top layer passes over a rail at 20 m, the lowest one under it between its posts; the third meets it."""
    rail = ("guard-rail", [(FRONT_UNITS_X + 20, -9.0), (FRONT_UNITS_X + 20, 9.0)], {})
    house = ("building", [(FRONT_UNITS_X + 21.5, -30.0), (FRONT_UNITS_X + 21.5, 30.0)], {})
    points, layer = on_obstacles(scan(obstacles=street(rail, house)))
    near = np.abs(points[:, 1]) < 5.0
    points, layer = points[near], layer[near]
    behind = points[:, 0] > FRONT_UNITS_X + 21.0
    assert behind[layer == 3].all()
    assert not behind[layer == 2].any()
    below = behind[layer == 0]
    assert 0.5 < below.mean() < 1.0, "some beams meet a post"


def test_what_floats_hides_nothing_below_it():
    car, corners = ahead(10.0), [(8.0, -9.0), (8.0, 9.0)]
    free, _ = scan(car)
    under, _ = scan(car, obstacles=street(("wall", corners, {"base": 2.0, "height": 4.0})))
    assert np.array_equal(under.points_ego, free.points_ego)
    _, behind = scan(car, obstacles=street(("wall", corners, {"height": 4.0})))
    assert not (behind.actor_id >= 0).any()


# ---- which of them count


ALL_NOISE = only(*(field.name for field in fields(NoiseConfig)))
HEADS_ON = small_unit([Fan((0,), 45.0, -45.0, 7.5, (100.0,))], (0.0,), range_max_m=60.0, reference_range_m=1000.0)
"""A unit that sees level, and even what a mirror shows as far as its range."""

WALL = st.tuples(st.floats(-280, 280), st.floats(-280, 280), st.floats(0.1, 300), st.floats(-4, 4), st.floats(0.1, 20))
STEP = st.tuples(st.floats(-40, 40), st.floats(-40, 40), st.floats(-1, 1))


LIMIT = st.tuples(st.floats(-4, 4), st.sampled_from((-1.0, 0.0, 1.0)) | st.floats(-4, 4))


def at_the_limit(place, limits):
    """Walls across what a LUX at a place sees 200 m away, of (bearing, how much farther) each, as `town` takes them."""
    for bearing, beyond in limits:
        cos, sin, far = math.cos(bearing), math.sin(bearing), 200.0 + beyond
        yield place[0] + far * cos + 30.0 * sin, place[1] + far * sin - 30.0 * cos, 60.0, bearing + math.pi / 2, 9.0


def town(sides):
    """Walls of (x, y, length, direction, height), from x, y on; those of the same corner cross each other."""
    ends = [((x, y), (x + length * math.cos(a), y + length * math.sin(a))) for x, y, length, a, _ in sides]
    return Obstacles.from_polygons([np.array(pair) for pair in ends], [side[-1] for side in sides])


def reversed_order(obstacles):
    polygons = np.split(obstacles.vertices_world, obstacles.offset[1:-1])
    return Obstacles.from_polygons(polygons[::-1], obstacles.height[::-1], obstacles.reflectivity[::-1])


def drive(poses):
    """Frames of a fast ego at each of these poses, between the same two cars; the one beside it is a mirror."""
    for index, (x, y, yaw) in enumerate(poses):
        cos, sin = math.cos(yaw), math.sin(yaw)
        cars = [Thing(x + cos * a - sin * b, y + sin * a + cos * b, yaw, id=id) for a, b, id in ((9, 0, 1), (4, -3, 2))]
        ego = Thing(x, y, yaw, velocity=(30.0 * cos, 30.0 * sin), acceleration=(-3.0, 1.0), yaw_rate=0.3)
        yield world(*cars, ego=ego, index=index)


def scans(obstacles, poses, *, all_walls=False):
    """All that a LIDAR says of a drive, with its truth; it can be made to go through all walls of the world."""
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
@settings(deadline=None, max_examples=40)
def test_walls_out_of_reach_change_nothing(sides, limits, steps):
    """Fails when a wall that a beam may meet, straight on or by a mirror, is left out, or when walls change order."""
    poses = np.cumsum(steps, axis=0)
    obstacles = town([*sides, *at_the_limit(poses[-1], limits)])
    assert_same(scans(obstacles, poses), scans(obstacles, poses, all_walls=True))


@given(seed=st.integers(0, 1000))
@settings(deadline=None, max_examples=10)
def test_the_order_of_obstacles_changes_nothing(seed):
    """Fails when something depends on a wall's number. No two walls coincide here: of such the first is met."""
    rng = np.random.default_rng(seed)
    low, high = (-100, -100, 5, -3, 1), (100, 100, 60, 3, 9)
    obstacles, poses = town(rng.uniform(low, high, (60, 5)).tolist()), [(0.0, 0.0, 0.1), (15.0, 2.0, 0.3)]
    assert_same(scans(obstacles, poses), scans(reversed_order(obstacles), poses))


@pytest.mark.parametrize(("beyond", "seen"), [(-0.01, True), (0.0, False), (0.01, False)])
@pytest.mark.parametrize("x", [0.0, STRIDE, STRIDE + 1.0])
def test_a_wall_counts_up_to_the_range_of_a_unit_where_it_fires(x, beyond, seen):
    """The unit is ahead of the ego's middle, and fires late: fails when either is left out of its reach."""
    rig = one_unit_rig(HEADS_ON, x=3.0, phase_ms=40.0)
    at = x + 3.0 + 0.04 * 25.0 + 60.0 + beyond
    lidar = Lidar(rig, PLAIN, CENTRE_RAY, 1, wall((at, -0.1), (at, 0.1)))
    for index, place in enumerate((0.0, x)):
        points, truth = lidar.scan(world(ego=Thing(place, 0.0, velocity=(25.0, 0.0)), index=index))
    assert len(points) == seen
    assert (truth.part == Part.OBSTACLE).all()


@pytest.mark.parametrize("x", [0.0, STRIDE])
def test_a_wall_counts_if_it_is_seen_in_a_mirror_alone(x):
    """A beam 15 degrees to the left meets a truck's flank, and from there a wall between two other beams."""
    lidar = Lidar(one_unit_rig(HEADS_ON), only("ghost"), CENTRE_RAY, 1, wall((x + 57.9, -14.0), (x + 57.9, -8.0)))
    for index, place in enumerate((0.0, x)):
        truck = Thing(place + 10.0, 3.5, kind=Kind.TRUCK, size=(20.0, 2.5, 4.0))
        _, truth = lidar.scan(world(truck, ego=Thing(place, 0.0), index=index))
    assert not (truth.part == Part.OBSTACLE).any()
    ghosts = truth.true_range[truth.cause == Cause.GHOST]
    assert ghosts == pytest.approx([57.9 / math.cos(math.radians(15.0))], abs=2e-3)


def test_the_reach_of_a_rig_is_that_of_its_farthest_beam():
    """5 m ahead of the middle, 0.1 s early or late: 3 m by speed, 0.05 m by acceleration, 0.1 m by turning."""
    origin = np.array([[0.0, 0.0, 1.0], [3.0, 4.0, 0.5]])
    turning = EgoDrive(30.0, 0.0, 0.0, -10.0, -0.2)
    assert reach_of_rig(origin, np.array([50.0, 60.0]), 0.1, turning) == pytest.approx(5.0 + 60.0 + 3.0 + 0.05 + 0.1)
    assert reach_of_rig(origin, np.array([70.0, 60.0]), 0.1, turning) == pytest.approx(70.0 + 3.0 + 0.05)


def test_walls_around_are_near_or_long_and_keep_their_order():
    """A noise barrier passes near by, its middle is far; what is as far as that is not kept."""
    barrier, far, near = ((-20.0, 30.0), (400.0, 30.0)), ((190.0, 40.0), (191.0, 40.0)), ((5.0, 5.0), (6.0, 5.0))
    vicinity = Vicinity(walls_of(walls(far, barrier, far, near)))
    pose = np.zeros(3)
    around = vicinity.seen_from(pose, 50.0)
    assert around.ends.tolist() == [[-20, 30, 400, 30], [5, 5, 6, 5]]
    pose[0] = 140.0
    assert len(vicinity.seen_from(pose, 50.0)) == 3, "the ego came to the others, and left one"
    pose[0] = 0.0
    assert len(vicinity.seen_from(pose, 50.0)) == 2, "and went back"
