"""Plane geometry of the tracker: single vectors and matrices, as in arrays."""

import numpy as np

from luxloop.tracker.geometry import rotate, rotate_one, rotated_covariance, variance_along


def test_one_vector_rotates_as_an_array_of_vectors():
    rng = np.random.default_rng(1)
    vectors, angles = rng.normal(size=(50, 2)), rng.uniform(-7.0, 7.0, 50)
    one = [rotate_one(vector, angle) for vector, angle in zip(vectors, angles.tolist(), strict=True)]
    np.testing.assert_allclose(one, rotate(vectors, angles), rtol=0.0, atol=1e-15)
    np.testing.assert_allclose(rotate_one(np.array([2, 0]), np.pi / 2), [0.0, 2.0], atol=1e-15)


def test_variances_along_a_heading_are_those_of_the_rotated_covariance():
    rng = np.random.default_rng(2)
    for heading in rng.uniform(-7.0, 7.0, 20).tolist():
        variance = rng.uniform(0.1, 2.0, 2)
        turn = np.array([[np.cos(heading), -np.sin(heading)], [np.sin(heading), np.cos(heading)]])
        covariance = turn @ np.diag(variance) @ turn.T
        np.testing.assert_allclose(rotated_covariance(variance, heading), covariance, atol=1e-14)
        np.testing.assert_allclose(variance_along(covariance, heading), variance, atol=1e-14)
