"""Turns of the heading to the front of a vehicle, without a filter bank around them."""

import math

import numpy as np
import pytest

from luxloop.tracker.records import MODELS
from luxloop.tracker.tracking import orientation
from luxloop.tracker.tracking.filters import FilterConfig
from luxloop.tracker.tracking.heading import (
    Turn,
    heading_filter,
    length_log_odds,
    observe_sides,
    turn_heading,
    turns_to_front,
    write,
)
from luxloop.tracker.tracking.orientation import Course
from luxloop.tracker.tracking.track_table import empty

CAR = np.array([4.6, 1.8])
WHOLE = np.ones(2, dtype=np.bool_)
ONE_VIEW = orientation.shape_log_odds(CAR, WHOLE)
"""Log-odds of one view of the whole car that its length is its length."""


def car():
    """Return a table of a car that faces along x and was not seen yet; its tracked corner is at the origin."""
    track = empty(MODELS, rows=1)
    write(track.yaw, track.yaw_covariance, 0, Turn.start(0.0, 0.02**2, 0.0))
    track.visible_size[0] = CAR
    return track


def turns(track, course, x=0.0):
    """Return the quarter turns of a car whose tracked corner is at `x` [m]."""
    track.estimate[0, 0] = x
    return turns_to_front(track, 0, course, heading_filter(FilterConfig()), 0.08)


@pytest.mark.parametrize(("views", "equal_to"), [(1, 1.0), (2, 2 / 1.3), (11, 2.75), (1000, 1000 / 300.7)])
def test_correlated_views_have_the_evidence_of_a_few(views, equal_to):
    """With a correlation of 0.3, n views have that of n / (0.7 + 0.3 n), at most 3.33."""
    track = car()
    for _ in range(views):
        observe_sides(track, 0, CAR, WHOLE)
    assert length_log_odds(track, 0) == pytest.approx(equal_to * ONE_VIEW, rel=1e-9)


def test_opposite_views_cancel():
    track = car()
    for size in (CAR, CAR[::-1].copy()) * 3:
        observe_sides(track, 0, size, WHOLE)
    assert length_log_odds(track, 0) == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize(("quarters", "factor"), [(1, -1.0), (2, 1.0), (3, -1.0), (4, 1.0)])
def test_a_turn_renames_the_sides_of_earlier_views(quarters, factor):
    track = car()
    for _ in range(3):
        observe_sides(track, 0, CAR, WHOLE)
    before = length_log_odds(track, 0)
    turn_heading(track, 0, quarters)
    assert length_log_odds(track, 0) == pytest.approx(factor * before)


def test_motion_without_a_course_turns_nothing():
    """A stationary vehicle is turned by the flow, see `DefaultTrackManagement.orient`."""
    track = car()
    for _ in range(50):
        observe_sides(track, 0, CAR[::-1].copy(), WHOLE)
        assert turns(track, None) == 0


def test_every_turn_by_motion_needs_the_whole_distance_again():
    """A car that reverses is turned after `REVERSAL_M`, and after driving forwards again by the same distance."""
    track, needed = car(), orientation.way_needed(2, CAR)
    assert turns(track, Course(math.pi, 1e-3), -0.9 * needed) == 0
    assert turns(track, Course(math.pi, 1e-3), -1.1 * needed) == 2
    turn_heading(track, 0, 2)
    assert turns(track, Course(0.0, 1e-3), -0.2 * needed) == 0
    assert turns(track, Course(0.0, 1e-3), 0.0) == 2
