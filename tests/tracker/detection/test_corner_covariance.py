"""Covariance of the corner and heading of a fitted body."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from support.shapes import l_shape, rotation
from support.stages import fit_points

from luxloop.tracker.detection import boxes
from luxloop.tracker.detection.boxes import END_STD_M
from luxloop.tracker.records import Segments


def corner_covariance(body, from_mean, end_std_m=END_STD_M):
    return boxes.corner_covariance(np.array([body]), np.array([from_mean]), end_std_m)[0]


def test_the_corner_of_a_body_moves_when_it_turns():
    """About the mean, (2, -1) off the corner: dx = -y dphi and dy = x dphi add y^2, x^2 and -x y times the variance."""
    body = np.diag([0.02**2, 0.03**2, 0.01**2])
    result = corner_covariance(body, [2.0, -1.0], end_std_m=1e4)
    by_hand = [[0.0005, 0.0002, 0.0001], [0.0002, 0.0013, 0.0002], [0.0001, 0.0002, 0.0001]]
    np.testing.assert_allclose(result, by_hand, rtol=1e-3)


def test_the_end_of_a_body_without_points_has_the_prior():
    """10 m along x as good as unknown: the end's prior. Half of the information from each: half of the variance."""
    result = corner_covariance(np.diag([10.0**2, 0.3**2, 1e-6]), [0.0, 0.0], end_std_m=0.3)
    assert np.sqrt(result[0, 0]) == pytest.approx(0.3, rel=1e-3)
    assert result[1, 1] == pytest.approx(0.5 * 0.3**2)


def test_the_heading_of_a_body_without_faces_is_uniform_at_most():
    result = corner_covariance(np.diag([0.01, 0.01, 1e4]), [0.0, 0.0])
    assert np.rad2deg(np.sqrt(result[2, 2])) == pytest.approx(90.0 / np.sqrt(12.0), rel=1e-3)


@settings(max_examples=40)
@given(st.integers(0, 10_000), st.floats(-3.0, 3.0))
def test_the_covariance_of_a_corner_turns_with_the_scene(seed, angle):
    rng, turn = np.random.default_rng(seed), np.eye(3)
    turn[:2, :2] = rotation(angle)
    root, from_mean = rng.normal(0.0, 0.1, (3, 3)), rng.normal(0.0, 2.0, 2)
    body = root @ root.T + 1e-6 * np.eye(3)
    turned = corner_covariance(turn @ body @ turn.T, rotation(angle) @ from_mean)
    np.testing.assert_allclose(turned, turn @ corner_covariance(body, from_mean) @ turn.T, rtol=1e-6, atol=1e-9)


def test_boxes_report_the_covariance_of_their_bodies():
    """That of the second of two segments, the first of which is no vehicle. Outliers count in its mean."""
    wall, car = np.linspace((-15.0, 30.0), (15.0, 30.0), 300), l_shape(0.3, step=0.1)
    points, label = np.concatenate([wall, car, [[12.0, 8.0]]]), np.repeat([0, 1], [300, len(car) + 1])
    found = fit_points(points, segments=Segments(label, 2))
    assert found.linkage.line[-1] == -1
    from_mean = found.boxes.corner_ego[0] - points[label == 1].mean(axis=0)
    expected = corner_covariance(found.candidates.covariance[1], from_mean)
    assert found.boxes.segment.tolist() == [1]
    np.testing.assert_allclose(found.boxes.covariance[0], expected, rtol=1e-9)
