"""Kaplan-Meier estimate against the published example."""

import math

import numpy as np
import pytest
from support.remission import PLACEBO, REACHED, TREATED

from luxloop.scenarios.grading import emergence


def test_it_equals_the_published_estimate():
    at, share = emergence.survival(TREATED, REACHED)
    by_week = dict(zip(at.tolist(), share.tolist(), strict=True))
    # Cox and Oakes 1984, Analysis of Survival Data, table 1.1 and section 4.2.
    expected = {6: 0.857, 7: 0.807, 10: 0.753, 13: 0.690, 16: 0.627, 22: 0.538, 23: 0.448}
    assert {week: by_week[week] for week in expected} == pytest.approx(expected, abs=0.0006)
    assert emergence.median(TREATED, REACHED) == 23
    assert emergence.median(PLACEBO, np.ones(21, np.bool_)) == 8


def test_a_median_is_the_time_at_which_exactly_half_have_happened():
    assert emergence.median(np.array([1.0, 2.0, 3.0, 4.0]), np.ones(4, np.bool_)) == 2.0
    assert emergence.median(np.array([1.0, 2.0, 2.0, 3.0]), np.array([True, True, False, False])) == 2.0


def test_a_median_that_is_not_reached_is_infinite():
    assert math.isinf(emergence.median(np.array([1.0, 2.0, 3.0]), np.array([True, False, False])))
    assert math.isinf(emergence.median(np.empty(0), np.empty(0, np.bool_)))
