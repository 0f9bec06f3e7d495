"""Headings along a trajectory."""

import math

import pytest

from luxloop.sim.openscenario.trajectory import Trajectory


@pytest.mark.parametrize(("begin", "end"), [(170.0, -170.0), (-170.0, 170.0)])
def test_a_heading_turns_the_short_way_across_the_jump_of_its_angle(begin, end):
    """From 170 to 190 degrees, by way of 180."""
    vertices = [(0.0, 0.0, math.radians(begin)), (-8.0, 0.0, math.radians(end))]
    way = Trajectory(vertices, None, 0.0)
    for driven, share in ((2.0, 0.25), (2.0, 0.5), (2.0, 0.75), (2.0, 1.0)):
        way.advance(1.0, driven)
        x, y, yaw = way.pose
        assert (x, y) == pytest.approx((-8.0 * share, 0.0))
        turned = math.copysign(20.0 * share, begin)
        assert yaw == pytest.approx(math.radians(begin + turned))
