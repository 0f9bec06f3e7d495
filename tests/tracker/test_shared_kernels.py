"""Kernels of boxes, pairs and free space, against their reference implementations."""

import numpy as np
import pytest
from support import naive_boxes

from luxloop.tracker.free_space import free, turned_returns
from luxloop.tracker.kernels import inside, placed
from luxloop.tracker.merging import HITS_MIN, LONGEST_M, TURN_MAX_RAD, WIDEST_M, fits, gap, hull, may_be_one
from luxloop.tracker.records import OrientedBoxes
from luxloop.tracker.tracking.track_table import centers


def random_pieces(rng, count=12):
    """Pieces in two lanes, most of them nearly parallel."""
    center = np.column_stack([rng.uniform(0.0, 60.0, count), rng.choice([0.0, 3.5], count)])
    heading = rng.choice([0.0, np.pi / 2], count) + rng.normal(0.0, 0.05, count)
    velocity, hits = rng.normal(8.0, 1.0, (count, 2)), rng.integers(1, 20, count)
    return OrientedBoxes(center, heading, rng.uniform(0.2, 8.0, (count, 2)), velocity, hits)


@pytest.mark.parametrize("seed", range(5))
def test_hulls_and_pairs_equal_the_reference(seed):
    pieces = random_pieces(np.random.default_rng(seed))
    expected = []
    for a in range(12):
        for b in range(12):
            low, high = naive_boxes.hull(pieces, a, b)
            np.testing.assert_allclose(hull(pieces, a, b), (low, high), atol=1e-12)
            assert gap(pieces, a, b) == pytest.approx(high[0] - low[0] - pieces.size[[a, b], 0].sum())
            fit = bool(high[0] - low[0] <= LONGEST_M and high[1] - low[1] <= WIDEST_M)
            assert fits(pieces, a, b) is fit
            near = np.hypot(*(pieces.center[b] - pieces.center[a])) < LONGEST_M
            turn = abs(np.sin(2 * (pieces.heading[b] - pieces.heading[a]))) <= 2 * TURN_MAX_RAD
            known = (pieces.hits[[a, b]] >= HITS_MIN).all()
            if a < b and near and turn and known and fit:
                expected.append((a, b))
    assert may_be_one(pieces) == expected


def test_pairs_of_no_pieces():
    none = OrientedBoxes(np.zeros((0, 2)), np.zeros(0), np.zeros((0, 2)), np.zeros((0, 2)), np.zeros(0, dtype=np.int64))
    assert may_be_one(none) == []


def test_points_inside_boxes_equal_the_reference():
    rng = np.random.default_rng(1)
    points, center = rng.uniform(-10.0, 10.0, (300, 2)), rng.uniform(-10.0, 10.0, (9, 2))
    heading, size = rng.uniform(-4.0, 4.0, 9), rng.uniform(0.1, 9.0, (9, 2))
    found = inside(points, center, heading, size)
    np.testing.assert_array_equal(found, naive_boxes.inside(points, center, heading, size))
    assert 0 < found.sum() < found.size


def test_centers_of_boxes_are_half_a_box_from_their_corners():
    rng = np.random.default_rng(2)
    center, heading, size = rng.normal(size=(9, 2)), rng.uniform(-4.0, 4.0, 9), rng.uniform(0.1, 9.0, (9, 2))
    sign = rng.choice([-1, 1], (9, 2))
    half = 0.5 * sign * size
    cos, sin = np.cos(heading), np.sin(heading)
    corner = center + np.stack([cos * half[:, 0] - sin * half[:, 1], sin * half[:, 0] + cos * half[:, 1]], axis=1)
    np.testing.assert_allclose(centers(corner, sign, heading, size), center, atol=1e-12)


@pytest.mark.parametrize("seed", range(5))
def test_free_places_equal_the_reference(seed):
    """Returns of walls with gaps, and places of all ranges, also at the ego."""
    rng = np.random.default_rng(seed)
    angle = rng.uniform(-np.pi, np.pi, 800)
    range_m = rng.uniform(1.0, 6.0) + 12.0 * (np.sin(3.0 * angle) > 0.0) + rng.normal(0.0, 0.3, 800)
    returns = (range_m * np.stack([np.cos(angle), np.sin(angle)])).T
    places = rng.normal(0.0, 8.0, (400, 2))
    found = free(places, returns, 1.0)
    np.testing.assert_array_equal(found, naive_boxes.free(places, returns, 1.0))
    assert 0 < found.sum() < found.size


def test_turned_returns_are_finite_and_rotated():
    points = np.array([[1.0, 2.0, 0.5], [np.nan, 0.0, 0.0], [3.0, 0.0, np.inf], [0.0, -4.0, 0.0]], dtype=np.float32)
    np.testing.assert_allclose(turned_returns(points, np.pi / 2), [[-2.0, 1.0], [4.0, 0.0]], atol=1e-15)


def test_points_are_placed_in_the_odometry_frame():
    points, pose = np.random.default_rng(6).normal(0.0, 20.0, (30, 3)), np.array([100.0, -50.0, 2.5])
    turn = np.array([[np.cos(pose[2]), -np.sin(pose[2])], [np.sin(pose[2]), np.cos(pose[2])]])
    np.testing.assert_allclose(placed(points, pose), points[:, :2] @ turn.T + pose[:2], atol=1e-12)
