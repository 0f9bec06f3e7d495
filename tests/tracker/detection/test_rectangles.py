"""Candidate headings and their rectangles."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from support import naive_fit
from support.few import few
from support.shapes import l_shape, rotation
from support.stages import as_one_segment, fit_points, off_quarter, one_segment

from luxloop.tracker.detection import rectangles, tlinkage
from luxloop.tracker.detection.detector import Detector, DetectorConfig
from luxloop.tracker.detection.lidar import LidarConfig
from luxloop.tracker.detection.rectangles import RectangleConfig, extents
from luxloop.tracker.detection.rectangles import convex_hull as hull_of_sorted
from luxloop.tracker.detection.segmentation import sort_by_segment
from luxloop.tracker.detection.tlinkage import LinkageConfig
from luxloop.tracker.records import METHODS, Linkage, Segments

GRID = np.deg2rad(np.arange(90.0))
AREA, CLOSENESS, VARIANCE, TLINKAGE = range(4)


def by_x(points):
    return np.argsort(points[:, 0], kind="stable")


def convex_hull(points):
    return hull_of_sorted(points, by_x(points))


def criteria(points, angle, floor=0.01):
    score = np.empty((3, rectangles.LANES))
    angles = np.linspace(angle, angle + 1.0, rectangles.LANES)
    direction = np.array([np.cos(angles), np.sin(angles)])
    rectangles.criteria(points, rectangles.mean_of(points), convex_hull(points), direction, floor, score)
    return score[:, 0]


def headings(points, halvings=5):
    return rectangles.best_headings(points, np.array([0, len(points)]), GRID, 0.01, halvings)[0]


def test_criteria_by_hand():
    """L of (0,0) (1,0) (2,0) (0,1) at heading 0: the nearer edges are the lower ones, so D1 = x and D2 = y.

    Area 2 x 1. All four points lie on an edge, each counts 1 / d0 = 100. E1 = {0} and E2 = {0, 0}: no variance.
    """
    points = np.array([[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [0.0, 1.0]])
    assert criteria(points, 0.0) == pytest.approx((-2.0, 400.0, 0.0))


def test_variance_by_hand():
    """D1 = x, D2 = y as above; E1 holds x of points nearer to the left edge: {0, 0.2}, E2 {0.1, 0.3, 0}.

    var E1 = 0.01, var E2 = (0.1^2 + 0.3^2) / 3 - (0.4 / 3)^2 = 0.14 / 9.
    """
    points = np.array([[0.0, 4.0], [0.2, 2.0], [1.0, 0.1], [3.0, 0.3], [4.0, 0.0], [0.1, 0.1]])
    assert criteria(points, 0.0)[2] == pytest.approx(-(0.01 + 0.14 / 9))


@given(st.integers(0, 10_000), st.integers(1, 60), st.integers(0, 2))
def test_hull_reaches_as_far_as_the_points_in_every_direction(seed, count, digits):
    """Rounded to few digits, points coincide and are collinear."""
    points = np.round(np.random.default_rng(seed).normal(0.0, 2.0, (count, 2)), digits)
    angle = np.deg2rad(np.arange(360.0))
    normals = np.stack([np.cos(angle), np.sin(angle)])
    hull = convex_hull(points)
    np.testing.assert_array_equal(hull.T[0].max(), points.T[0].max())
    np.testing.assert_allclose((hull @ normals).max(axis=0), (points @ normals).max(axis=0), rtol=0.0, atol=1e-12)


def test_hull_leaves_out_inner_points():
    square = np.array([[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]])
    inner = np.random.default_rng(0).uniform(0.1, 1.9, (50, 2))
    assert {tuple(vertex) for vertex in convex_hull(np.concatenate([inner, square]))} == {tuple(v) for v in square}


def test_nearer_side_is_chosen_once_for_all_points():
    """Zhang 2017: a mirror point keeps its full distance. A choice per point would give 0, and closeness 500."""
    points = np.array([[0.0, 0.0], [0.0, 0.5], [0.0, 1.0], [0.1, 3.0], [2.0, 1.5]])
    expected = 100 + 100 + 100 + 1 / 0.1 + 1 / 1.5  # left edge; the last two are on neither
    assert criteria(points, 0.0)[1] == pytest.approx(expected)


@given(st.integers(0, 10_000), st.integers(3, 40), st.floats(0.0, 1.57))
def test_criteria_equal_the_reference(seed, count, angle):
    points = np.random.default_rng(seed).normal((10.0, -5.0), (2.0, 1.0), (count, 2))
    np.testing.assert_allclose(criteria(points, angle), naive_fit.criteria(points, angle, 0.01), rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize("seed", few(range(3), 1))
def test_search_finds_the_best_of_a_fine_brute_force(seed):
    """Variance is smooth near its peak: the refined search must be as good as 9000 headings."""
    points = l_shape(0.1 + 0.4 * seed, step=0.1)
    points += np.random.default_rng(seed).normal(0.0, 0.02, points.shape)
    fine = np.deg2rad(np.arange(0.0, 90.0, 0.01))
    scores = np.array([naive_fit.criteria(points, angle, 0.01) for angle in fine])
    found = headings(points)
    for method in (AREA, VARIANCE):
        assert abs(off_quarter(found[method], fine[scores[:, method].argmax()])) < 0.05
    assert np.array_equal(headings(points, halvings=0), GRID[scores[::100].argmax(axis=0)]), "the published search"
    coarse = scores[::100].max(axis=0)
    reached = [naive_fit.criteria(points, found[c], 0.01)[c] for c in range(3)]
    assert np.all(reached >= coarse)


@given(st.floats(0.0, np.pi / 2, exclude_max=True))
def test_closeness_and_variance_find_a_clean_l_below_the_grid(heading):
    """A grid of 1 degree has an error of up to 0.5, also across the wrap from 89.9 to 0 degrees."""
    found = headings(l_shape(heading))
    assert abs(off_quarter(found[VARIANCE], heading)) < 0.05
    assert abs(off_quarter(found[CLOSENESS], heading)) < 0.2


@pytest.mark.parametrize("heading_deg", [-0.4, -0.01, -1e-17, 0.0, 0.01, 89.7, 89.99])
def test_headings_stay_in_the_first_quarter(heading_deg):
    """The refinement searches below 0 degrees, and the record guarantees [0, pi/2)."""
    found = fit_points(l_shape(np.deg2rad(heading_deg))).candidates.heading
    assert np.all((found >= 0.0) & (found < np.pi / 2))
    assert abs(off_quarter(found[0, VARIANCE], np.deg2rad(heading_deg))) < 0.05


def test_area_is_ambiguous_for_a_right_triangle():
    """Both rectangles around a right triangle with legs a, b have area a b; without the corner the wrong one wins."""
    points = l_shape(0.0, length=4.0, width=2.0)[1:]
    points = points[np.linalg.norm(points - [10.0, 5.0], axis=1) > 0.3]
    assert abs(off_quarter(headings(points)[AREA], np.arctan2(-2.0, 4.0))) < 2.0


def test_segments_are_fitted_independently():
    """Offsets with an error of one would mix points of neighbours."""
    shapes = [l_shape(heading) for heading in (0.2, 0.7, 1.3)]
    segments = Segments(np.repeat(np.arange(3), [len(shape) for shape in shapes]), 3)
    mixed = np.random.default_rng(0).permutation(len(segments.label))
    points, segments = np.concatenate(shapes)[mixed], Segments(segments.label[mixed], 3)
    points = sort_by_segment(points, segments)
    found = rectangles.headings(points, tlinkage.link(points, LinkageConfig(), LidarConfig()), RectangleConfig())
    assert found.shape == (3, len(METHODS) - 1), "selection adds the refined one"
    assert np.abs(off_quarter(found[:, VARIANCE], [0.2, 0.7, 1.3])).max() < 0.05


@pytest.mark.parametrize("heading", [0.0, 0.3, 1.2])
def test_rectangle_of_a_clean_l(heading):
    points = l_shape(heading, length=4.0, width=2.0)
    fitted = fit_points(points)
    assert fitted.candidates.heading[0, TLINKAGE] == pytest.approx(fitted.linkage.heading[0])
    np.testing.assert_allclose(fitted.candidates.size[0, TLINKAGE], [4.0, 2.0], atol=1e-6)
    np.testing.assert_allclose(
        fitted.candidates.center_ego[0, TLINKAGE], np.array([10.0, 5.0]) + rotation(heading) @ [2.0, 1.0], atol=1e-6
    )


def test_a_mirror_biases_the_criteria_but_does_not_enlarge_the_rectangle():
    """As published, headings use all points; sides are measured on the lines."""
    body = l_shape(0.3, length=4.0, width=1.8, step=0.2)
    mirror = np.array([10.0, 5.0]) + np.array([[2.8, -0.18], [2.8, -0.2], [2.85, -0.2]]) @ rotation(0.3).T
    points = np.concatenate([body, mirror])
    clean, found = fit_points(body).candidates, fit_points(points).candidates
    np.testing.assert_allclose(found.size[0, TLINKAGE], clean.size[0, TLINKAGE], atol=1e-6)
    assert abs(off_quarter(found.heading[0, VARIANCE], 0.3)) > 0.5
    without = fit_points(points, rectangle=RectangleConfig(points="lines")).candidates
    assert abs(off_quarter(without.heading[0, VARIANCE], 0.3)) < 0.1


def test_sides_by_hand():
    """At normal incidence points are within 2.4 x 2.7 cm of the side: 4.02 and 4.0 of x, 1.0 of y, all zeros."""
    points = np.array([[0.0, 0.0], [4.02, 0.0], [4.0, 0.5], [3.93, 1.0], [0.0, 0.9]])
    center, size = rectangles.measure(
        as_one_segment(points), Linkage(np.zeros(5, int), np.zeros(1)), np.zeros((1, 1)), 0.027
    )
    np.testing.assert_allclose(size[0, 0], [4.01, 1.0])
    np.testing.assert_allclose(center[0, 0], [2.005, 0.5])


def test_sides_are_as_thick_as_the_range_noise_of_the_settings():
    """At normal incidence the side at x = 10 takes the points within 2.4 standard deviations: 10.1 with 5 cm only."""
    points = np.stack([np.repeat([10.0, 10.1, 12.0], 5), np.tile(np.linspace(-0.1, 0.1, 5), 3)], axis=1)
    near = []
    for range_std_m in (0.01, 0.05):
        detector = Detector(DetectorConfig(lidar=LidarConfig(range_std_m=range_std_m)))
        segmented, linkage = as_one_segment(points), Linkage(np.zeros(15, int), np.zeros(1))
        candidates = detector.fit(segmented, linkage)
        assert candidates.heading[0, TLINKAGE] == 0.0
        near.append(candidates.center_ego[0, TLINKAGE, 0] - 0.5 * candidates.size[0, TLINKAGE, 0])
    assert near == pytest.approx([10.0, 10.05], abs=1e-3)


def test_sides_ignore_outliers_and_are_those_of_each_heading():
    points = np.concatenate([l_shape(0.4, length=4.0, width=2.0), [[30.0, 30.0]]])
    line = np.append(np.zeros(len(points) - 1, int), -1)
    headings = np.array([[0.4, 0.4 + np.pi / 2]])
    center, size = rectangles.measure(as_one_segment(points), Linkage(line, np.array([0.4])), headings, 0.027)
    np.testing.assert_allclose(size[0], [[4.0, 2.0], [2.0, 4.0]], atol=1e-9)
    np.testing.assert_allclose(center[0], np.tile(np.array([10.0, 5.0]) + rotation(0.4) @ [2.0, 1.0], (2, 1)))


def test_noise_does_not_bias_the_sides():
    """The last of 40 to 80 points on a side lies some 2.2 standard deviations outside; a tenth of it is left.

    Range noise lies along the beam; of 2.5 cm the sides are met with 2.2 and 1.1, their last points 5 and 2.5 cm off.
    """
    rng = np.random.default_rng(3)
    error = []
    for _ in range(50):
        points = l_shape(0.0, length=4.0, width=2.0, step=0.05)
        points *= 1.0 + rng.normal(0.0, 0.025, (len(points), 1)) / np.linalg.norm(points, axis=1, keepdims=True)
        linkage = Linkage(np.zeros(len(points), int), np.zeros(1))
        center, size = rectangles.measure(as_one_segment(points), linkage, np.zeros((1, 1)), 0.027)
        error.append(center[0, 0] - 0.5 * size[0, 0] - [10.0, 5.0])
    assert np.abs(np.mean(error, axis=0)).max() < 0.006


@pytest.mark.parametrize("points", [np.full((8, 2), 4.0), np.stack([np.linspace(5, 9, 9), np.full(9, 3.0)], axis=1)])
def test_degenerate_segments_have_finite_rectangles(points):
    found = fit_points(points, segments=one_segment(len(points))).candidates
    assert np.isfinite(found.heading).all()
    assert np.isfinite(found.center_ego).all()
    assert (found.size >= 0.0).all()


def test_no_segment():
    nothing = sort_by_segment(np.ones((3, 2)), Segments(np.full(3, -1), 0))
    linkage = Linkage(np.full(3, -1), np.empty(0))
    found = rectangles.headings(nothing, linkage, RectangleConfig())
    assert found.shape == (0, 4)
    assert rectangles.measure(nothing, linkage, found, 0.027)[1].shape == (0, 4, 2)


@pytest.mark.parametrize("values", [{"halvings": -1}, {"halvings": 31}, {"closeness_floor_m": 0.0}])
def test_invalid_settings_are_rejected_by_name(values):
    with pytest.raises(ValueError, match=next(iter(values))):
        RectangleConfig(**values)


@given(st.integers(0, 2**32 - 1), st.integers(1, 40), st.integers(1, 40))
def test_extents_equal_the_reference(seed, count, more):
    rng = np.random.default_rng(seed)
    parts = [rng.normal([8.0, 3.0], [1.5, 0.6], (n, 2)) for n in (count, more)]
    heading = rng.uniform(0.0, np.pi / 2, (2, 3))
    scales = (0.025, 0.01, 2.4)
    ours = extents(np.concatenate(parts), np.array([0, count, count + more]), heading, *scales)
    for s, part in enumerate(parts):
        for mine, twin in zip(ours, naive_fit.extents(part, heading[s], *scales), strict=True):
            np.testing.assert_allclose(mine[s], twin, atol=1e-9)
