"""Static things as the sensor sees them: where their faces are, and what they hide and leave open."""

import math

import numpy as np
import pytest
from support.sensor_scenes import ahead, scan, wall

from sensor_model.truth import Part
from sensor_model.walls import walls_of
from sim.street import build, obstacles
from sim.world import Obstacles

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
