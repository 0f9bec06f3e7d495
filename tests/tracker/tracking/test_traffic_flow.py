"""Directions of vehicles by those of their neighbours and of the ego."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from luxloop.tracker.geometry import rotate, wrap
from luxloop.tracker.tracking.orientation import likeliest_turns
from luxloop.tracker.tracking.traffic_flow import TrafficFlow

ORIGIN = np.zeros(2)
EAST, NORTH, WEST = 0.0, 0.5 * math.pi, math.pi

angles = st.floats(-math.pi, math.pi)
places = st.tuples(st.floats(-60.0, 60.0), st.floats(-60.0, 60.0))
cars = st.lists(st.tuples(st.floats(-60.0, 60.0), st.floats(-60.0, 60.0), angles), max_size=5)


def flow_of(*poses, forward=EAST):
    """Return the flow of cars (x, y, heading), with ids from 0."""
    table = np.array(poses, dtype=float).reshape(-1, 3)
    return TrafficFlow(np.arange(len(table)), table[:, :2], table[:, 2], forward)


def turns(flow, heading=EAST, length_log_odds=0.0, place=ORIGIN, least=0.0):
    return likeliest_turns(length_log_odds, np.array(place, dtype=float), heading, flow, least)


def test_without_neighbours_the_ego_gives_the_direction():
    flow = flow_of(forward=math.radians(60.0))
    assert flow.axis_log_odds(ORIGIN, EAST) == pytest.approx(0.7 * math.cos(math.radians(120.0)))
    assert flow.front_log_odds(ORIGIN, EAST) == pytest.approx(0.7 * math.cos(math.radians(60.0)))


def test_one_parallel_neighbour_at_15_m():
    """Its weight is 1/e = 0.367879, and 2 x 0.367879 / (0.3 + 0.367879) = 1.101634."""
    ahead = flow_of((15.0, 0.0, EAST))
    assert ahead.axis_log_odds(ORIGIN, EAST) == pytest.approx(0.7 + 1.101634, abs=1e-6)
    assert ahead.front_log_odds(ORIGIN, EAST) == pytest.approx(0.7 + 1.101634, abs=1e-6)
    assert flow_of((15.0, 0.0, WEST)).axis_log_odds(ORIGIN, EAST) == pytest.approx(0.7 + 1.101634, abs=1e-6)
    assert flow_of((15.0, 0.0, WEST)).front_log_odds(ORIGIN, EAST) == pytest.approx(0.7 - 1.101634, abs=1e-6)
    assert flow_of((15.0, 0.0, NORTH)).axis_log_odds(ORIGIN, EAST) == pytest.approx(0.7 - 1.101634, abs=1e-6)


def test_a_neighbour_on_the_next_lane_determines_the_axis_more_than_the_front():
    """At 3.5 m, two standard deviations, its weight for the front is exp(-2) = 0.135335: 2 x 0.135335 / 0.435335 =
    0.621752. For the axis it is exp(-3.5 / 15) = 0.791889: 2 x 0.791889 / 1.091889 = 1.450493."""
    oncoming = flow_of((0.0, 3.5, WEST))
    assert oncoming.front_log_odds(ORIGIN, EAST) == pytest.approx(0.7 - 0.621752, abs=1e-6)
    assert oncoming.axis_log_odds(ORIGIN, EAST) == pytest.approx(0.7 + 1.450493, abs=1e-6)


def test_many_neighbours_are_limited():
    crowd = flow_of(*[(1.0, 0.0, EAST)] * 1000)
    assert crowd.axis_log_odds(ORIGIN, EAST) == pytest.approx(0.7 + 2.0, abs=1e-3)


def test_a_vehicle_is_not_its_own_neighbour():
    flow = flow_of((0.0, 0.0, NORTH), (15.0, 0.0, EAST))
    assert flow.without(0).axis_log_odds(ORIGIN, EAST) == flow_of((15.0, 0.0, EAST)).axis_log_odds(ORIGIN, EAST)


@given(cars, places, angles, angles, angles)
def test_a_rotated_scene_has_the_same_flow(poses, place, heading, forward, rotation):
    turned = [(*rotate(np.array([x, y]), rotation), yaw + rotation) for x, y, yaw in poses]
    one, other = flow_of(*poses, forward=forward), flow_of(*turned, forward=forward + rotation)
    there = rotate(np.array(place), rotation)
    for name in ("axis_log_odds", "front_log_odds"):
        before, after = getattr(one, name)(np.array(place), heading), getattr(other, name)(there, heading + rotation)
        assert after == pytest.approx(before, abs=1e-6)


@given(cars, places, angles, angles)
def test_opposite_hypotheses_have_opposite_log_odds(poses, place, heading, forward):
    """A quarter turn swaps parallel and across, half a turn swaps front and rear."""
    flow, there = flow_of(*poses, forward=forward), np.array(place)
    assert flow.axis_log_odds(there, heading + NORTH) == pytest.approx(-flow.axis_log_odds(there, heading), abs=1e-9)
    assert flow.front_log_odds(there, heading + WEST) == pytest.approx(-flow.front_log_odds(there, heading), abs=1e-9)


PARKED = [(-6.0, 0.0, NORTH), (6.0, 0.0, NORTH), (12.0, 0.0, NORTH)]
"""Cars side by side, parked across the ego's direction."""


@pytest.mark.parametrize("heading", [EAST, NORTH, WEST, -NORTH])
def test_a_car_between_parked_cars_has_their_axis(heading):
    """Its shape has no evidence; alone it would be parallel to the ego."""
    chosen = heading + turns(flow_of(*PARKED), heading) * NORTH
    assert math.cos(chosen - NORTH) ** 2 == pytest.approx(1.0)
    alone = heading + turns(flow_of(), heading) * NORTH
    assert wrap(alone - EAST) == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize("heading", [EAST, NORTH, WEST, -NORTH])
def test_a_car_in_an_oncoming_queue_faces_like_the_queue(heading):
    """Two cars of its lane outweigh the ego: exp(-7 / 15) + exp(-14 / 15) = 1.020, 2 x 1.020 / 1.320 > 0.7."""
    chosen = heading + turns(flow_of((7.0, 3.5, WEST), (14.0, 3.5, WEST)), heading, place=(0.0, 3.5)) * NORTH
    assert wrap(chosen - WEST) == pytest.approx(0.0, abs=1e-9)


def test_shape_outweighs_flow():
    """A whole side of 4.2 m has log-odds of 5.7, all neighbours and the ego together 2.7."""
    assert turns(flow_of(*PARKED), EAST, length_log_odds=5.7) == 0
    assert turns(flow_of(*PARKED), EAST, length_log_odds=-5.7) % 2 == 1


def test_a_small_contradiction_does_not_turn_a_known_heading():
    """The ego alone has 0.7, below the hysteresis of 1."""
    assert turns(flow_of(forward=NORTH), EAST, least=1.0) == 0
    assert turns(flow_of(forward=WEST), EAST, least=1.0) == 0
    assert turns(flow_of(forward=NORTH), EAST, least=0.5) == 1
    assert turns(flow_of(forward=WEST), EAST, least=0.5) == 2
