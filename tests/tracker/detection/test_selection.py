"""Selection among candidates, and its accuracy compared with each method."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from support import naive_fit
from support.shapes import Car, l_shape, rotation, scan_car
from support.stages import as_one_segment, fit_points, off_quarter, one_segment

from luxloop.tracker.detection import alignment, selection
from luxloop.tracker.detection.segmentation import sort_by_segment
from luxloop.tracker.detection.selection import SelectionConfig
from luxloop.tracker.records import METHODS, Linkage, Segments


def choose(points, line, headings, variant="alignment"):
    """Select among headings."""
    linkage = Linkage(np.asarray(line), np.array([headings[-1]]))
    return selection.select(
        as_one_segment(points), linkage, np.array([headings]), SelectionConfig(variant=variant), 0.027
    )


def misalignment(points, heading, ray=(1.0, 0.0)):
    return alignment.misalignment(
        points, heading, np.array(ray), 0.08, 0.03, np.empty(len(points)), np.empty(len(points))
    )


def test_costs_by_hand():
    """Four points at 0.04 m to either side of a line: all absolute residuals are 0.04, so (3) is 0.

    Seen face on, sides are hypot(0.08, 0.03) sharp. Each point has one other beside it, which counts 1, and two 0.08 m
    off, which count (1 - 64 / 73)^2, give or take what the bins smooth. A quarter turn must change nothing.
    """
    points = np.array([[10.04, -1.5], [9.96, -0.5], [10.04, 0.5], [9.96, 1.5]])
    expected = -np.log(1.0 + 0.08 / np.hypot(0.08, 0.03) * (1.0 + 2.0 * (9.0 / 73.0) ** 2))
    for heading in (0.0, np.pi / 2):
        assert choose(points, [0] * 4, [heading] * 4, "paper").cost[0, 0] == pytest.approx(0.0, abs=1e-12)
        assert choose(points, [0] * 4, [heading] * 4).cost[0, 0] == pytest.approx(expected, rel=0.04)


def test_range_noise_has_little_effect_at_grazing_incidence():
    """Two points 0.04 m apart: half the kernel radius at normal incidence, more than that at grazing incidence."""
    points = np.array([[10.0, 0.0], [12.0, 0.04]])
    assert misalignment(points, 0.0, ray=(1.0, 0.0)) == pytest.approx(0.0, abs=1e-12)
    assert misalignment(points, 0.0, ray=(0.0, 1.0)) < -0.4


def test_a_point_at_half_the_kernel_radius_counts_nine_sixteenths():
    """(1 - (1/2)^2)^2 by the kernel, at the nodes of the bins, where the estimate is exact."""
    assert local_density(np.array([0.0, 0.04, 4.0])) == pytest.approx([0.5625, 0.5625, 0.0])


def local_density(place):
    out = np.empty(len(place))
    alignment.local_density(place, 0.08, out)
    return out


def test_equation_3_by_hand():
    """Residuals -0.3, 0.1, 0.3, -0.1 about the middle: variance of {0.3, 0.1, 0.3, 0.1} is 0.01."""
    points = np.array([[8.0, 2.7], [9.0, 3.1], [10.0, 3.3], [11.0, 2.9]])
    assert choose(points, [0] * 4, [0.0] * 4, "paper").cost[0, 0] == pytest.approx(0.01)


def test_outliers_and_other_lines_do_not_enter_equation_3():
    points = np.concatenate([l_shape(0.0, 4.0, 2.0), [[12.0, 7.0], [13.0, 6.0]]])
    line = np.where(points[:, 1] == 5.0, 0, 1)
    line[-2:] = -1
    assert choose(points, line, [0.0] * 4, "paper").cost[0, 0] == pytest.approx(0.0, abs=1e-12)


def test_a_single_point_does_not_affect_the_choice():
    """A mirror off the side has density 0 at every heading, and adds the same cost to all."""
    points, line = l_shape(0.3), [0] * len(l_shape(0.3))
    mirror = np.concatenate([points, [[12.0, 8.0]]])
    with_mirror, without = choose(mirror, [*line, -1], [0.3] * 4), choose(points, line, [0.3] * 4)
    assert with_mirror.cost[0, 0] * len(mirror) == pytest.approx(without.cost[0, 0] * len(points), rel=0.01)
    assert off_quarter(with_mirror.heading[0, -1], 0.3) == pytest.approx(0.0, abs=0.1)


@given(st.integers(0, 10_000), st.integers(1, 60))
def test_local_density_equals_the_reference(seed, count):
    """The bins interpolate the kernel over a quarter of its radius."""
    place = np.random.default_rng(seed).normal(0.0, 0.5, count)
    np.testing.assert_allclose(local_density(place), naive_fit.local_density(place, 0.08, bins=4), atol=1e-9)
    np.testing.assert_allclose(local_density(place), naive_fit.kernel_sum(place, 0.08), atol=0.1 * count**0.5)


@given(st.integers(0, 10_000), st.integers(2, 40), st.floats(0.0, 1.57))
def test_misalignment_equals_the_reference(seed, count, heading):
    points = np.random.default_rng(seed).normal((20.0, 5.0), (2.0, 0.3), (count, 2))
    ray = np.array([0.6, 0.8])
    twin = naive_fit.misalignment(points, heading, ray, 0.08, 0.03, bins=4)
    assert misalignment(points, heading, ray) == pytest.approx(twin)


@pytest.mark.parametrize("error_deg", [-3.5, -1.0, 0.2, 2.5])
def test_the_best_candidate_is_refined_to_the_minimum(error_deg):
    """From an error of 3.5 degrees, among worse candidates, which stay unchanged."""
    rng = np.random.default_rng(1)
    points = l_shape(0.7, step=0.1)
    points += rng.normal(0.0, 0.01, points.shape)
    headings = 0.7 + np.deg2rad([20.0, error_deg, 40.0, -25.0])
    found = choose(points, [0] * len(points), headings)
    assert METHODS[found.best[0]] == "refined"
    assert abs(off_quarter(found.heading[0, -1], 0.7)) < 0.1
    np.testing.assert_array_equal(found.heading[0, :-1], headings)
    fine = 0.7 + np.deg2rad(np.arange(-5.0, 5.0, 0.02))
    ray = points.mean(axis=0) / np.linalg.norm(points.mean(axis=0))
    least = min(naive_fit.misalignment(points, heading, ray, 0.08, 0.03, bins=4) for heading in fine)
    assert found.cost[0, -1] == pytest.approx(least, abs=0.02)


def test_the_paper_variant_refines_no_heading():
    points = l_shape(0.7)
    headings = [0.72, 0.705, 1.0, 1.2]
    found = choose(points, [0] * len(points), headings, "paper")
    assert found.heading[0, -1] == headings[found.best[0]]
    assert METHODS[found.best[0]] != "refined"


@given(st.integers(0, 10_000), st.integers(1, 30), st.lists(st.floats(0.0, 1.57), min_size=4, max_size=4))
def test_distances_equal_the_reference(seed, count, headings):
    rng = np.random.default_rng(seed)
    lines = [rng.normal((20.0, 5.0), (2.0, 0.3), (n, 2)) @ rotation(0.3).T for n in (count, 7)]
    ours = selection.side_distances(np.concatenate(lines), np.array([0, count, count + 7]), np.array([headings] * 2))
    twin = [[naive_fit.side_distances(points, heading) for heading in headings] for points in lines]
    np.testing.assert_allclose(ours, np.concatenate([np.transpose(block) for block in twin]), atol=1e-9)


@given(st.permutations([0.0, 3.0, 20.0, 44.0]), st.floats(0.0, 1.5))
def test_the_true_heading_is_chosen_at_any_position(errors_deg, truth):
    points = l_shape(truth)
    corner = np.linalg.norm(points - [10.0, 5.0], axis=1) < 1e-9
    line = np.where((points - [10.0, 5.0]) @ rotation(truth)[:, 1] < 1e-9, 0, 1)
    line[corner] = 0
    for variant in ("alignment", "paper"):
        best = choose(points, line, truth + np.deg2rad(errors_deg), variant).best[0]
        assert errors_deg[best] == 0.0


def test_a_side_outweighs_a_curved_bumper():
    """40 points on a curved rear, 12 on a long side: (3) follows the curve, alignment follows the side."""
    across = np.linspace(-0.8, 0.8, 40)
    rear = np.stack([10.0 - 0.03 * across - 0.02 * across**2, across], axis=1)  # leans by 1.7 degrees
    side = np.stack([np.linspace(10.0, 14.5, 12), np.full(12, 0.9)], axis=1)
    points, line = np.concatenate([rear, side]), np.repeat([0, 1], [40, 12])
    headings = [0.0, 0.03, 0.2, 0.5]
    assert choose(points, line, headings, "paper").best[0] == 1
    found = choose(points, line, headings)
    assert found.cost[0, 0] < found.cost[0, 1]
    assert abs(off_quarter(found.heading[0, -1], 0.0)) < 0.6


def test_a_window_line_improves_the_heading_and_interior_points_do_not_bias_it():
    """Half of the points lie on a window line 0.15 m behind the side, a tenth inside: no single line contains all."""
    rng = np.random.default_rng(5)
    side = np.stack([np.linspace(10.0, 14.0, 20), np.full(20, 5.0)], axis=1)
    points = np.concatenate([side, side + np.array([0.0, 0.15]), rng.uniform([10.0, 5.2], [14.0, 6.5], (4, 2))])
    points += rng.normal(0.0, 0.02, points.shape)
    found = choose(points, [0] * len(points), np.deg2rad([2.1, 1.0, 30.0, 45.0]))
    assert abs(off_quarter(found.heading[0, -1], 0.0)) < 0.5


@pytest.fixture(
    scope="module",
    params=[pytest.param(("alignment", 1 / 32), marks=pytest.mark.slow), ("posterior", 0.15)],
    ids=["alignment", "posterior"],
)
def errors_deg(request):
    """Absolute heading errors (300, 5) by method and (300,) of the selection, on L-shape views of noisy cars.

    With them the allowed loss on the linkage.
    """
    choice = SelectionConfig(variant=request.param[0])
    rng = np.random.default_rng(11)
    every, best = [], []
    while len(best) < 300:
        distance, bearing, heading = rng.uniform(8, 40), rng.uniform(-np.pi, np.pi), rng.uniform(0, np.pi)
        if abs(off_quarter(heading, bearing)) < 10.0:
            continue  # a single side
        car = Car(
            center=(distance * np.cos(bearing), distance * np.sin(bearing)),
            heading=heading,
            mirrors=rng.random() < 0.5,
            window_depth=rng.uniform(0.85, 1.45) * (rng.random() < 0.4),
        )
        points, _ = scan_car(car, rng)
        found = fit_points(points, segments=one_segment(len(points)), choice=choice).candidates
        error = np.abs(off_quarter(found.heading[0], heading))
        every.append(error)
        best.append(error[found.best[0]])
    return np.array(every), np.array(best), request.param[1]


def test_best_selection_beats_the_searches_and_equals_the_linkage(errors_deg):
    """Table 2 of the paper: mean absolute error area 12.3, closeness 2.0, variance 1.5, T-linkage 1.6, best 1.35.

    Our linkage proposes faces, not the paper's lines: on straight faces there is nothing left to gain on it, as both
    rest on the same points. There alignment loses less than the last step of its refinement, 1/32 degree. The mean
    of all headings is that of a grid, and loses less than 0.15 degrees.
    """
    every, best, loss_max_deg = errors_deg
    mean = dict(zip(METHODS, every.mean(axis=0), strict=True))
    assert best.mean() < 0.8 * min(mean[method] for method in ("area", "closeness", "variance"))
    assert best.mean() - mean["tlinkage"] < loss_max_deg
    assert mean["area"] > 3.0 * max(mean["closeness"], mean["variance"], mean["tlinkage"])
    assert best.mean() < 0.5 * mean["variance"]
    assert np.mean(best <= 2.0) > 0.99
    assert best.max() < 5.0, "the paper: selection removes the errors beyond 6 degrees"


def test_the_refined_rectangle_is_measured_along_its_heading():
    points = l_shape(0.7, length=4.0, width=2.0)
    found = choose(points, [0] * len(points), [0.71, 0.72, 0.9, 1.2])
    np.testing.assert_allclose(found.size[0, -1], [4.0, 2.0], atol=0.02)
    np.testing.assert_allclose(found.center_ego[0, -1], [10.0, 5.0] + rotation(0.7) @ [2.0, 1.0], atol=0.02)


def test_an_unknown_variant_is_rejected():
    with pytest.raises(ValueError, match='variant is "best"; give'):
        SelectionConfig(variant="best")


@pytest.mark.parametrize("variant", ["posterior", "alignment", "paper"])
def test_no_segment(variant):
    points = sort_by_segment(np.ones((3, 2)), Segments(np.full(3, -1), 0))
    linkage = Linkage(np.full(3, -1), np.empty(0))
    found = selection.select(points, linkage, np.empty((0, 4)), SelectionConfig(variant=variant), 0.027)
    assert found.heading.shape == found.cost.shape == (0, len(METHODS))
    assert found.size.shape == (0, len(METHODS), 2)
    assert found.heading_variance is None or (variant == "posterior" and found.heading_variance.shape == (0,))


@pytest.mark.parametrize("variant", ["alignment", "paper"])
def test_selected_candidates_state_no_variance(variant):
    points = l_shape(0.7)
    assert choose(points, [0] * len(points), [0.7, 0.72, 0.9, 1.2], variant).heading_variance is None


def test_the_mean_heading_is_always_selected():
    """It is compared with no candidate."""
    points = l_shape(0.7, step=0.1)
    found = choose(points, [0] * len(points), [0.2, 0.4, 0.9, 1.2], "posterior")
    assert METHODS[found.best[0]] == "refined"
    assert abs(off_quarter(found.heading[0, -1], 0.7)) < 0.3
    assert np.isnan(found.cost).all()
    assert found.heading_variance.shape == (1,)
