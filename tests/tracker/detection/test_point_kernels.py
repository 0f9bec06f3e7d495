"""Kernels on points and groups of points equal their references."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from support import naive_points as naive

from luxloop.tracker.detection.background import contained
from luxloop.tracker.detection.boxes import box_points
from luxloop.tracker.detection.point_groups import by_group, by_key, by_number, even_subset, extents_along, means
from luxloop.tracker.detection.preprocess import kept_points
from luxloop.tracker.detection.truncation import truncated_points

seeds = st.integers(0, 10_000)


def labelled(seed, count=60, groups=4):
    """Return points (count, 2) and their groups, all with points; some points are in none."""
    rng = np.random.default_rng(seed)
    label = np.concatenate([np.arange(groups), rng.integers(-1, groups, count - groups)])
    return rng.normal(5.0, 3.0, (count, 2)), rng.permutation(label)


@given(st.lists(st.integers(-1, 4), max_size=40))
def test_order_by_group_equals_the_reference(label):
    """Groups may be empty."""
    for ours, twin in zip(by_group(np.array(label, int), 5), naive.by_group(np.array(label, int), 5), strict=True):
        np.testing.assert_array_equal(ours, twin)


@given(seeds)
def test_order_by_key_within_groups_equals_that_of_numpy(seed):
    """Keys are equal or in ascending runs, as those of the layers of a scan; groups may be empty."""
    rng = np.random.default_rng(seed)
    offset = np.append(0, np.cumsum(rng.integers(0, 60, 6) * rng.integers(0, 2, 6)))
    group = np.repeat(np.arange(6), np.diff(offset))
    key = np.where(group % 2, rng.integers(0, 9, len(group)), np.arange(len(group)) % 13).astype(float)
    np.testing.assert_array_equal(by_key(key, offset), np.lexsort((key, group)))


@given(st.lists(st.integers(-4, 4) | st.integers(-(10**15), 10**15)), st.randoms())
def test_order_by_number_is_stable(number, random):
    order = random.sample(range(len(number)), len(number))
    assert by_number(np.array(number, np.int64), np.array(order, np.int64)).tolist() == sorted(
        order, key=lambda i: number[i]
    )


@given(seeds)
def test_means_and_extents_equal_the_reference(seed):
    points, label = labelled(seed)
    directions = np.array([[1.0, 0.0], [0.6, 0.8], [0.0, 1.0]])
    np.testing.assert_allclose(means(points, label, 4), naive.means(points, label, 4))
    twin = naive.extents_along(points, label, 4, directions)
    np.testing.assert_allclose(extents_along(points, label, 4, directions), twin)


@given(st.lists(st.integers(-5, 5)), st.sets(st.integers(-5, 5)))
def test_contained_cells_equal_those_of_a_set(cells, known):
    found = contained(np.array(cells, np.int64), np.array(sorted(known), np.int64))
    assert found.tolist() == [cell in known for cell in cells]


@given(seeds)
def test_kept_points_equal_the_reference(seed):
    """About half of the points break one of the conditions."""
    rng = np.random.default_rng(seed)
    points, time = rng.normal(0.0, (20.0, 3.0, 1.0), (80, 3)), rng.normal(size=80)
    points[rng.random((80, 3)) < 0.03], time[rng.random(80) < 0.05] = np.nan, np.inf
    limits = (rng.integers(0, 16, 80), 0b1000, 30.0, np.array([2.5, 1.0]))
    np.testing.assert_array_equal(kept_points(points, time, *limits), naive.kept_points(points, time, *limits))


@given(seeds)
def test_box_points_equal_the_reference(seed):
    rng = np.random.default_rng(seed)
    points, label = labelled(seed)
    of_points = (rng.random(60) < 0.5, rng.random(60) < 0.3, rng.normal(size=60), rng.normal(size=(60, 2)))
    center, heading, size = rng.normal(5.0, 1.0, (4, 2)), rng.uniform(0.0, 1.5, 4), rng.uniform(0.5, 8.0, (4, 2))
    order, start = by_group(label, 4)
    spans = np.stack([start[:-1], start[1:]], axis=1)
    by_box = (values.take(order, axis=0) for values in (points, *of_points))
    found = box_points(*by_box, spans, (center, heading, size), 0.3)
    for b in range(4):
        box = center[b], heading[b], size[b]
        twin = naive.box_points(points, *of_points, np.flatnonzero(label == b), *box, 0.3)
        for ours, expected in zip(found, twin, strict=True):
            np.testing.assert_allclose(ours[b], expected, atol=1e-12)


@given(seeds, st.booleans())
def test_truncated_points_equal_the_reference(seed, known):
    """Two channels of beams 1 s apart, some lost, on two segments with ranges that differ by the limit or more."""
    rng = np.random.default_rng(seed)
    channel, time = rng.integers(0, 2, 40), rng.permutation(40).astype(float)
    range_m, label = rng.integers(5, 12, 40).astype(float), rng.integers(0, 2, 40)
    limits = np.array([[0.0, 39.0], [3.0, 30.0]]) if known else np.empty((0, 2))
    found = truncated_points(np.lexsort((time, channel)), channel, time, range_m, label, limits, 2.0, 2.0)
    twin = naive.truncated_points(channel, time, range_m, label, limits, 2.0, 2.0)
    np.testing.assert_array_equal(found, twin)


@pytest.mark.parametrize("turn", [0.0, np.pi / 2, np.pi, -np.pi / 2])
def test_even_subset_does_not_depend_on_the_direction_of_the_segment(turn):
    """Ten points from right to left, also behind the ego, where bearings jump from pi to -pi."""
    x, y, cos, sin = 10.0, np.arange(10) - 4.5, np.cos(turn), np.sin(turn)
    points = np.stack([cos * x - sin * y, sin * x + cos * y], 1)
    chosen, first = even_subset(points, np.array([0, 10]), 3)
    assert (chosen.tolist(), first.tolist()) == ([0, 3, 6], [0, 3])
