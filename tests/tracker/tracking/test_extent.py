import numpy as np
import pytest

from luxloop.tracker.records import MODELS
from luxloop.tracker.tracking.track_table import empty
from luxloop.tracker.tracking.vehicle_size import GROWTH, SETTLED_GROWTH, known, remember
from luxloop.tracker.vehicle_classes import FACE_MIN_M

WHOLE, CUT = (True, True), (False, False)


def seen(*observations):
    """Remembered extents after observations ((along, across), mask of whole sides)."""
    extents, views, gains = [float(side) for side in observations[0][0]], [0, 0], (GROWTH, SETTLED_GROWTH)
    for observed, whole in observations[1:]:
        for axis in range(2):
            view = float(observed[axis]), whole[axis], views[axis]
            extents[axis] = remember(extents[axis], *view, gains)
            views[axis] += whole[axis] and observed[axis] > FACE_MIN_M
    return extents


def test_a_seen_side_keeps_its_length_behind_an_occluder():
    assert seen(((4.5, 1.7), WHOLE), *[((1.0, 1.7), CUT)] * 200)[0] == 4.5


def test_a_side_that_faces_away_keeps_its_length():
    """Only the rear is visible: a visible length of 0.1 m without truncation has no effect on the length."""
    assert seen(((4.5, 1.7), WHOLE), *[((0.1, 1.7), WHOLE)] * 200)[0] == 4.5


def test_longer_observations_increase_the_size_with_decreasing_gain():
    assert seen(((2.0, 1.7), CUT), *[((4.8, 1.7), CUT)] * 30)[0] == pytest.approx(4.8, abs=0.01)


def test_the_size_of_two_merged_vehicles_recovers_after_a_whole_view():
    assert seen(((9.7, 1.7), WHOLE), *[((5.9, 1.7), WHOLE)] * 150)[0] == pytest.approx(5.9, abs=0.1)


def test_a_single_outlier_has_little_effect_after_many_whole_views():
    assert seen(((4.5, 1.7), WHOLE), *[((4.5, 1.7), WHOLE)] * 20, ((4.5, 3.3), WHOLE))[1] < 1.8


def test_sizes_above_a_car():
    sizes = [(4.8, 1.9), (1.9, 4.8), (2.5, 3.0), (6.5, 0.1), (0.1, 6.5)]
    tracks = empty(MODELS, rows=len(sizes))
    tracks.visible_size[:] = sizes
    assert tracks.long.tolist() == [False, False, False, True, True]


def test_a_side_is_known_after_most_of_it_was_seen():
    size = np.array([4.5, 1.8])
    assert known(np.array([4.2, 0.3]), size) == pytest.approx([4.5, 0.3])
