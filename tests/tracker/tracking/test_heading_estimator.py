"""Turns of the heading to the front of a vehicle, without a filter bank around the estimator."""

import math

import numpy as np
import pytest
from support.seen import observe_boxes

from luxloop.tracker.tracking import orientation
from luxloop.tracker.tracking.confirmation import ConfirmationConfig
from luxloop.tracker.tracking.corner_error import CornerConfig
from luxloop.tracker.tracking.existence import ExistenceConfig
from luxloop.tracker.tracking.filters import FilterConfig
from luxloop.tracker.tracking.heading import HeadingEstimator
from luxloop.tracker.tracking.orientation import Course, OrientationConfig
from luxloop.tracker.tracking.track_config import TrackConfig
from luxloop.tracker.tracking.track_observation import first_observation
from luxloop.tracker.tracking.vehicle_size import ExtentConfig

CAR = np.array([4.6, 1.8])
ORIGIN, WHOLE = np.zeros(2), np.ones(2, dtype=np.bool_)
CONFIG = TrackConfig(
    FilterConfig(), ExtentConfig(), OrientationConfig(), CornerConfig(), ConfirmationConfig(), ExistenceConfig()
)
ONE_VIEW = orientation.shape_log_odds(CAR, WHOLE, CONFIG.orientation)
"""Log-odds of one view of the whole car that its length is its length."""


def estimator():
    """Return the estimator of a car that faces along x."""
    first, _ = first_observation(observe_boxes((20.0, 3.5, 0.0), CAR), 0, 0, CAR)
    return HeadingEstimator(first, ORIGIN, CONFIG)


@pytest.mark.parametrize(("views", "equal_to"), [(1, 1.0), (2, 2 / 1.3), (11, 2.75), (1000, 1000 / 300.7)])
def test_correlated_views_have_the_evidence_of_a_few(views, equal_to):
    """With a correlation of 0.3, n views have that of n / (0.7 + 0.3 n), at most 3.33."""
    heading = estimator()
    for _ in range(views):
        heading.observe_sides(CAR, WHOLE)
    assert heading.length_log_odds == pytest.approx(equal_to * ONE_VIEW, rel=1e-9)


def test_opposite_views_cancel():
    heading = estimator()
    for size in (CAR, CAR[::-1]) * 3:
        heading.observe_sides(size, WHOLE)
    assert heading.length_log_odds == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize(("quarters", "factor"), [(1, -1.0), (2, 1.0), (3, -1.0), (4, 1.0)])
def test_a_turn_renames_the_sides_of_earlier_views(quarters, factor):
    heading = estimator()
    for _ in range(3):
        heading.observe_sides(CAR, WHOLE)
    before = heading.length_log_odds
    heading.turn(quarters, ORIGIN)
    assert heading.length_log_odds == pytest.approx(factor * before)


def test_motion_without_a_course_turns_nothing():
    """A stationary vehicle is turned by the flow, see `Track.orient`."""
    heading = estimator()
    for _ in range(50):
        heading.observe_sides(CAR[::-1], WHOLE)
        assert heading.turns_to_front(None, ORIGIN, CAR[::-1]) == 0


def test_every_turn_by_motion_needs_the_whole_distance_again():
    """A car that reverses is turned after `reversal_m`, and after driving forwards again by the same distance."""
    heading, needed = estimator(), orientation.way_needed(2, CAR, CONFIG.orientation)
    assert heading.turns_to_front(Course(math.pi, 1e-3), np.array([-0.9 * needed, 0.0]), CAR) == 0
    turned_at = np.array([-1.1 * needed, 0.0])
    assert heading.turns_to_front(Course(math.pi, 1e-3), turned_at, CAR) == 2
    heading.turn(2, turned_at)
    assert heading.turns_to_front(Course(0.0, 1e-3), turned_at + np.array([0.9 * needed, 0.0]), CAR) == 0
    assert heading.turns_to_front(Course(0.0, 1e-3), turned_at + np.array([1.1 * needed, 0.0]), CAR) == 2
