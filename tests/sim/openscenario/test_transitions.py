"""Durations of changes by their rate (ASAM OpenSCENARIO XML 1.2: a rate is the largest one of the change)."""

import math

import pytest

from luxloop.sim.openscenario.storyboard import Dynamics
from luxloop.sim.openscenario.transitions import lane_change_extent, speed_duration

DURATIONS = {"linear": 2.0, "cubic": 3.0, "sinusoidal": math.pi}
"""Of a change by twice its rate [s]. The largest slopes are 1, 1.5 (of 3 x^2 - 2 x^3) and pi / 2."""


@pytest.mark.parametrize("width", [3.5, -3.5])
@pytest.mark.parametrize("shape", DURATIONS)
def test_a_lane_change_takes_the_time_of_its_rate(shape, width):
    assert lane_change_extent(Dynamics(shape, "rate", 1.75), width) == pytest.approx((DURATIONS[shape], math.inf))


@pytest.mark.parametrize(("before", "after"), [(10.0, 16.0), (16.0, 10.0)])
@pytest.mark.parametrize("shape", DURATIONS)
def test_a_speed_change_takes_the_time_of_its_rate(shape, before, after):
    assert speed_duration(Dynamics(shape, "rate", 3.0), before, after) == pytest.approx(DURATIONS[shape])
