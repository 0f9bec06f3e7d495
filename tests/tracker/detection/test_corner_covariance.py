"""Covariance of corner and heading with the heading variance of the selection."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from support.shapes import l_shape
from support.stages import fit_points

from luxloop.tracker.detection import boxes
from luxloop.tracker.records import Segments


@given(st.integers(0, 10_000), st.floats(1e-6, 0.3))
def test_the_corner_given_the_heading_is_unchanged(seed, variance):
    """The conditional mean of the corner stays; its conditional covariance gains the common error of the depths."""
    root = np.random.default_rng(seed).normal(0.0, 0.1, (3, 3))
    old = root @ root.T + 1e-6 * np.eye(3)
    new = boxes.with_heading_variance(old[None], np.array([variance]))[0]
    slope = old[:2, 2] / old[2, 2]
    np.testing.assert_allclose(new[2, 2], variance)
    np.testing.assert_allclose(new[:2, 2], slope * variance)
    expected = old[:2, :2] + (variance - old[2, 2]) * np.outer(slope, slope) + boxes.DEPTH_STD_M**2 * np.eye(2)
    np.testing.assert_allclose(new[:2, :2], expected, atol=1e-12)
    assert np.linalg.eigvalsh(new).min() > 0.0


def test_boxes_report_the_variance_of_their_headings():
    """That of the second of two segments, the first of which is no vehicle."""
    wall, car = np.linspace((-15.0, 30.0), (15.0, 30.0), 300), l_shape(0.3, step=0.1)
    found = fit_points(np.concatenate([wall, car]), segments=Segments(np.repeat([0, 1], [300, len(car)]), 2))
    assert found.boxes.segment.tolist() == [1]
    np.testing.assert_allclose(found.boxes.covariance[0, 2, 2], found.candidates.heading_variance[1])
