import numpy as np
import pytest

from tracker.geometry import rotate, wrap
from tracker.tracking.orientation import (
    OrientationConfig,
    by_course,
    by_size,
    course,
    first_guess,
    turn_sign,
    turn_size,
    way_needed,
)

CONFIG = OrientationConfig()
WHOLE = np.ones(2, dtype=bool)


@pytest.mark.parametrize("quarters", range(-3, 8))
def test_turned_signs_denote_the_same_corner(quarters):
    sign, size, heading = np.array([1, -1]), np.array([4.6, 1.8]), 0.4
    before = rotate(0.5 * sign * size, heading)
    after = rotate(0.5 * turn_sign(sign, quarters) * turn_size(size, quarters), heading + quarters * np.pi / 2)
    assert after == pytest.approx(before)


@pytest.mark.parametrize(
    ("size", "forward", "expected"),
    [
        ((4.5, 1.7), 0.0, 0.0),  # L-shape: the longer side is the length
        ((1.7, 4.5), 0.0, 90.0),
        ((4.5, 0.1), 0.0, 0.0),  # a single side, longer than the width of a car
        ((0.1, 1.8), 0.0, 0.0),  # a single rear: the visible side is the width
        ((1.8, 0.1), 0.0, 90.0),
        ((2.2, 1.7), 0.0, 0.0),  # both sides partly visible
        ((0.1, 1.8), 180.0, 180.0),  # of two directions that of the ego
    ],
)
def test_first_guess(size, forward, expected):
    quarters = first_guess(0.0, np.array(size), WHOLE, np.radians(forward), CONFIG)
    assert np.cos(quarters * np.pi / 2 - np.radians(expected)) ** 2 == pytest.approx(1.0)
    if expected in (0.0, 180.0):
        assert wrap(quarters * np.pi / 2 - np.radians(expected)) == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize(("velocity", "quarters"), [((5, 0.5), 0), ((-5, 0.5), 2), ((0.3, 5), 1), ((0, -5), 3)])
def test_motion_contradicts_the_heading(velocity, quarters):
    direction = course(np.array(velocity, dtype=float), np.eye(2) * 0.1**2, CONFIG).direction
    assert by_course(0.0, direction) == quarters


def test_sideways_motion_needs_a_longer_distance_that_no_side_in_view_explains():
    bare, long = np.array([1.7, 0.2]), np.array([4.6, 0.2])
    assert way_needed(2, long, CONFIG) == way_needed(2, bare, CONFIG) == CONFIG.reversal_m
    assert way_needed(1, bare, CONFIG) > 2.5  # the rear of a standing car that comes into view is as wide
    assert way_needed(3, long, CONFIG) == 4.6


def test_a_truncated_face_wider_than_a_car_is_a_side():
    """2.4 m from end to end is the rear of a truck; 2.4 m between two occluders is a car's side."""
    face = np.array([0.1, 2.4])
    assert first_guess(0.0, face, WHOLE, 0.0, CONFIG) % 2 == 0
    assert first_guess(0.0, face, np.zeros(2, dtype=bool), 0.0, CONFIG) % 2 == 1


def test_the_rear_of_a_wide_load_is_its_width():
    """2.75 m from end to end: with mirrors or a special permit, vehicles are up to 3 m wide."""
    assert first_guess(0.0, np.array([0.1, 2.75]), WHOLE, 0.0, CONFIG) % 2 == 0
    assert first_guess(0.0, np.array([0.1, 3.1]), WHOLE, 0.0, CONFIG) % 2 == 1


def test_an_uncertain_velocity_has_no_course():
    fast = np.array([5.0, 0.0])
    assert course(fast, np.eye(2) * 1.0**2, CONFIG) == pytest.approx((0.0, 0.2**2))
    assert course(fast, np.eye(2) * 2.0**2, CONFIG) is None


@pytest.mark.parametrize(
    ("size", "forward", "quarters"),
    [
        ((0.2, 4.6), 90.0, 1),  # the remembered width is a length
        ((0.2, 4.6), -90.0, 3),
        ((1.7, 0.2), 90.0, 1),  # the visible side is a rear, not a length
        ((12.0, 2.5), 180.0, 0),  # without motion a vehicle is not turned around
    ],
)
def test_size_distinguishes_length_and_width_of_a_slow_vehicle(size, forward, quarters):
    assert by_size(0.0, np.array(size), WHOLE, np.radians(forward), CONFIG) == quarters
