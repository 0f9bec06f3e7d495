import numpy as np
import pytest

from luxloop.tracker.detection.background import Background, BackgroundConfig, extents
from luxloop.tracker.detection.segmentation import keep_only
from luxloop.tracker.records import Segments

CONFIG = BackgroundConfig()


def line(start, end, count=40):
    return np.linspace(start, end, count)


def segments_of(*pieces):
    labels = [np.full(len(piece), i) for i, piece in enumerate(pieces)]
    return np.concatenate(pieces), Segments(label=np.concatenate(labels).astype(np.int64), count=len(pieces))


WALL = line((-15.0, 10.0), (15.0, 10.0), 120)
CAR = line((3.0, 4.0), (7.5, 4.0))


def test_a_wall_is_removed_and_a_car_in_front_of_it_is_kept():
    points, segments = segments_of(WALL, CAR)
    left = Background(CONFIG).remove(points, segments)
    assert left.count == 1
    assert (left.label == np.where(segments.label == 1, 0, -1)).all()


@pytest.mark.parametrize("length", [12.0, 18.0])
@pytest.mark.parametrize("angle_deg", [0.0, 11.0, 45.0])
def test_the_longest_vehicles_are_not_background(length, angle_deg):
    angle = np.radians(angle_deg)
    points, segments = segments_of(line((0.0, 8.0), (length * np.cos(angle), 8.0 + length * np.sin(angle))))
    assert Background(CONFIG).remove(points, segments).count == 1


def test_a_piece_of_a_known_wall_is_removed_and_an_unknown_one_is_kept():
    background = Background(CONFIG)
    background.remove(*segments_of(WALL))
    piece, other = line((2.0, 10.1), (6.0, 10.1)), line((2.0, 12.1), (6.0, 12.1))
    assert background.remove(*segments_of(piece)).count == 0
    assert background.remove(*segments_of(other)).count == 1


def test_a_car_that_touches_a_known_wall_is_kept():
    background = Background(CONFIG)
    background.remove(*segments_of(WALL))
    across = line((4.0, 5.5), (4.0, 10.2))  # its front touches the wall
    assert background.remove(*segments_of(across)).count == 1


def test_an_empty_scan_has_no_background():
    empty = Segments(label=np.full(3, -1), count=0)
    assert Background(CONFIG).remove(np.zeros((3, 2)), empty).count == 0


@pytest.mark.parametrize("angle", np.linspace(0.0, np.pi, 9))
def test_extent_is_the_diameter_within_two_percent(angle):
    points = np.array([[0.0, 0.0], [20 * np.cos(angle), 20 * np.sin(angle)], [10 * np.cos(angle), 10 * np.sin(angle)]])
    assert 19.6 <= extents(points, np.zeros(3, dtype=np.int64))[0] <= 20.0 + 1e-9


def test_keep_only_renumbers_segments_in_order():
    segments = Segments(label=np.array([2, -1, 0, 1, 2]), count=3)
    left = keep_only(segments, np.array([True, False, True]))
    assert left.label.tolist() == [1, -1, 0, -1, 1]
    assert left.count == 2
