import math

import numpy as np
import pytest
import shapely
from hypothesis import example, given
from hypothesis import strategies as st
from support import naive_grading as naive
from support.frames import compose, express

from luxloop.scenarios.grading.plane_geometry import (
    CORNER_SIGNS,
    QUARTER,
    corner,
    into_frame,
    iou,
    iou_table,
    matching_sign,
    nearest_sign,
    out_of_frame,
    wrap,
)

angle = st.floats(-20.0, 20.0)
coordinate = st.floats(-60.0, 60.0)
pose = st.tuples(coordinate, coordinate, angle)
# Sizes of road users; the boxes are close enough to overlap often.
box = st.tuples(st.floats(-3, 3), st.floats(-3, 3), angle, st.floats(0.3, 18.0), st.floats(0.2, 3.0))
sign = st.tuples(st.sampled_from((-1, 1)), st.sampled_from((-1, 1)))


NESTED = (3.0, 0.0, -10.828246529251524, 2.0, 3.0), (3.0, 0.0, -10.828246529251524, 0.5, 3.0)
"""Boxes with nearly collinear edges."""


def one_iou(a, b):
    return float(iou(np.array([a], dtype=float), np.array([b], dtype=float))[0])


@pytest.mark.parametrize(
    ("a", "b", "expected"),
    [
        ((0, 0, 0, 1, 1), (0.5, 0, 0, 1, 1), 1 / 3),
        ((0, 0, 0, 1, 1), (0.5, 0.5, 0, 1, 1), 0.25 / 1.75),
        # A square and itself turned by 45 degrees share a regular octagon of area 2 (sqrt 2 - 1).
        ((0, 0, 0, 1, 1), (0, 0, math.pi / 4, 1, 1), 0.8284271 / (2 - 0.8284271)),
        ((0, 0, 0, 2, 2), (0, 0, 0.3, 1, 1), 0.25),
        ((0, 0, 0, 4, 2), (0, 0, QUARTER, 2, 4), 1.0),
        ((0, 0, 0, 1, 1), (1.0, 0, 0, 1, 1), 0.0),
        ((0, 0, 0, 4, 0), (0, 0, 0, 4, 2), 0.0),
        ((0, 0, math.nan, 4, 2), (0, 0, 0, 4, 2), 0.0),
    ],
)
def test_iou_of_boxes_computed_by_hand(a, b, expected):
    assert one_iou(a, b) == pytest.approx(expected, abs=1e-7)


@given(box, box)
@example(*NESTED)
@example(*NESTED[::-1])
def test_iou_equals_polygon_clipping_and_is_a_symmetric_fraction(a, b):
    value = one_iou(a, b)
    assert value == pytest.approx(naive.iou(a, b), abs=1e-6)
    assert value == pytest.approx(one_iou(b, a), abs=1e-9)
    assert 0.0 <= value <= 1.0


def test_iou_equals_that_of_geos():
    """Boxes of road users up to 60 m away, as the grader compares them."""
    rng = np.random.default_rng(1)
    place = rng.uniform(-60.0, 60.0, (2000, 2))
    heading, size = rng.uniform(-9.0, 9.0, (2, 2000)), rng.uniform(0.3, 9.0, (2, 2000, 2))
    a, b = (np.column_stack([place + rng.normal(0.0, 1.5, (2000, 2)), heading[k], size[k]]) for k in range(2))
    one, other = (shapely.polygons(corner(boxes[:, None], CORNER_SIGNS)) for boxes in (a, b))
    shared = shapely.area(shapely.intersection(one, other))
    expected = shared / (a[:, 3] * a[:, 4] + b[:, 3] * b[:, 4] - shared)
    assert np.count_nonzero(expected) > 1000
    np.testing.assert_allclose(iou(a, b), expected, rtol=0.0, atol=1e-12)


@given(box, st.integers(-5, 5), st.tuples(st.floats(-3, 3), st.floats(-3, 3)), st.floats(0.2, 1.0))
def test_iou_of_boxes_with_quarter_turns_equals_polygon_clipping(first, quarters, offset, part):
    """Fails when length and width of a perpendicular box are confused, or a small rotation counts as parallel."""
    x, y, yaw, length, width = first
    second = (x + offset[0], y + offset[1], yaw + quarters * QUARTER, part * length, width)
    assert one_iou(first, second) == pytest.approx(naive.iou(first, second), abs=1e-6)
    beyond = (*second[:2], second[2] + 1e-3, *second[3:])
    assert one_iou(first, beyond) == pytest.approx(naive.iou(first, beyond), abs=1e-6)


@given(box, box, pose)
def test_iou_does_not_depend_on_the_frame(a, b, frame):
    moved = [(*compose(frame, x[:3]), *x[3:]) for x in (a, b)]
    assert one_iou(*moved) == pytest.approx(one_iou(a, b), abs=1e-6)


@given(st.lists(box, max_size=5), st.lists(box, max_size=5))
def test_overlap_table_equals_pairwise_overlaps(a, b):
    table = iou_table(np.array(a).reshape(-1, 5), np.array(b).reshape(-1, 5))
    expected = [[naive.iou(x, y) for y in b] for x in a]
    np.testing.assert_allclose(table, np.array(expected).reshape(len(a), len(b)), atol=1e-6)


@given(angle, st.integers(-5, 5), st.sampled_from((QUARTER, math.tau)))
def test_wrapped_angles_are_equivalent_and_within_half_a_period(value, turns, period):
    wrapped = float(wrap(np.array(value + turns * period), period))
    assert abs(wrapped) <= period / 2 + 1e-12
    assert math.remainder(wrapped - value, period) == pytest.approx(0.0, abs=1e-9)


def test_half_a_period_wraps_to_the_positive_end():
    assert wrap(np.array([-math.pi, math.pi])).tolist() == [math.pi, math.pi]
    assert wrap(np.array([-QUARTER / 2]), QUARTER).tolist() == [QUARTER / 2]


@given(pose, pose)
def test_frame_transforms_equal_complex_numbers_and_are_inverse(frame, other):
    poses, frame = np.array([other]), np.array(frame)
    inside = into_frame(poses, frame)
    np.testing.assert_allclose(inside[0, :2], express(frame, other)[:2], atol=1e-9)
    back = out_of_frame(inside, frame)
    np.testing.assert_allclose(back[0, :2], other[:2], atol=1e-9)
    assert math.remainder(back[0, 2] - other[2], math.tau) == pytest.approx(0.0, abs=1e-9)


@given(box)
def test_nearest_corner_has_the_least_distance(box):
    boxes = np.array([box])
    corners = naive.corners(box)
    nearest = complex(*corner(boxes, nearest_sign(boxes))[0])
    assert abs(nearest) == pytest.approx(min(map(abs, corners)), abs=1e-9)


@given(box, sign, st.integers(-4, 4), st.floats(-0.7, 0.7))
def test_matching_sign_gives_the_same_corner_for_another_front(box, named, quarters, error):
    x, y, yaw, length, width = box
    # The same rectangle with another side as its front, then turned by a small error.
    size = (width, length) if quarters % 2 else (length, width)
    exact = np.array([(x, y, yaw + quarters * QUARTER, *size)])
    sign = np.array([named])
    same = matching_sign(sign, np.array([quarters * QUARTER + error]))
    np.testing.assert_allclose(corner(np.array([box]), same), corner(exact, sign), atol=1e-9)
