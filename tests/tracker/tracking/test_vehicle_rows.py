"""Rows of vehicles: which neighbours are in line with an object, and what that changes."""

import math

import numpy as np
import pytest
from support.one_track import flow_of, follow, start

from luxloop.tracker.records import OrientedBoxes, Status
from luxloop.tracker.tracking import confirmation
from luxloop.tracker.tracking.vehicle_rows import GAP_MAX_M, IN_LINE_M, IN_ROW_LOG_ODDS, in_row

FAR_EGO = np.array([1000.0, 0.0, 0.0])


def boxes(*poses, length=4.5):
    """Boxes of cars at x, y and heading."""
    table = np.array(poses, dtype=float).reshape(-1, 3)
    size = np.tile([length, 1.8], (len(table), 1))
    return OrientedBoxes(
        table[:, :2], table[:, 2], size, np.zeros((len(table), 2)), np.ones(len(table), dtype=np.int64)
    )


def second_in_row(pose, vehicles=(True, False), ego=FAR_EGO):
    """Return whether a car at `pose` is in a row with one at the origin."""
    return in_row(boxes((0.0, 0.0, 0.0), pose), np.array(vehicles), ego).item(1)


@pytest.mark.parametrize(
    ("pose", "expected"),
    [
        ((6.0, 0.0, 0.0), True),
        ((-6.0, 0.0, math.pi), True),  # a direction is not known
        ((6.0, IN_LINE_M - 0.01, 0.0), True),
        ((6.0, IN_LINE_M + 0.01, 0.0), False),
        ((4.6, 0.0, 0.0), True),  # a gap of 0.1 m
        ((4.4, 0.0, 0.0), False),  # the boxes overlap: pieces of one vehicle
        ((4.5 + GAP_MAX_M - 0.01, 0.0, 0.0), True),
        ((4.5 + GAP_MAX_M + 0.01, 0.0, 0.0), False),
        ((6.0, 0.0, math.radians(6.9)), True),
        ((6.0, 0.0, math.radians(7.1)), False),
        ((6.0, 0.0, 0.5 * math.pi), False),
        ((0.0, 3.0, 0.0), False),  # abreast
    ],
)
def test_a_neighbour_in_line_makes_a_row(pose, expected):
    assert second_in_row(pose) is expected


def test_a_row_is_along_the_heading_of_the_object():
    """Two cars that are parked across, side by side, are in none; in line along 30 degrees they are."""
    turn = math.radians(30.0)
    row = boxes((0.0, 0.0, turn), (7.0 * math.cos(turn), 7.0 * math.sin(turn), turn))
    assert in_row(row, np.array([True, False]), FAR_EGO).tolist() == [False, True]
    across = boxes((0.0, 0.0, 0.5 * math.pi), (6.0, 0.0, 0.5 * math.pi))
    assert not in_row(across, np.array([True, False]), FAR_EGO).any()


def test_only_known_vehicles_make_a_row():
    assert not second_in_row((6.0, 0.0, 0.0), vehicles=(False, False))
    assert not second_in_row((6.0, 0.0, 0.0), vehicles=(False, True))  # not with itself


def test_the_ego_makes_a_row():
    assert second_in_row((10.0, 0.0, 0.0), vehicles=(False, False), ego=np.array([20.0, 0.5, 0.0]))


def test_no_objects_are_in_no_row():
    assert in_row(boxes(), np.zeros(0, dtype=bool), FAR_EGO).shape == (0,)


@pytest.mark.parametrize(("ahead_m", "status"), [(15.0, Status.CONFIRMED), (60.0, Status.TENTATIVE)])
def test_a_row_confirms_a_vehicle_that_its_shape_alone_does_not(ahead_m, status):
    """A flat end as wide as a car, ahead of the ego within 15 m or beyond: the log-odds of its shape are about 1.4."""
    pose, size = (ahead_m, 0.0, 0.0), np.array([0.1, 1.8])
    track = start(pose, size=size)
    follow(track, [pose] * 5, size=size, flow=flow_of())
    alone = confirmation.vehicle_odds(track.table, 0)
    assert confirmation.log_odds(0.9) - IN_ROW_LOG_ODDS < alone < confirmation.log_odds(0.9)
    assert track.status is status
