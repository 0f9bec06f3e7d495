"""Likelihoods of visible sides, against densities computed by hand."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from luxloop.tracker import vehicle_classes
from luxloop.tracker.vehicle_classes import CLASSES, PIECE_LOG_ODDS_MAX, class_log_odds, length_log_odds

VISIBLE_MIN_M = 0.6
WHOLE, CUT = (True, True), (False, False)

extents = st.floats(0.0, 60.0)
sides = st.tuples(extents, extents)
masks = st.tuples(st.booleans(), st.booleans())
shares = st.floats(0.0, 1.0)


def length(size, whole=WHOLE, truncated=0.0):
    """Return the log-odds that the first side is the length."""
    return length_log_odds(np.array(size), np.array(whole), VISIBLE_MIN_M, truncated)


def vehicle(size, whole=WHOLE, truncated=0.3):
    """Return the log-odds of a vehicle of any class."""
    odds = np.exp(class_log_odds(np.array(size), np.array(whole), truncated))
    return math.log(np.dot([kind.share for kind in CLASSES], odds))


def test_a_whole_side_of_4_2_m_is_a_length():
    """Cars have 1 / (5.3 - 3.4) = 0.526316 per metre of length there, and no class has such a width: 0.6 x 0.527316 +
    0.4 x 0.001 = 0.316790 against 0.001."""
    assert length((4.2, 0.1)) == pytest.approx(math.log(316.790), abs=1e-4)


def test_a_side_of_4_2_m_may_be_the_piece_of_a_longer_one():
    """Truncated with 0.3: cars 0.7 / 1.9 + 0.3 ln(5.3 / 4.2) / 1.9 = 0.405151, vans 0.3 ln(6.3 / 5.1) / 1.2 = 0.052827,
    lorries 0.3 ln(18.9 / 5.1) / 13.8 = 0.028477; 0.6 x 0.406151 + 0.1 x 0.053827 + 0.25 x 0.029477 + 0.05 x 0.001 =
    0.256493 against 0.001."""
    assert length((4.2, 0.1), truncated=0.3) == pytest.approx(math.log(256.493), abs=1e-4)


def test_a_whole_side_of_1_7_m_is_a_width():
    """Widths of cars have 1 / 0.65 there; of the 0.4 m that rounding may hide, 0.25 m are in the range of vans: 0.625 /
    0.4. 0.6 x 1.539462 + 0.1 x 1.5635 + 0.3 x 0.001 = 1.080327. As a length it is a motorcycle's, with 0.3 m in its
    range: 0.05 x (0.75 / 0.8 + 0.001) + 0.95 x 0.001 = 0.047875."""
    assert length((1.7, 0.1)) == pytest.approx(-math.log(1.080327 / 0.047875), abs=1e-4)


def test_a_truncated_piece_of_2_m_may_be_either():
    """Lengths: 0.6 x 0.234652 + 0.1 x 0.177091 + 0.25 x 0.095921 + 0.05 x 0.328955 = 0.198928.
    Widths: 0.6 x 0.112262 + 0.1 x 0.295458 + 0.25 x 0.415868 + 0.05 x 0.001 = 0.200920."""
    assert length((2.0, 0.1), CUT) == pytest.approx(math.log(0.198928 / 0.200920), abs=1e-4)


def test_a_side_that_may_face_away_contains_no_information():
    assert length((0.59, 0.59)) == 0.0
    assert length((4.2, 0.59)) == length((4.2, 0.0))


@pytest.mark.parametrize(
    ("size", "whole", "likelier"),
    [
        ((0.1, 2.4), WHOLE, "width"),  # the rear of a lorry
        ((0.1, 2.4), CUT, "length"),  # a car's side between two occluders
        ((0.1, 3.1), WHOLE, "length"),  # no vehicle is that wide
        ((0.1, 3.1), CUT, "length"),
        ((4.5, 1.7), WHOLE, "sides"),
        ((2.2, 1.7), CUT, "sides"),
        ((12.0, 2.5), WHOLE, "sides"),
    ],
)
def test_the_likelier_name_of_a_side(size, whole, likelier):
    """The second side as "width" or "length", or both "sides" as length and width in this order."""
    assert (length(size, whole, 0.3) > 0.0) == (likelier != "length")


def test_evidence_of_a_flat_side_for_each_class():
    """4.2 m, 2 cm deep, with exp(-4 / 3) / 0.015 = 17.573142 for points on a line.

    Cars: 0.1 x 17.573142 + 0.9 x 0.02 / 0.22^2 exp(-1 / 11) = 2.096897; 0.527316 x (0.14 x 2.096897 + 0.69 x 0.001) +
    0.001 x (0.17 x 2.096897 + 0.69 x 0.001) = 0.155522 per square metre. Vans are longer: 0.001 x
    (0.31 x 2.096897 + 2 x 0.69 x 0.001) = 0.000651. Lorries: 0.5 x 17.573142 + 0.5 exp(-2 / 15) /
    0.15 = 11.703816; 0.001 x (0.5 x 11.703816 + 2 x 0.5 x 0.001) = 0.005853. Motorcycles: 0.001 x (0.4 x 2.096897 + 2 x
    0.6 x 0.001) = 0.000840. Background: 1 / (4.2 ln 40) times 0.55 x 17.573142 + 0.35 exp(-2 / 15) / 0.15 + 0.1 / 2.8 =
    11.743014: 0.757942."""
    found = class_log_odds(np.array([4.2, 0.02]), np.array([True, True]), 0.0)
    assert found == pytest.approx(np.log(np.array([0.155522, 0.000651, 0.005853, 0.000840]) / 0.757942), abs=1e-3)


@pytest.mark.parametrize(
    ("size", "whole", "limited"),
    [
        ((12.0, 2.4), (False, False), True),  # the corner of a building, too
        ((12.0, 2.4), (False, True), False),
        ((9.0, 2.4), (True, False), False),
        ((0.02, 2.4), (False, False), True),  # a piece of a wall, too
        ((0.02, 2.4), (True, False), True),  # the side that faces away is not seen whole
        ((0.02, 2.4), (False, True), False),
    ],
)
def test_a_lorry_without_an_untruncated_side_has_little_evidence(size, whole, limited):
    lorry = 2
    odds = class_log_odds(np.array(size), np.array(whole), 0.0)[lorry]
    assert bool(odds <= PIECE_LOG_ODDS_MAX) is limited


@pytest.mark.parametrize("density", [vehicle_classes.of_car, vehicle_classes.of_lorry], ids=["car", "lorry"])
def test_densities_of_face_depths_have_the_integral_one(density):
    depth = np.linspace(0.0, 5.0, 500_001)
    assert np.trapezoid([density(value) for value in depth], depth) == pytest.approx(1.0, abs=1e-4)


def test_the_set_back_glass_of_a_car_is_no_corner():
    assert vehicle_classes.of_car(0.5) == pytest.approx(0.9 * 0.5 / 0.22**2 * math.exp(-0.5 / 0.22))
    assert vehicle_classes.of_background(0.5) == pytest.approx(0.35 * math.exp(-0.5 / 0.15) / 0.15 + 0.1 / 2.8)
    assert vehicle((4.6, 0.5)) > vehicle((4.6, 0.02)) + 2.0


def test_two_parked_cars_in_a_row_are_no_lorry():
    """9.4 m in plain view: a lorry is as long, but not 1.7 m wide."""
    assert vehicle((9.4, 1.7)) < 0.0 < vehicle((9.4, 2.4))


@pytest.mark.parametrize(
    ("size", "whole", "expected"),
    [
        ((4.6, 1.8), WHOLE, True),
        ((4.6, 1.8), CUT, True),
        ((12.0, 2.5), WHOLE, True),
        ((4.6, 0.2), WHOLE, True),  # a bowed side
        ((1.7, 0.2), WHOLE, True),  # a bowed rear
        ((4.6, 0.02), WHOLE, False),  # flat like a wall
        ((1.7, 0.02), WHOLE, False),
        ((15.0, 0.02), WHOLE, False),
        ((15.0, 0.02), CUT, False),
        ((0.7, 0.1), WHOLE, False),  # a pole
        ((9.0, 6.0), WHOLE, False),  # a house
    ],
)
def test_shapes_of_vehicles_and_of_background(size, whole, expected):
    assert (vehicle(size, whole) > 0.0) is expected


@given(sides, masks, shares)
def test_swapped_sides_have_the_opposite_log_odds(size, whole, truncated):
    assert length(size[::-1], whole[::-1], truncated) == pytest.approx(-length(size, whole, truncated), abs=1e-9)


@given(sides, masks, shares)
def test_the_name_of_a_side_has_no_effect_on_the_evidence_for_a_vehicle(size, whole, truncated):
    if size[0] != size[1]:
        assert vehicle(size[::-1], whole[::-1], truncated) == vehicle(size, whole, truncated)


@given(sides, masks, shares)
def test_log_odds_are_finite_for_any_extents(size, whole, truncated):
    """The largest density is that of a motorcycle's width, 1 / 0.6; that of outliers is 0.001."""
    assert abs(length(size, whole, truncated)) <= 2.0 * math.log(1.668 / 0.001)
    assert math.isfinite(vehicle(size, whole, truncated))


@given(extents, shares)
def test_a_truncated_side_is_the_limit_of_a_certain_truncation(extent, truncated):
    """The probability of an undetected truncation has no effect on a side that is known to be truncated."""
    assert length((extent, 0.0), CUT, truncated) == length((extent, 0.0), WHOLE, 1.0)
