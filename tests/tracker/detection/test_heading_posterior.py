"""Mean heading over all headings, and its variance."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from support import naive_fit
from support.shapes import l_shape, rotation
from support.stages import as_one_segment, off_quarter

from luxloop.tracker.detection import heading_posterior
from luxloop.tracker.detection.alignment import FLATNESS_M, REACH_M
from luxloop.tracker.detection.heading_posterior import SHAPE_STD_RAD, average
from luxloop.tracker.detection.segmentation import sort_by_segment
from luxloop.tracker.records import Segments


def mean_of(points):
    """Return the mean heading of points (N, 2), and its standard deviation [deg]."""
    heading, variance = average(as_one_segment(points))
    return heading[0], np.rad2deg(np.sqrt(variance[0]))


def arc(angle, radius=1.6, half_width=0.85, distance=20.0, count=60):
    """Return a bowed end without a face, seen head on from the ego; its vehicle is turned by an angle about it."""
    across = np.linspace(-half_width, half_width, count)
    depth = radius - np.sqrt(radius**2 - across**2)
    return np.column_stack([distance + depth, across]) @ rotation(angle).T


@given(st.integers(0, 10_000), st.integers(2, 40))
def test_costs_equal_the_reference(seed, count):
    rng = np.random.default_rng(seed)
    points, viewpoint = rng.normal((20.0, 5.0), (2.0, 0.3), (count, 2)), np.array([3.0, -0.5])
    heading = np.linspace(0.0, 1.5, 7)
    found = heading_posterior.heading_costs(points, np.array([0, count]), viewpoint[None], np.array([1.5]), heading)[0]
    ray = points.mean(axis=0) - viewpoint
    ray /= np.linalg.norm(ray)
    extent = np.ptp(points @ [-ray[1], ray[0]])
    for value, angle in zip(found, heading, strict=True):
        cos, sin = np.abs([ray @ [np.cos(angle), np.sin(angle)], ray @ [-np.sin(angle), np.cos(angle)]])
        missing = max(min(3.6 * sin + 1.5 * cos, 3.6 * cos + 1.5 * sin) - extent, 0.0)
        aligned = naive_fit.misalignment(points, angle, ray, REACH_M, FLATNESS_M, bins=4)
        assert value == pytest.approx(0.5 * count * aligned + 1.5 * missing)


@pytest.mark.parametrize("heading", [0.0, 0.3, 0.785, 1.55])
def test_a_clear_corner_has_the_least_standard_deviation(heading):
    found, std_deg = mean_of(l_shape(heading, step=0.1))
    assert abs(off_quarter(found, heading)) < 0.2
    assert std_deg == pytest.approx(np.rad2deg(SHAPE_STD_RAD), rel=0.15)


def test_an_arc_is_seen_head_on():
    """The limbs of an arc are aligned at headings to either side; without a flank the end is seen from ahead."""
    rng = np.random.default_rng(3)
    errors = []
    for _ in range(20):
        points = arc(0.7) + rng.normal(0.0, 0.02, (60, 2))
        errors.append(abs(off_quarter(mean_of(points)[0], 0.7)))
    assert np.mean(errors) < 4.0


def test_a_missing_flank_says_less_of_a_truncated_segment():
    """An occluder may hide it. Segments do not depend on each other."""
    both = np.concatenate([arc(0.0), arc(0.0)])
    points = sort_by_segment(both, Segments(np.repeat([0, 1], 60), 2), truncated=np.arange(120) == 3)
    _, variance = average(points)
    assert variance[0] > 1.02 * variance[1]
    assert variance[1] == pytest.approx(average(as_one_segment(arc(0.0)))[1][0])


def test_few_scattered_points_have_a_large_deviation():
    points = np.array([20.0, 0.0]) + np.random.default_rng(1).normal(0.0, 0.3, (8, 2))
    assert mean_of(points)[1] > 5.0


@pytest.mark.parametrize("turn", [0.4, 1.2])
def test_the_heading_turns_with_the_scene(turn):
    points = l_shape(0.3, step=0.1) + np.random.default_rng(2).normal(0.0, 0.03, (len(l_shape(0.3, step=0.1)), 2))
    heading, std_deg = mean_of(points)
    turned, std_turned_deg = mean_of(points @ rotation(turn).T)
    assert abs(off_quarter(turned, heading + turn)) < 0.2
    assert std_turned_deg == pytest.approx(std_deg, rel=0.1)


def test_the_order_of_points_has_no_effect():
    points = l_shape(0.3, step=0.05)
    order = np.random.default_rng(4).permutation(len(points))
    assert mean_of(points[order]) == pytest.approx(mean_of(points))


def test_no_segment():
    heading, variance = average(sort_by_segment(np.ones((3, 2)), Segments(np.full(3, -1), 0)))
    assert heading.shape == variance.shape == (0,)
