"""Directions of vehicles by those of their neighbours and of the ego."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from luxloop.tracker.geometry import rotate, wrap
from luxloop.tracker.tracking.orientation import likeliest_turns
from luxloop.tracker.tracking.traffic_flow import TrafficFlow, TrafficSide

ORIGIN = np.zeros(2)
EAST, NORTH, WEST = 0.0, 0.5 * math.pi, math.pi

angles = st.floats(-math.pi, math.pi)
places = st.tuples(st.floats(-60.0, 60.0), st.floats(-60.0, 60.0))
cars = st.lists(st.tuples(st.floats(-60.0, 60.0), st.floats(-60.0, 60.0), angles), max_size=5)


def flow_of(*poses, forward=EAST):
    """Return the flow of cars (x, y, heading), with ids from 0."""
    table = np.array(poses, dtype=float).reshape(-1, 3)
    known = np.ones(len(table), dtype=bool)
    return TrafficFlow(np.arange(len(table)), table[:, :2], table[:, 2], known, np.array([0.0, 0.0, forward]))


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


def test_a_neighbour_whose_front_is_unknown_determines_the_axis_only():
    """Two parked cars whose fronts were only guessed must not confirm each other's guesses."""
    parked = replace(flow_of((7.0, 0.0, WEST)), front_known=np.array([False]))
    assert parked.front_log_odds(ORIGIN, EAST) == pytest.approx(0.7)
    assert parked.axis_log_odds(ORIGIN, EAST) == flow_of((7.0, 0.0, WEST)).axis_log_odds(ORIGIN, EAST)


@pytest.mark.parametrize(
    ("place", "faces"),
    [
        ((0.0, 3.5), EAST),  # another lane of the ego's carriageway
        ((0.0, -3.5), EAST),
        ((20.0, 7.0), WEST),  # the left kerb of a street
        ((20.0, -7.0), EAST),
        ((20.0, 15.0), WEST),
    ],
)
def test_parked_vehicles_face_as_the_traffic_on_their_side(place, faces):
    flow = flow_of()
    assert flow.front_log_odds(np.array(place), faces) == pytest.approx(0.7)
    on_the_left = replace(flow, keeps_right=-1.0)  # where traffic keeps to the left, the sides are swapped
    mirrored = np.array([place[0], -place[1]])
    assert on_the_left.front_log_odds(mirrored, faces) == pytest.approx(0.7)


@pytest.mark.parametrize(("left_m", "faces"), [(15.0, -NORTH), (-15.0, NORTH)])
def test_vehicles_on_a_side_street_face_the_junction(left_m, faces):
    assert flow_of().front_log_odds(np.array([20.0, left_m]), faces) == pytest.approx(0.7)


def test_vehicles_in_bays_beside_the_street_have_no_expected_front():
    assert flow_of().front_log_odds(np.array([20.0, -8.0]), NORTH) == pytest.approx(0.0, abs=1e-12)


def oncoming(left_m, ids, heading=WEST):
    """Return ids, positions and headings of vehicles at a lateral distance [m] from an ego at the origin."""
    return np.array(ids), np.array([[20.0, left_m]] * len(ids)), np.full(len(ids), heading)


def test_the_side_of_traffic_is_that_of_most_oncoming_vehicles():
    """The prior of 0.6 is (2 / (1 + exp(-0.6))) - 1 = 0.291313 to the right; each oncoming vehicle counts 1, once."""
    side, ego = TrafficSide(), np.zeros(3)
    assert side.keeps_right == pytest.approx(0.291313, abs=1e-6)
    side.observe(*oncoming(-3.5, [4]), ego)
    side.observe(*oncoming(-3.5, [4]), ego)
    assert side.log_odds == pytest.approx(-0.4)
    side.observe(*oncoming(-3.5, [4, 5, 6]), ego)
    assert side.log_odds == pytest.approx(-2.4)
    side.observe(*oncoming(3.5, [7]), ego)
    assert side.log_odds == pytest.approx(-1.4)


def test_other_vehicles_do_not_show_the_side_of_traffic():
    side, ego = TrafficSide(), np.zeros(3)
    for left_m, heading in ((-3.5, EAST), (-3.5, NORTH), (-1.0, WEST), (-12.0, WEST), (-3.5, WEST - 0.4)):
        side.observe(*oncoming(left_m, [1], heading), ego)
    assert side.log_odds == 0.6
    side.observe(*oncoming(3.5, range(100)), ego)
    assert side.log_odds == 5.0


@pytest.mark.parametrize(("left_m", "limit", "back"), [(3.5, 5.0, 4.0), (-3.5, -5.0, -4.0)])
def test_the_belief_in_a_side_of_traffic_is_limited(left_m, limit, back):
    """After many vehicles on one side, of which none counts twice, one on the other side counts as at first."""
    side, ego = TrafficSide(), np.zeros(3)
    side.observe(*oncoming(left_m, range(100)), ego)
    assert side.log_odds == limit
    side.observe(*oncoming(-left_m, [100]), ego)
    assert side.log_odds == back


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
