"""Kernels of bowed faces: small systems, residuals and normal equations."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from support import naive_bodies

from luxloop.tracker.detection import body_fit, bowed_faces
from luxloop.tracker.detection.bowed_faces import ASIDE, DEPTH, FACE, PLACE, RESIDUALS, VARIANCE

SHAPE = bowed_faces.BodyShape(range_std=0.027)


@settings(max_examples=30)
@given(st.integers(0, 10_000), st.integers(1, 9))
def test_systems_equal_numpy(seed, count):
    rng = np.random.default_rng(seed)
    root, vector = rng.normal(size=(count, count)), rng.normal(size=count)
    matrix = root @ root.T + 0.1 * np.eye(count)
    triangle, solved = matrix.copy(), vector.copy()
    bowed_faces.factor(triangle)
    bowed_faces.solve(triangle, solved)
    np.testing.assert_allclose(np.tril(triangle), np.linalg.cholesky(matrix), atol=1e-10)
    np.testing.assert_allclose(solved, np.linalg.solve(matrix, vector), rtol=1e-7, atol=1e-9)


def test_only_the_lower_triangle_is_used():
    """Normal equations fill no other."""
    triangle, vector = np.array([[4.0, np.nan], [2.0, 5.0]]), np.array([10.0, 13.0])
    bowed_faces.factor(triangle)
    bowed_faces.solve(triangle, vector)
    np.testing.assert_allclose(np.tril(np.nan_to_num(triangle)), [[2.0, 0.0], [1.0, 2.0]])
    np.testing.assert_allclose(vector, [1.5, 2.0])  # 4 * 1.5 + 2 * 2 = 10, 2 * 1.5 + 5 * 2 = 13


def scattered(seed):
    """Points about the faces of a random state, some inside and outside: points, rays, scan lines, state and sides."""
    rng = np.random.default_rng(seed)
    heading, side, count = rng.uniform(-np.pi, np.pi), rng.choice([-1.0, 1.0], 2), 80
    middle, curvature, depth = rng.normal(0.0, 0.3, 2), rng.uniform(0.0, 0.4, 2), rng.uniform(-1.5, -0.5, 2)
    face, place = rng.integers(0, 2, count), rng.uniform(-1.5, 1.5, count)
    inward = depth[face] + curvature[face] * (place - middle[face]) ** 2
    inward += rng.normal(0.0, 0.03, count) + np.where(rng.random(count) < 0.2, rng.normal(0.3, 0.3, count), 0.0)
    local = np.where(face[:, None] == 0, np.stack([place, side[0] * inward], 1), np.stack([side[1] * inward, place], 1))
    points = local @ np.array([[np.cos(heading), np.sin(heading)], [-np.sin(heading), np.cos(heading)]])
    bearing = rng.uniform(-np.pi, np.pi, count)
    ray = np.stack([np.cos(bearing), np.sin(bearing)], axis=1)
    state = np.array([heading, *np.stack([depth, curvature, middle], axis=1).ravel()]) + rng.normal(0.0, 0.02, 7)
    return points, ray, rng.integers(0, 4, count), state, side


@settings(max_examples=30)
@given(st.integers(0, 10_000))
def test_residuals_equal_the_reference(seed):
    points, ray, _, state, side = scattered(seed)
    found = np.empty((RESIDUALS, len(points)))
    bowed_faces.residuals(bowed_faces.Beams(*points.T.copy(), *ray.T.copy()), state, side, SHAPE, found)
    face, every = naive_bodies.faces(points, ray, state, side, SHAPE), np.arange(len(points))
    np.testing.assert_array_equal(found[FACE], face)
    np.testing.assert_allclose(found[DEPTH], naive_bodies.depths(points, state, side)[face, every], atol=1e-12)
    std = naive_bodies.deviations(ray, state[0], SHAPE)[face, every]
    np.testing.assert_allclose(np.sqrt(found[VARIANCE]), std, atol=1e-12)
    cos, sin = np.cos(state[0]), np.sin(state[0])
    along, across = points @ [cos, sin], points @ [-sin, cos]
    np.testing.assert_allclose(found[PLACE], np.where(face == 0, along, across), atol=1e-12)
    np.testing.assert_allclose(found[ASIDE], np.where(face == 0, across, along), atol=1e-12)


@settings(max_examples=30)
@given(st.integers(0, 10_000), st.sampled_from([1.0, 4.0]))
def test_normal_equations_equal_the_reference(seed, scale):
    """Offsets of scan lines are eliminated in the kernel; the reference has them as correlations of the points."""
    points, ray, line, state, side = scattered(seed)
    order = np.argsort(line, kind="stable")
    points, ray, line = points[order], ray[order], line[order]
    found, ours = np.empty((RESIDUALS, len(points))), (np.empty((7, 7)), np.empty(7))
    prior = np.random.default_rng(seed).uniform(0.1, 0.5, (2, 5))
    bowed_faces.residuals(bowed_faces.Beams(*points.T.copy(), *ray.T.copy()), state, side, SHAPE, found)
    start = body_fit.line_starts(line)
    bowed_faces.normal_equations(start, state, side, prior, scale, SHAPE, found, ours)
    information, gradient = naive_bodies.normal_equations(points, ray, line, state, side, prior, scale, SHAPE)
    size = np.sqrt(np.outer(np.diag(information), np.diag(information)))
    np.testing.assert_allclose(ours[0] / size, np.tril(information) / size, atol=1e-6)
    np.testing.assert_allclose(ours[1], gradient, rtol=1e-5, atol=1e-5 * np.abs(gradient).max())


def test_odds_of_a_point_inside_by_hand():
    """On the face 0.97 e^(-z^2 / 2), inside 0.03 e^-d; none in front. Their ratio, one standard deviation deep."""
    for depth, expected in ((0.0, 0.0), (-0.03, 0.0), (0.03, 0.0291134 / 0.588335)):
        assert bowed_faces.odds_inside(depth, 0.03**2, SHAPE) == pytest.approx(expected, rel=1e-5)
    assert bowed_faces.odds_inside(2.0, 0.03**2, SHAPE) == pytest.approx(0.03 / 0.97 * np.exp(40.0 - 2.0))


def test_scan_lines_begin_where_the_number_changes():
    assert body_fit.line_starts(np.array([3, 3, 7, 8, 8, 8])).tolist() == [0, 2, 3, 6]
    assert body_fit.line_starts(np.array([5])).tolist() == [0, 1]


@settings(max_examples=30)
@given(st.integers(0, 10_000), st.integers(1, 60))
def test_a_shallow_depth_is_that_of_sorting(seed, count):
    place = np.random.default_rng(seed).normal(size=count).round(1)
    rank = int(0.08 * count)
    assert body_fit.shallow_depth(place, rank) == np.sort(place)[rank]


def test_the_middle_of_a_whole_face_is_between_its_ends_and_of_a_part_follows_from_the_length():
    """A flank of 4 m from the corner at 0 is whole; an end of 0.8 m is a part of 1.8 m."""
    found, prior = np.zeros((RESIDUALS, 50)), np.empty((2, 5))
    found[VARIANCE], found[FACE, 41:] = 0.02**2, 1.0
    found[PLACE, :41], found[PLACE, 41:] = np.linspace(0.0, 4.0, 41), np.linspace(0.0, 0.8, 9)
    bowed_faces.face_priors(found, np.zeros(7), np.ones(2), 0, SHAPE, prior)
    np.testing.assert_allclose(prior[0], [0.02, 0.02, 2.0, 0.3, 4.0])
    np.testing.assert_allclose(prior[1], [0.22, 0.5, 0.9, 0.8, 0.8])
    found[PLACE] *= -1.0
    bowed_faces.face_priors(found, np.zeros(7), -np.ones(2), 0, SHAPE, prior)
    np.testing.assert_allclose(prior[:, 2], [-2.0, -0.9])
