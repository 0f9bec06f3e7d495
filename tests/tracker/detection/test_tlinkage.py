"""T-linkage: preferences, merging, outliers, lines and headings."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from support import naive_faces, naive_fit
from support.shapes import Car, l_shape, rotation, scan_car
from support.stages import as_one_segment, off_quarter

from luxloop.tracker.detection import faces, lines, tlinkage
from luxloop.tracker.detection.lidar import LidarConfig
from luxloop.tracker.detection.lines import LENGTH_MIN_M
from luxloop.tracker.detection.point_groups import even_subset
from luxloop.tracker.detection.segmentation import sort_by_segment
from luxloop.tracker.detection.tlinkage import LinkageConfig
from luxloop.tracker.records import Segments

LIDAR = LidarConfig()


def link(points, **config):
    return tlinkage.link(as_one_segment(points), LinkageConfig(**config), LIDAR)


def ranged(points, rng, std=0.025):
    """Points with the noise of a LIDAR at the origin: along the beams."""
    distance = np.linalg.norm(points, axis=1, keepdims=True)
    return points * (1.0 + rng.normal(0.0, std, distance.shape) / distance)


def noisy_l(seed, heading=0.3, std=0.025):
    return ranged(l_shape(heading, step=0.1), np.random.default_rng(seed), std)


# --- by hand --------------------------------------------------------------------------------


def test_preference_by_hand():
    """Equation (1): 1 on the line, e^-1/2 at half the threshold, 0 at the threshold."""
    points = np.array([[3.0, 0.0], [-1.0, 0.05], [7.0, 0.1], [2.0, -0.3]])
    table = tlinkage.preferences(points, np.array([[0.0, 1.0, 0.0]]), 0.1)
    np.testing.assert_allclose(table, [[1.0, 0.6065306597126334, 0.0, 0.0]])


def test_tanimoto_by_hand():
    """Equation (2): of (1, 1, 0) and (1, 0, 1), <p, q> = 1 and |p|^2 = |q|^2 = 2, so d = 1 - 1 / (2 + 2 - 1)."""
    assert tlinkage.tanimoto(1.0, 2.0, 2.0) == pytest.approx(2.0 / 3.0)
    assert tlinkage.tanimoto(2.0, 2.0, 2.0) == 0.0
    assert tlinkage.tanimoto(0.0, 0.0, 0.0) == 1.0


def test_merging_by_hand():
    """Points 0 and 1 share both their lines, 2 shares one with them at half strength; 3 is orthogonal to all."""
    table = np.array([[1.0, 1.0, 0.5, 0.0], [1.0, 1.0, 0.0, 0.0], [0.0, 0.0, 0.0, 1.0]])
    label = tlinkage.agglomerate(table)
    assert label[0] == label[1] == label[2] != label[3]


def test_merged_preference_is_the_minimum():
    """0-1 merge first and agree on line 0 only; 2 shares line 1 only with 1, so it stays separate."""
    table = np.array([[1.0, 0.9, 0.0], [0.0, 0.6, 1.0]])
    label = tlinkage.agglomerate(table)
    assert label[0] == label[1] != label[2]


def test_chance_by_hand():
    """Of 4 points, 3 on a line: 6 pairs times P(at least 1 of 2 others near), share 0.1: 6 * (1 - 0.9^2) = 1.14."""
    assert np.exp(lines.log_chance(4, 3, 0.1)) == pytest.approx(1.14)


# --- reference implementations --------------------------------------------------------------


@pytest.mark.parametrize("seed", range(3))
def test_stages_equal_the_reference(seed):
    rng = np.random.default_rng(seed)
    points = np.concatenate([noisy_l(seed)[::2], rng.uniform((8, 3), (14, 8), (8, 2))])
    hypotheses = tlinkage.hypotheses(points, 0.25)
    pairs = naive_fit.near_pairs(points, 0.25)
    for line, (i, j) in zip(hypotheses, pairs, strict=True):
        assert abs(line[:2] @ points[i] + line[2]) < 1e-9
        assert abs(line[:2] @ points[j] + line[2]) < 1e-9
        assert np.hypot(*line[:2]) == pytest.approx(1.0)

    table = tlinkage.preferences(points, hypotheses, 0.08)
    np.testing.assert_allclose(table, naive_fit.preferences(points, hypotheses, 0.08), atol=1e-12)

    label = tlinkage.agglomerate(table.copy())
    found = {frozenset(np.flatnonzero(label == name).tolist()) for name in np.unique(label)}
    assert found == naive_fit.agglomerate(table)

    other = naive_fit.fit_line(rng.normal([10.0, 5.0], 1.0, (9, 2)))  # through no point, to avoid ties
    sides = np.stack([lines.fit_line(points, label, label[0]), other])
    np.testing.assert_array_equal(lines.assign(points, sides, 0.3), naive_fit.assign(points, sides, 0.3))


@given(st.integers(0, 10_000), st.integers(1, 9), st.floats(0.2, 0.9))
def test_merging_equals_the_reference_for_any_preferences(seed, count, density):
    """Cached neighbours must never hide the least distance."""
    rng = np.random.default_rng(seed)
    table = rng.random((6, count)) * (rng.random((6, count)) < density)
    label = tlinkage.agglomerate(table.copy())
    assert {frozenset(np.flatnonzero(label == name).tolist()) for name in label} == naive_fit.agglomerate(table)


def car_and_clusters(seed, config, step=1):
    """Points of a car at a random aspect by bearing, every `step`-th, and the clusters of these, largest first."""
    rng = np.random.default_rng(seed)
    center = 18.0 * np.array([np.cos(seed), np.sin(seed)])
    car = Car(tuple(center), rng.uniform(0, np.pi), mirrors=True, window_depth=1.1 * (seed % 2))
    points, _ = scan_car(car, rng)
    points = points[np.argsort(np.arctan2(points[:, 1], points[:, 0]))]
    sample = points[::step]
    every = tlinkage.hypotheses(sample, tlinkage.LOCALITY)
    cluster = tlinkage.agglomerate(tlinkage.preferences(sample, every, config.tau_m))
    names = sorted(np.unique(cluster), key=lambda name: (-np.sum(cluster == name), name))
    return points, cluster, [sample[cluster == name] for name in names]


@pytest.mark.parametrize("seed", range(12))
def test_lines_equal_the_reference(seed):
    """Stages after clustering: chance, refinement."""
    config = LinkageConfig(variant="lines")
    points, _, clusters = car_and_clusters(seed, config)
    sides = naive_fit.find_lines(points, clusters, config.tau_m, LENGTH_MIN_M, np.sin(np.deg2rad(20.0)))
    twin = naive_fit.settle(points, sides, config.tau_m)
    found = link(points, variant="lines", points_max=len(points))
    np.testing.assert_array_equal(found.line, twin)
    normal = naive_fit.fit_line(points[twin == 0])[:2]
    assert off_quarter(found.heading[0], np.arctan2(normal[1], normal[0])) == pytest.approx(0.0, abs=1e-6)


@pytest.mark.parametrize("seed", range(24))
def test_faces_equal_the_reference(seed):
    """Stages after clustering: the corner, its fit, and body points."""
    config = LinkageConfig()
    step = 1 + seed % 3  # the sample proposes, all points score
    points, cluster, clusters = car_and_clusters(seed, config, step)
    chosen = np.arange(0, len(points), step)
    noise = np.array([LIDAR.range_std_m, faces.FLATNESS_M])
    limits = (noise, faces.GATE, faces.CURVE_DEPTH_M, faces.CURVE_BEYOND_M)
    offset, first = np.array([0, len(points)]), np.array([0, len(chosen)])
    found = faces.best_corners(points, offset, chosen, first, cluster, noise, config.tau_m)
    twin = naive_faces.best_corner(points, clusters, chosen, config.tau_m, *limits, LENGTH_MIN_M)
    np.testing.assert_allclose(found[0], twin, atol=1e-9)

    uncertainty, information = faces.fit_corners(points, offset, found, noise, np.array([faces.GATE]))
    faces.put_dominant_first(found, uncertainty, information)
    twin, twin_uncertainty = naive_faces.fit_corner(points, twin, noise, faces.GATE)
    np.testing.assert_allclose(found[0], twin, atol=1e-6)
    np.testing.assert_allclose(
        uncertainty[0, found[0].any(axis=1)], twin_uncertainty[found[0].any(axis=1)], rtol=1e-5, atol=1e-6
    )

    wide = faces.excesses(points, offset, found, noise, config.tau_m)[0]
    assert wide == pytest.approx(naive_faces.excess(points, found[0], noise, config.tau_m))

    heights = np.random.default_rng(seed).uniform(0.3, 1.2, len(points))
    gate = np.array([faces.GATE])
    for height in (np.zeros(len(points)), heights):
        cloud = np.column_stack([points, height])
        label, _ = faces.label_bodies(points, height, offset, found, uncertainty, noise, gate, LIDAR.pitch_rad)
        np.testing.assert_array_equal(
            label, naive_faces.label_body(cloud, found[0], uncertainty[0], *limits, np.deg2rad(0.25))
        )


@given(st.lists(st.sampled_from([0.0, 0.5, 1.0, 2.0, 7.0]) | st.floats(0.0, 9.0), min_size=1, max_size=40))
def test_the_median_is_that_of_numpy(values):
    spare = np.array([*values, -1.0])  # values after the first `count` have no effect
    assert faces.median(spare, len(values)) == np.median(values)


@given(st.integers(0, 10_000), st.floats(0.0, np.pi))
def test_line_fit_equals_singular_values(seed, angle):
    points = np.random.default_rng(seed).normal(0.0, [2.0, 0.1], (12, 2)) @ rotation(angle).T + [30.0, -20.0]
    ours = lines.fit_line(points, np.zeros(12, np.int64), 0)
    twin = naive_fit.fit_line(points)
    np.testing.assert_allclose(ours * np.sign(ours @ twin), twin, atol=1e-9)


@given(st.integers(3, 120), st.integers(3, 120), st.integers(1, 90))
def test_chance_equals_the_binomial_tail(count, support, percent):
    """Summed in integers, because probabilities are as low as 10^-200."""
    support, others, hits = min(count, support), count - 2, min(count, support) - 2
    ways = sum(math.comb(others, j) * percent**j * (100 - percent) ** (others - j) for j in range(hits, others + 1))
    pairs = math.log(count * (count - 1) / 2)
    value = lines.log_chance(count, support, percent / 100)
    if hits > others * percent / 100:
        assert value == pytest.approx(pairs + math.log(ways) - others * math.log(100), rel=1e-9, abs=1e-9)
    else:
        assert value == pytest.approx(pairs)  # for fewer than expected the bound is sufficient


# --- cars -----------------------------------------------------------------------------------


@given(st.floats(0.0, 1.57), st.integers(0, 1000))
def test_an_l_is_two_lines_at_any_heading(heading, seed):
    linkage = link(noisy_l(seed, heading))
    assert linkage.line.max() == 1
    assert np.mean(linkage.line < 0) < 0.05
    assert abs(off_quarter(linkage.heading[0], heading)) < 0.8
    assert 0.0 <= linkage.heading[0] < np.pi / 2
    assert np.sum(linkage.line == 0) >= np.sum(linkage.line == 1)


def test_a_single_side_is_one_line():
    points = np.stack([np.linspace(10, 14, 30), np.full(30, 5.0)], axis=1)
    linkage = link(ranged(points, np.random.default_rng(0)))
    assert linkage.line.tolist() == [0] * 30
    assert abs(off_quarter(linkage.heading[0], 0.0)) < 0.5


def test_four_points_are_a_second_side_and_three_outliers_are_not():
    """The rule of chance: a short side of few points is accepted if most of the remaining points lie on it."""
    side = np.stack([np.linspace(10, 14, 40), np.full(40, 5.0)], axis=1)
    rear = np.array([[10.0, 5.4], [10.0, 5.8], [10.0, 6.2], [10.0, 6.6]])
    strays = np.array([[11.0, 6.9], [12.7, 5.9], [13.4, 6.6]])
    assert link(np.concatenate([side, rear])).line[40:].tolist() == [1] * 4
    assert link(np.concatenate([side, strays])).line[40:].tolist() == [-1] * 3


@pytest.mark.parametrize("seed", range(4))
def test_windows_and_mirrors_are_outliers_and_body_points_are_not(seed):
    """A window is a separate line parallel to the rear; a mirror protrudes from the side."""
    car = Car(center=(14.0, 6.0), heading=0.2, mirrors=True, window_depth=1.2)
    points, wrong = scan_car(car, np.random.default_rng(seed))
    removed = link(points).line < 0
    assert wrong.sum() > 8
    assert np.mean(removed[wrong]) > 0.8
    assert np.mean(removed[~wrong]) < 0.1


def corner_of(points):
    """Corner of one segment, its uncertainty, and the gate of its points."""
    offset, config, noise = np.array([0, len(points)]), LinkageConfig(), np.array([LIDAR.range_std_m, faces.FLATNESS_M])
    chosen, first = even_subset(points, offset, config.points_max)
    cluster = tlinkage.link_samples(points[chosen], first, tlinkage.LOCALITY, config.tau_m)
    corner = faces.best_corners(points, offset, chosen, first, cluster, noise, config.tau_m)
    faces.fit_corners(points, offset, corner, noise, np.array([faces.GATE]))
    gate = faces.GATE * faces.excesses(points, offset, corner, noise, config.tau_m)
    uncertainty, information = faces.fit_corners(points, offset, corner, noise, gate)
    faces.put_dominant_first(corner, uncertainty, information)
    return corner[0], uncertainty[0], gate[0]


def test_curved_parts_belong_to_their_line_without_effect_on_its_direction():
    """Rounded corners are body; they must not be outliers and not bias the heading."""
    points, _ = scan_car(Car(center=(12.0, 5.0), heading=0.2, layer_bias=(0.0,) * 4), np.random.default_rng(2))
    with_curves, (corner, uncertainty, gate) = link(points), corner_of(points)
    limits = np.array([LIDAR.range_std_m, faces.FLATNESS_M]), gate, 0.05, faces.CURVE_BEYOND_M
    without = naive_faces.label_body(points, corner, uncertainty, *limits, LIDAR.pitch_rad)
    assert np.sum(with_curves.line < 0) < 0.5 * np.sum(without < 0)
    assert abs(off_quarter(with_curves.heading[0], 0.2)) < 0.5


def test_a_sparse_long_flank_is_the_dominant_line():
    """A dense bumper with its rounded corner has the most points, but 4 m of flank fix the heading better."""
    flank = np.stack([np.linspace(10.5, 14.2, 9), np.full(9, 4.0)], axis=1)
    corner = np.array([10.35, 4.35]) - 0.35 * np.stack([np.cos(a := np.linspace(0.1, 1.5, 12)), np.sin(a)], axis=1)
    bumper = np.stack([np.full(20, 10.0), np.linspace(4.3, 4.8, 20)], axis=1)
    linkage = link(ranged(np.concatenate([flank, corner, bumper]), np.random.default_rng(3)))
    assert abs(off_quarter(linkage.heading[0], 0.0)) < 1.0
    assert linkage.line[:9].tolist() == [0] * 9
    assert set(linkage.line[21:]) == {1}
    paper = link(np.concatenate([flank, corner, bumper]), variant="paper")
    assert np.mean(paper.line[21:] == 0) == 1.0, "the largest cluster is the paper's dominant line"


def front_view(z=True):
    """A front of 1.8 m at x = 10, a hood's edge by the unseen left flank, and mirrors: points, and mask of outliers."""
    front = np.stack([np.full(25, 10.0), np.linspace(-0.9, 0.9, 25), np.full(25, 0.5)], axis=1)
    edge = np.array([[10.8, 0.82, 0.9], [11.2, 0.74, 0.95]])
    wrong = np.array([[11.4, 1.06, 1.0], [11.4, -1.05, 1.0], [11.0, 0.2, 0.95], [11.1, -0.3, 0.95]])
    points = np.concatenate([front, edge, wrong])
    return points if z else points[:, :2], np.repeat([False, True], [27, 4])


@pytest.mark.parametrize("z", [True, False])
def test_points_along_the_unseen_sides_of_a_front_are_body(z):
    """Points beyond its ends are mirrors, points well behind are seen over it, points along its ends are body."""
    points, wrong = front_view(z)
    np.testing.assert_array_equal(link(points).line < 0, wrong)


def test_the_base_of_a_mirror_is_removed_with_it():
    """A mirror's inner points lie in the plane of the flank: only height and points outside identify them."""
    flank = np.stack([np.linspace(10, 14, 41), np.full(41, 4.0), np.full(41, 0.6)], axis=1)
    high = np.array([[10.6, 4.0, 1.0], [13.6, 4.0, 1.0]])
    mirror = np.array([[12.5, 3.85, 1.0], [12.5, 3.93, 1.0], [12.51, 4.0, 1.0]])
    points = np.concatenate([flank, high, mirror])
    assert np.flatnonzero(link(points).line < 0).tolist() == [43, 44, 45]
    assert np.flatnonzero(link(points[:, :2]).line < 0).tolist() == [43, 44]


def test_curved_sides_are_body():
    """A side less flat than configured widens the gate; a fixed gate would remove its ends or centre."""
    place = np.linspace(0, 4, 60)
    flank = np.stack([10.0 + place, 4.0 + 0.08 * np.sin(np.pi * place / 4)], axis=1)
    assert np.all(link(flank).line == 0)


def test_two_perpendicular_points_are_a_second_face():
    """Cars are rectangular: points perpendicular to a flank's end are a face, even if chance could explain them."""
    flank = np.stack([np.linspace(10, 14, 30), np.full(30, 4.0)], axis=1)
    across = np.array([[9.98, 4.7], [10.01, 5.1]])
    assert link(np.concatenate([flank, across])).line.tolist() == [0] * 30 + [1] * 2


def test_largest_jump_by_hand():
    """Sizes 6, 5, 1, 1 and a minimal sample of 2: the largest jump is from 5 to 2, which gives two lines."""
    points = np.random.default_rng(0).random((13, 2))
    cluster = np.repeat([0, 6, 11, 12], [6, 5, 1, 1])
    np.testing.assert_allclose(
        lines.largest_clusters(points, cluster), [lines.fit_line(points, cluster, name) for name in (0, 6)]
    )


def test_a_segment_depends_on_its_own_points_only():
    """A shared random state would make a car's fit depend on other objects in the frame."""
    first, second = noisy_l(1), noisy_l(2) + 20.0
    single = link(second)
    segments = Segments(label=np.repeat([0, 1], [len(first), len(second)]), count=2)
    together = tlinkage.link(sort_by_segment(np.concatenate([first, second]), segments), LinkageConfig(), LIDAR)
    np.testing.assert_array_equal(together.line[len(first) :], single.line)
    assert together.heading[1] == single.heading[0]


def test_subsampling_keeps_the_result():
    """All points refine the lines of the subset: without that, 60 of 6000 points would leave 0.3 degrees."""
    linkage = link(ranged(l_shape(0.4, step=0.001), np.random.default_rng(5)))
    assert abs(off_quarter(linkage.heading[0], 0.4)) < 0.05
    assert np.mean(linkage.line >= 0) > 0.99


@pytest.mark.parametrize(
    "points",
    [
        np.array([[5.0, 5.0]]),
        np.array([[5.0, 5.0], [6.0, 5.0]]),
        np.full((30, 2), 7.0),
        np.stack([np.linspace(5, 9, 30), np.full(30, 3.0)], axis=1),
        np.repeat([[5.0, 5.0], [9.0, 5.0]], 10, axis=0),
        np.random.default_rng(0).normal(10.0, 0.5, (100_000, 2)),
    ],
    ids=["one", "two", "identical", "collinear", "two places", "many"],
)
def test_degenerate_segments_have_a_dominant_line(points):
    linkage = link(points)
    assert np.isfinite(linkage.heading[0])
    assert np.any(linkage.line == 0)


def test_no_segment():
    linkage = tlinkage.link(sort_by_segment(np.ones((3, 3)), Segments(np.full(3, -1), 0)), LinkageConfig(), LIDAR)
    assert linkage.line.tolist() == [-1, -1, -1]
    assert linkage.heading.shape == (0,)


@pytest.mark.parametrize("values", [{"tau_m": 0.0}, {"points_max": 1}])
def test_invalid_settings_are_rejected_by_name(values):
    with pytest.raises(ValueError, match=next(iter(values))):
        LinkageConfig(**values)
