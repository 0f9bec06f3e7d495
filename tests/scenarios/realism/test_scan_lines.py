"""Bow, noise and distance of scan lines, on arcs and planes of known shape."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from support.labelled_shapes import ABREAST, left, rear, vehicle

from luxloop.scenarios.realism.vehicle_figures import layers_apart, lines_over, parabola, visible_faces

ALONG = np.linspace(-0.75, 0.75, 31)
FLANK_ALONG = np.linspace(-1.6, 1.6, 41)


def arc(along, half_m, sagitta_m):
    """Depth behind the middle of a circle with a sagitta over +-half_m."""
    radius = 0.5 * (half_m**2 + sagitta_m**2) / sagitta_m
    return radius - np.sqrt(radius**2 - along**2)


def only_line(points, **keys):
    seen = vehicle(points, **keys)
    (face,) = visible_faces(seen)
    (line,) = lines_over(face, seen.line, seen.points_ego[:, 2])
    return line


@pytest.mark.parametrize("sagitta_m", [0.05, 0.165, 0.237])
def test_a_round_rear_has_the_bow_of_its_circle(sagitta_m):
    """A parabola fitted to a circle has its sagitta within 3 %, as (s / half)^2 / 4 is at most 2.5 %."""
    line = only_line(rear(arc(ALONG, 0.75, sagitta_m), ALONG), height=0.6)
    assert line.bow_m == pytest.approx(sagitta_m, rel=0.03)
    assert line.height_m == pytest.approx(0.6)


def test_a_round_flank_is_measured_over_its_own_width():
    line = only_line(left(arc(FLANK_ALONG, 1.6, 0.07), FLANK_ALONG), lidars=[ABREAST])
    assert line.bow_m == pytest.approx(0.07, rel=0.01)


def test_a_hollow_face_has_a_negative_bow():
    assert only_line(rear(0.2 - arc(ALONG, 0.75, 0.1), ALONG)).bow_m == pytest.approx(-0.1, rel=0.02)


@given(*[st.floats(-0.5, 0.5)] * 3)
def test_a_parabola_is_recovered_exactly(sagitta, slope, offset):
    depth = sagitta * (ALONG / 0.75) ** 2 + slope * ALONG + offset
    assert parabola(ALONG, depth, 0.75) == pytest.approx((sagitta, 0.0), abs=1e-9)


def test_noise_is_that_of_the_points():
    """With 2000 points a standard deviation is known to 1.6 %; 3 sigma of the normal distribution are cut, 1.4 %."""
    along = np.linspace(-0.75, 0.75, 2000)
    depth = 0.16 * (along / 0.75) ** 2 + np.random.default_rng(5).normal(0.0, 0.03, len(along))
    bow, noise = parabola(along, depth, 0.75)
    assert noise == pytest.approx(0.03, rel=0.06)
    assert bow == pytest.approx(0.16, abs=0.006)


def test_an_outlier_changes_neither_bow_nor_noise():
    ripple = 0.01 * np.where(np.arange(31) % 2, 1.0, -1.0)
    clean = parabola(ALONG, 0.16 * (ALONG / 0.75) ** 2 + ripple, 0.75)
    spoilt = 0.16 * (ALONG / 0.75) ** 2 + ripple
    spoilt[10] += 0.5
    assert parabola(ALONG, spoilt, 0.75) == pytest.approx(clean, abs=0.004)


@pytest.mark.parametrize(
    ("along", "lines"),
    [
        (np.linspace(-0.5, 0.5, 7), 1),
        (np.linspace(-0.5, 0.5, 6), 0),  # six points
        (np.linspace(-0.49, 0.5, 20), 0),  # 99 cm
        (np.linspace(-0.85, 0.14, 20), 0),  # 89 cm of it within 75 cm of the middle
    ],
)
def test_a_line_over_an_end_has_seven_points_over_a_metre(along, lines):
    seen = vehicle(rear(0.0, along))
    (face,) = visible_faces(seen)
    assert len(lines_over(face, seen.line, seen.points_ego[:, 2])) == lines


@pytest.mark.parametrize(("half_m", "lines"), [(1.0, 1), (0.99, 0)])
def test_a_line_over_a_flank_spans_two_metres(half_m, lines):
    seen = vehicle(left(0.0, np.linspace(-half_m, half_m, 21)), lidars=[ABREAST])
    (face,) = visible_faces(seen)
    assert len(lines_over(face, seen.line, seen.points_ego[:, 2])) == lines


def test_scan_lines_are_fitted_one_by_one():
    """Two lines of different bow and height, 20 cm apart."""
    points = np.concatenate([rear(arc(ALONG, 0.75, 0.1), ALONG), rear(0.2 + arc(ALONG, 0.75, 0.2), ALONG)])
    seen = vehicle(points, line=np.repeat([3, 8], 31), height=np.repeat([0.3, 0.9], 31))
    (face,) = visible_faces(seen)
    lines = lines_over(face, seen.line, seen.points_ego[:, 2])
    np.testing.assert_allclose([line.bow_m for line in lines], [0.1, 0.2], rtol=0.03)
    np.testing.assert_allclose([line.height_m for line in lines], [0.3, 0.9])


def apart(points, line, lidar=(-20.0, 0.0)):
    seen = vehicle(points, line=line, lidars=[lidar])
    (face,) = visible_faces(seen)
    return layers_apart(face, seen.line)


def test_distance_of_planes_is_the_distance_of_layers():
    middle = np.linspace(-0.4, 0.4, 9)
    points = np.concatenate([rear(depth, middle) for depth in (0.0, 0.1, 0.32)])
    assert apart(points, np.repeat([0, 1, 2], 9)) == pytest.approx(0.32)


def test_only_the_middle_of_a_face_counts():
    """The second line is 50 cm deeper outside +-45 cm, as a rounded corner is."""
    wide = np.linspace(-0.8, 0.8, 33)
    corner = np.where(np.abs(wide) > 0.45, 0.5, 0.1)
    points = np.concatenate([rear(0.0, wide), rear(corner, wide)])
    assert apart(points, np.repeat([0, 1], 33)) == pytest.approx(0.1)


@pytest.mark.parametrize(("deeper_m", "expected"), [(1.1, 1.1), (1.3, np.nan)])
def test_layers_far_behind_an_end_do_not_count(deeper_m, expected):
    """A windscreen 1.3 m behind the bumper is no part of the front; a hood 1.1 m behind is."""
    middle = np.linspace(-0.4, 0.4, 9)
    points = np.concatenate([rear(0.0, middle), rear(deeper_m, middle)])
    assert apart(points, np.repeat([0, 1], 9)) == pytest.approx(expected, nan_ok=True)


def test_layers_behind_a_flank_end_at_sixty_centimetres():
    middle = np.linspace(-1.0, 1.0, 9)
    for deeper_m, expected in ((0.5, 0.5), (0.7, np.nan)):
        points = np.concatenate([left(0.0, middle), left(deeper_m, middle)])
        assert apart(points, np.repeat([0, 1], 9), ABREAST) == pytest.approx(expected, nan_ok=True)


def test_a_single_line_has_no_distance():
    assert np.isnan(apart(rear(0.0, np.linspace(-0.4, 0.4, 9)), 0))


@pytest.mark.parametrize(("depth_m", "on_line"), [(0.28, True), (0.32, False)])
def test_points_through_a_window_are_not_on_the_line_of_a_flank(depth_m, on_line):
    """Every second point is deeper, so that no robust fit removes it: noise is half the depth, or none."""
    depth = np.where(np.arange(49) % 2, 0.0, depth_m)
    line = only_line(left(depth, np.linspace(-1.25, 1.25, 49)), lidars=[ABREAST])
    assert line.noise_m == pytest.approx(0.5 * depth_m if on_line else 0.0, rel=0.01, abs=1e-9)


def test_a_hood_is_on_the_line_of_an_end():
    depth = np.where(np.arange(29) % 2, 0.0, 1.1)
    assert only_line(rear(depth, np.linspace(-0.7, 0.7, 29))).noise_m == pytest.approx(0.55, rel=0.01)
