"""Memory of hidden vehicles: existence, free places, and the doubt about what reappears."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from support.one_track import DT, flow_of, follow, joined, start, straight

from luxloop.tracker.records import Status
from luxloop.tracker.scan import Scan
from luxloop.tracker.tracking.corner import corner_covariance
from luxloop.tracker.tracking.existence import (
    CLUTTER_PER_M2,
    ExistenceConfig,
    existence,
    predicted_places,
    same_vehicle,
    terminate_lost,
)

MEMORY = ExistenceConfig()
HALF_S = MEMORY.course_s * np.log(2.0)
"""Time after which half of the hidden vehicles are off their course [s]."""


def arc(range_m, low_deg=0.0, high_deg=360.0):
    angle = np.radians(np.arange(low_deg, high_deg, 0.25))
    return range_m * np.stack([np.cos(angle), np.sin(angle), np.zeros_like(angle)], axis=1)


def scan(points):
    return Scan.from_points(0.0, points)


def coasting(seconds, pose=(20.0, 0.0, 0.0)):
    """A stationary car that was seen for 2 s and then not."""
    track = start(pose)
    follow(track, [pose] * 25)
    wait(track, seconds)
    return track


def wait(track, seconds):
    for _ in range(round(seconds / DT)):
        track.predict()
        track.settle()


# --- probabilities


def test_existence_is_that_of_the_formula():
    """s = 1/2 and h = 1/2: s h / (s h + 1 - s) = 0.25 / 0.75."""
    assert existence(HALF_S, 0.5, MEMORY) == pytest.approx(1 / 3)
    assert existence(0.0, 0.5, MEMORY) == 1.0
    assert existence(1.0, 0.0, MEMORY) == 0.0


@given(st.floats(0.0, 30.0), st.floats(0.0, 30.0), st.floats(0.0, 1.0), st.floats(0.0, 1.0))
def test_existence_decreases_with_time_and_with_free_places(early, late, few, many):
    early, late = sorted((early, late))
    few, many = sorted((few, many))
    assert 0.0 <= existence(late, few, MEMORY) <= existence(early, many, MEMORY) + 1e-12 <= 1.0 + 1e-12


def test_a_box_is_the_hidden_vehicle_with_even_odds_at_the_density_of_clutter():
    """s = 1/2 at twice the density of clutter."""
    assert same_vehicle(HALF_S, 2.0 * CLUTTER_PER_M2, MEMORY) == pytest.approx(0.5)
    assert same_vehicle(1.0, 10.0, MEMORY) > 0.99


# --- free places


def test_predicted_places_have_the_spread_of_the_prediction_and_the_length_of_the_vehicle():
    """Five equally likely parts of a normal distribution have a variance of 0.77."""
    track = coasting(2.0, (20.0, 5.0, 0.7))
    covariance = corner_covariance(track.table, 0)
    boxes = track.table.boxes(track.table.size)
    places = predicted_places(boxes.center, boxes.heading, boxes.size[:, 0].copy(), covariance[None])[0]
    assert places.mean(axis=(0, 1)) == pytest.approx(boxes.center[0])
    assert np.cov(places[:, 1].T, bias=True) == pytest.approx(0.767 * covariance, rel=0.01)
    ends, heading = places[0, -1] - places[0, 0], boxes.heading[0]
    direction = np.array([np.cos(heading), np.sin(heading)])
    assert ends == pytest.approx(0.7 * boxes.size[0, 0] * direction)


def test_a_vehicle_is_lost_where_beams_pass_all_of_its_places():
    track = coasting(1.0)
    terminate_lost(track.table, scan(arc(40.0)), MEMORY)
    assert track.status is Status.DEAD


@pytest.mark.parametrize("returns", [arc(10.0), arc(10.0, -40.0, 40.0), np.zeros((0, 3))], ids=["wall", "truck", "sky"])
def test_a_vehicle_behind_something_and_one_without_returns_are_remembered(returns):
    track = coasting(5.0)
    terminate_lost(track.table, scan(returns), MEMORY)
    assert track.status is Status.COASTING


def test_a_vehicle_whose_place_is_too_vague_is_lost():
    track = coasting(1.0)
    sharp = ExistenceConfig(std_max_m=0.5 * np.sqrt(np.trace(corner_covariance(track.table, 0)) / 2.0))
    terminate_lost(track.table, scan(arc(10.0)), sharp)
    assert track.status is Status.DEAD


def test_tracks_that_are_seen_or_tentative_are_not_judged():
    seen, tentative = coasting(0.0), start((20.0, 0.0, 0.0))
    both = joined([seen, tentative])
    terminate_lost(both, scan(arc(40.0)), MEMORY)
    assert both.status.tolist() == [Status.CONFIRMED, Status.TENTATIVE]


def test_the_ego_pose_places_the_returns():
    """The same scene, rotated by 120 degrees about the ego 100 m away."""
    track = coasting(1.0, (100.0 + 20.0 * np.cos(2.0), 20.0 * np.sin(2.0), 2.0))
    behind = Scan.from_points(0.0, arc(40.0, -30.0, 30.0), (100.0, 0.0, 2.0))
    beside = Scan.from_points(0.0, arc(40.0, 90.0, 150.0), (100.0, 0.0, 2.0))
    terminate_lost(track.table, beside, MEMORY)
    assert track.status is Status.COASTING
    terminate_lost(track.table, behind, MEMORY)
    assert track.status is Status.DEAD


# --- what reappears


def test_a_vehicle_at_its_predicted_place_stays_confirmed():
    track = coasting(1.0)
    follow(track, [(20.0, 0.0, 0.0)])
    assert track.status is Status.CONFIRMED


def test_a_flat_object_away_from_a_vague_prediction_is_not_confirmed():
    """A piece of wall, 4 m from where the car is predicted after 4 s."""
    track = coasting(4.0)
    wall = (24.0, 0.0, 0.0)
    follow(track, [wall] * 10, size=np.array([2.0, 0.03]), cut=(True, True, False, False))
    assert track.status is not Status.CONFIRMED


def test_a_vehicle_that_moves_on_after_it_was_hidden_is_confirmed_by_its_motion():
    """It had moved before. Only a part of its side is visible, which is no evidence of a vehicle: without new evidence
    of motion it may be a wall."""
    first, part, cut = (-10.0, 6.0, 0.0), np.array([2.0, 0.03]), (True, False, True, False)
    status = []
    for moves in (True, False):
        track = start(first)
        track.table.left[0] = True
        follow(track, straight(first, 10.0, 25), flow=flow_of())
        wait(track, 4.5)
        seen_at = (first[0] + 10.0 * (25 * DT + round(4.5 / DT) * DT) + 1.0, 6.0, 0.0)
        follow(track, [seen_at], size=part, cut=cut)
        assert not track.table.left[0]
        track.table.left[0] = moves
        follow(track, straight(seen_at, 10.0 if moves else 0.0, 24), size=part, cut=cut)
        status.append(track.status)
    assert status[0] is Status.CONFIRMED
    assert status[1] is not Status.CONFIRMED
