"""Angles of the world frame."""

import math

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from luxloop.sim.kinematics import wrap_angle


@given(st.floats(-1e3, 1e3))
def test_wrapped_angles_keep_the_direction_and_are_in_range(angle):
    (wrapped,) = wrap_angle(np.array([angle]))
    assert -np.pi < wrapped <= np.pi
    assert math.isclose(math.cos(wrapped), math.cos(angle), abs_tol=1e-9)
    assert math.isclose(math.sin(wrapped), math.sin(angle), abs_tol=1e-9)


def test_south_is_plus_pi():
    assert wrap_angle(np.array([-np.pi, np.pi, 3 * np.pi])).tolist() == [np.pi] * 3
