"""Merging of the pieces of a vehicle, and separate vehicles that follow each other."""

import numpy as np
import pytest

from luxloop.tracker.merging import MergeConfig, hull, may_be_one, merge_segments, one_vehicle
from luxloop.tracker.records import OrientedBoxes, Segments

CONFIG = MergeConfig()


def pieces(*boxes, speed=15.0, hits=20):
    """Boxes (x, y, heading, length, width) that drive along x."""
    x, y, heading, length, width = np.array(boxes, dtype=float).T
    speeds = np.broadcast_to(speed, len(x)).astype(float)
    return OrientedBoxes(
        center=np.stack([x, y], axis=1),
        heading=heading,
        size=np.stack([length, width], axis=1),
        velocity=np.stack([speeds, 0 * speeds], axis=1),
        hits=np.full(len(x), hits),
    )


CAB, TRAILER = (14.0, 3.0, 0.0, 2.4, 2.5), (5.0, 3.0, 0.0, 10.0, 2.5)


def are_one(both):
    """Return True if both pieces are one vehicle at this instant."""
    return (0, 1) in may_be_one(both) and one_vehicle(both, 0, 1, CONFIG)


def test_a_tractor_and_its_trailer_are_one_vehicle():
    both = pieces(CAB, TRAILER)
    assert are_one(both)
    low, high = hull(both, 0, 1)
    np.testing.assert_allclose(both.center[0] + [low, high], [[0.0, 1.75], [15.2, 4.25]])


def test_a_side_and_a_rear_that_meet_in_a_blind_corner_are_one_vehicle():
    assert are_one(pieces((2.0, 2.3, 0.0, 5.8, 0.2), (-2.9, 3.4, np.pi / 2, 2.3, 0.1), speed=12.0))


@pytest.mark.parametrize(
    "other",
    [
        pieces(CAB, TRAILER, speed=2.0),
        pieces(CAB, TRAILER, speed=[15.0, 12.0]),
        pieces(CAB, TRAILER, hits=4),
        pieces(CAB, (5.0, -0.5, 0.0, 10.0, 2.5)),
        pieces(CAB, (-4.0, 3.0, 0.0, 10.0, 2.5)),
        pieces((10.0, 3.0, 0.0, 4.5, 1.8), (0.0, 3.0, 0.0, 4.5, 1.8), speed=12.0),
        pieces(CAB, (5.0, 3.0, 0.4, 10.0, 0.1)),
        pieces(CAB, (10.0, 3.0, 0.2, 4.0, 0.3)),
        pieces(CAB, (10.0, 3.0, np.pi / 4, 2.0, 0.3)),
    ],
    ids=[
        *("slow queue", "another speed", "few observations", "next lane", "20 m", "half a second", "articulated"),
        *("turned by more than a fit's error", "oblique"),
    ],
)
def test_separate_vehicles_are_not_merged(other):
    assert not are_one(other)


@pytest.mark.parametrize("turn", [-0.08, 0.08, np.pi / 2 + 0.08])
def test_pieces_turned_by_a_fits_error_are_one_vehicle(turn):
    assert are_one(pieces(CAB, (10.0, 3.0, turn, 2.0, 0.3)))


def test_segments_inside_a_vehicle_are_merged():
    """Two pieces of a vehicle, a car beside it, an object half inside, and points of no segment."""
    cab, trailer = [[13.0, 1.8], [14.0, 1.8]], [[1.0, 1.8], [9.0, 1.7]]
    car, half, loose = [[5.0, -1.0], [8.0, -1.0]], [[15.1, 4.0], [19.0, 4.0]], [[5.0, 3.0]]
    points = np.array(car + cab + half + trailer + loose)
    segments = Segments(label=np.array([0, 0, 1, 1, 2, 2, 3, 3, -1]), count=4)
    whole = pieces((7.6, 3.0, 0.0, 15.2, 2.5))
    merged = merge_segments(points, segments, whole)
    assert merged.count == 3
    assert merged.label.tolist() == [0, 0, 1, 1, 2, 2, 1, 1, -1]


def test_a_vehicle_outside_the_scan_merges_no_segments():
    segments = Segments(label=np.array([0, 1]), count=2)
    merged = merge_segments(np.array([[0.0, 0.0], [5.0, 0.0]]), segments, pieces((90.0, 0.0, 0.0, 12.0, 2.5)))
    assert merged.label.tolist() == [0, 1]


def test_segments_joined_by_a_shared_one_are_one_vehicle():
    """The first box holds the last two segments, the second box the first and the last one."""
    points = np.array([[0.0, 0.0], [10.0, 0.0], [5.0, 0.0]])
    both = pieces((7.5, 0.0, 0.0, 7.0, 2.0), (2.5, 0.0, 0.0, 7.0, 2.0))
    merged = merge_segments(points, Segments(label=np.array([0, 1, 2]), count=3), both)
    assert (merged.count, merged.label.tolist()) == (1, [0, 0, 0])
