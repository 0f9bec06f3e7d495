import numpy as np
import pytest

from luxloop.tracker.geometry import rotate
from luxloop.tracker.tracking.orientation import (
    REVERSAL_M,
    TURN_LOG_ODDS,
    by_course,
    course,
    likeliest_turns,
    shape_log_odds,
    turn_sign,
    turn_size,
    way_needed,
)
from luxloop.tracker.tracking.traffic_flow import TrafficFlow

WHOLE, CUT = np.ones(2, dtype=bool), np.zeros(2, dtype=bool)


def turns(size, whole=WHOLE, forward=0.0, least=0.0):
    """Return the quarter turns of a box along x without neighbours, beside an ego with heading `forward` [degrees]."""
    none, ego = np.zeros(0, dtype=np.int64), np.array([0.0, 0.0, np.radians(forward)])
    alone = TrafficFlow(none, np.zeros((0, 2)), np.zeros(0), np.zeros(0, dtype=bool), ego)
    return likeliest_turns(shape_log_odds(np.array(size), whole), np.zeros(2), 0.0, alone, least)


@pytest.mark.parametrize("quarters", range(-3, 8))
def test_turned_signs_denote_the_same_corner(quarters):
    sign, size, heading = np.array([1, -1]), np.array([4.6, 1.8]), 0.4
    before = rotate(0.5 * sign * size, heading)
    after = rotate(0.5 * turn_sign(sign, quarters) * turn_size(size, quarters), heading + quarters * np.pi / 2)
    assert after == pytest.approx(before)


@pytest.mark.parametrize(
    ("size", "forward", "quarters"),
    [
        ((4.5, 1.7), 0.0, 0),  # L-shape: the longer side is the length
        ((4.5, 1.7), 180.0, 2),  # of its two directions, that of the ego
        ((1.7, 4.5), 80.0, 1),
        ((1.7, 4.5), -80.0, 3),
        ((4.5, 0.1), 0.0, 0),  # a single side, longer than the width of a car
        ((4.5, 0.1), 80.0, 0),  # shape is stronger than the direction of the ego
        ((0.1, 1.8), 0.0, 0),  # a single rear: the visible side is the width
        ((0.1, 1.8), 80.0, 0),
        ((1.8, 0.1), 80.0, 1),
        ((2.2, 1.7), 0.0, 0),  # both sides partly visible
        ((0.1, 0.1), 80.0, 1),  # no side is visible: parallel to the ego
        ((0.1, 0.1), -80.0, 3),
    ],
)
def test_the_first_direction_is_the_likeliest(size, forward, quarters):
    assert turns(size, forward=forward) == quarters


@pytest.mark.parametrize(("velocity", "quarters"), [((5, 0.5), 0), ((-5, 0.5), 2), ((0.3, 5), 1), ((0, -5), 3)])
def test_motion_contradicts_the_heading(velocity, quarters):
    direction = course(complex(*velocity), (0.1**2, 0.0, 0.1**2)).direction
    assert by_course(0.0, direction) == quarters


def test_sideways_motion_needs_a_longer_distance_that_no_side_in_view_explains():
    bare, long = np.array([1.7, 0.2]), np.array([4.6, 0.2])
    assert way_needed(2, long) == way_needed(2, bare) == REVERSAL_M
    assert way_needed(1, bare) > 2.5  # the rear of a standing car that comes into view is as wide
    assert way_needed(3, long) == 4.6


def test_a_truncated_face_wider_than_a_car_is_a_side():
    """2.4 m from end to end is the rear of a lorry; 2.4 m between two occluders is a car's side."""
    face = (0.1, 2.4)
    assert turns(face) == 0
    assert turns(face, CUT, forward=90.0) == 1


def test_a_face_of_3_1_m_is_a_side():
    """No vehicle class is as wide; a whole face of up to 2.6 m is a width."""
    assert turns((0.1, 2.6)) == 0
    assert turns((0.1, 3.1)) % 2 == 1


def test_an_uncertain_velocity_has_no_course():
    assert course(5.0 + 0.0j, (1.0**2, 0.0, 1.0**2)) == pytest.approx((0.0, 0.2**2))
    assert course(5.0 + 0.0j, (2.0**2, 0.0, 2.0**2)) is None


@pytest.mark.parametrize(
    ("size", "forward", "quarters"),
    [
        ((0.2, 4.6), 90.0, 1),  # the side across is a length
        ((0.2, 4.6), -90.0, 3),
        ((1.7, 0.2), 90.0, 1),  # the visible side is a rear, not a length
        ((12.0, 2.5), 180.0, 0),  # the ego alone does not turn a vehicle around
        ((4.5, 1.7), 90.0, 0),
    ],
)
def test_evidence_against_a_heading_must_exceed_the_hysteresis(size, forward, quarters):
    assert turns(size, forward=forward, least=TURN_LOG_ODDS) == quarters
