"""Turns of the heading to the front of a vehicle, without a filter bank around the estimator."""

import math

import numpy as np
from support.seen import observe_boxes

from tracker.tracking import orientation
from tracker.tracking.confirmation import TrackLifeConfig
from tracker.tracking.corner_error import CornerConfig
from tracker.tracking.extent import ExtentConfig
from tracker.tracking.filters import FilterConfig
from tracker.tracking.heading_estimator import HeadingEstimator
from tracker.tracking.hypotheses import HypothesisConfig
from tracker.tracking.orientation import Course, OrientationConfig
from tracker.tracking.track_config import TrackConfig
from tracker.tracking.track_observation import first_observation

CAR = np.array([4.6, 1.8])
ORIGIN, WHOLE = np.zeros(2), np.ones(2, dtype=np.bool_)
CONFIG = TrackConfig(FilterConfig(), ExtentConfig(), OrientationConfig(), CornerConfig(), TrackLifeConfig())
VOTES = CONFIG.orientation.votes


def estimator():
    """Return the estimator of a car that faces along x."""
    first, _ = first_observation(observe_boxes((20.0, 3.5, 0.0), CAR), 0, 0, CAR, HypothesisConfig())
    return HeadingEstimator(first, ORIGIN, 0.0, CONFIG)


def frames_to_turn(heading, size, frames=20):
    """Return the number of frames in which the size of a stationary vehicle contradicts the heading, up to a turn."""
    for frame in range(1, frames + 1):
        if quarters := heading.turns_to_front(None, ORIGIN, size, WHOLE):
            heading.turn(quarters, ORIGIN)
            return frame
    return None


def test_every_turn_by_size_needs_all_votes_again():
    heading, sideways = estimator(), CAR[::-1]
    assert frames_to_turn(heading, CAR) is None
    assert [frames_to_turn(heading, sideways) for _ in range(3)] == [VOTES] * 3


def test_a_turn_by_motion_discards_earlier_votes_by_size():
    heading, sideways = estimator(), CAR[::-1]
    for _ in range(VOTES - 1):
        assert heading.turns_to_front(None, ORIGIN, sideways, WHOLE) == 0
    heading.turn(2, ORIGIN)
    assert frames_to_turn(heading, sideways) == VOTES


def test_every_turn_by_motion_needs_the_whole_distance_again():
    """A car that reverses is turned after `reversal_m`, and after driving forwards again by the same distance."""
    heading, needed = estimator(), orientation.way_needed(2, CAR, CONFIG.orientation)
    assert heading.turns_to_front(Course(math.pi, 1e-3), np.array([-0.9 * needed, 0.0]), CAR, WHOLE) == 0
    turned_at = np.array([-1.1 * needed, 0.0])
    assert heading.turns_to_front(Course(math.pi, 1e-3), turned_at, CAR, WHOLE) == 2
    heading.turn(2, turned_at)
    assert heading.turns_to_front(Course(0.0, 1e-3), turned_at + np.array([0.9 * needed, 0.0]), CAR, WHOLE) == 0
    assert heading.turns_to_front(Course(0.0, 1e-3), turned_at + np.array([1.1 * needed, 0.0]), CAR, WHOLE) == 2
