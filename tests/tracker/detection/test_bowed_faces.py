"""Kernels of bowed faces: small systems, residuals and normal equations."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from support import naive_bodies

from tracker.detection import body_fit
from tracker.detection.body_fit import BodyFitConfig
from tracker.detection.kernels import bowed_faces, cholesky

SHAPE = body_fit._shape(BodyFitConfig())


@settings(deadline=None, max_examples=30)
@given(st.integers(0, 10_000), st.integers(1, 9))
def test_systems_equal_numpy(seed, count):
    rng = np.random.default_rng(seed)
    root, vector = rng.normal(size=(count, count)), rng.normal(size=count)
    matrix = root @ root.T + 0.1 * np.eye(count)
    triangle, solved = matrix.copy(), vector.copy()
    cholesky.factor(triangle)
    cholesky.solve(triangle, solved)
    np.testing.assert_allclose(np.tril(triangle), np.linalg.cholesky(matrix), atol=1e-10)
    np.testing.assert_allclose(solved, np.linalg.solve(matrix, vector), rtol=1e-7, atol=1e-9)


def test_only_the_lower_triangle_is_used():
    """Normal equations fill no other."""
    triangle, vector = np.array([[4.0, np.nan], [2.0, 5.0]]), np.array([10.0, 13.0])
    cholesky.factor(triangle)
    cholesky.solve(triangle, vector)
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


@settings(deadline=None, max_examples=30)
@given(st.integers(0, 10_000))
def test_residuals_equal_the_reference(seed):
    points, ray, _, state, side = scattered(seed)
    found = np.empty((len(points), 4))
    bowed_faces.residuals(points, ray, state, side, SHAPE, found)
    face, every = naive_bodies.faces(points, ray, state, side, SHAPE), np.arange(len(points))
    np.testing.assert_array_equal(found[:, 3], face)
    np.testing.assert_allclose(found[:, 0], naive_bodies.depths(points, state, side)[face, every], atol=1e-12)
    np.testing.assert_allclose(found[:, 1], naive_bodies.deviations(ray, state[0], SHAPE)[face, every], atol=1e-12)


@settings(deadline=None, max_examples=30)
@given(st.integers(0, 10_000), st.sampled_from([1.0, 4.0]))
def test_normal_equations_equal_the_reference(seed, scale):
    """Offsets of scan lines are eliminated in the kernel; the reference has them as correlations of the points."""
    points, ray, line, state, side = scattered(seed)
    rng, found = np.random.default_rng(seed), np.empty((len(points), 4))
    prior = rng.uniform(0.1, 0.5, (2, 5))
    bowed_faces.residuals(points, ray, state, side, SHAPE, found)
    ours = bowed_faces.normal_equations(points, line, 4, state, side, prior, scale, SHAPE, found)
    information, gradient = naive_bodies.normal_equations(points, ray, line, state, side, prior, scale, SHAPE)
    size = np.sqrt(np.outer(np.diag(information), np.diag(information)))
    np.testing.assert_allclose(ours[0] / size, np.tril(information) / size, atol=1e-6)
    np.testing.assert_allclose(ours[1], gradient, rtol=1e-5, atol=1e-5 * np.abs(gradient).max())


def test_a_point_on_the_face_and_one_inside_by_hand():
    """On the face 0.97; one standard deviation off e^-1/2 of that; inside 0.03 e^-d; in front of the face 0."""
    for depth, expected in ((0.0, (0.97, 0.0)), (0.03, (0.588335, 0.0291134)), (-0.03, (0.588335, 0.0))):
        assert bowed_faces.likelihood(depth, 0.03, SHAPE) == pytest.approx(expected, rel=1e-5)


def test_the_middle_of_a_whole_face_is_between_its_ends_and_of_a_part_follows_from_the_length():
    """A flank of 4 m from the corner at 0 is whole; an end of 0.8 m is a part of 1.8 m."""
    flank = np.stack([np.zeros(41), np.full(41, 0.02), np.linspace(0.0, 4.0, 41), np.zeros(41)], axis=1)
    end = np.stack([np.zeros(9), np.full(9, 0.02), np.linspace(0.0, 0.8, 9), np.ones(9)], axis=1)
    prior = bowed_faces.face_priors(np.concatenate([flank, end]), np.zeros(7), np.ones(2), 0, SHAPE)
    np.testing.assert_allclose(prior[0], [0.02, 0.02, 2.0, 0.3, 4.0])
    np.testing.assert_allclose(prior[1], [0.22, 0.5, 0.9, 0.8, 0.8])
    mirrored = np.concatenate([flank, end]) * [1.0, 1.0, -1.0, 1.0]
    prior = bowed_faces.face_priors(mirrored, np.zeros(7), -np.ones(2), 0, SHAPE)
    np.testing.assert_allclose(prior[:, 2], [-2.0, -0.9])
