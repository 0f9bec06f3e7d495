"""Cells of the wall memory, and free space by the returns of a scan."""

import numpy as np
import pytest

from luxloop.tracker.detection.background import CellMemory
from luxloop.tracker.free_space import BINS, COVERED, UNIT_OFFSET_M
from luxloop.tracker.free_space import free as free_places


@pytest.mark.parametrize("point", [(0.1, 0.2), (-0.1, 0.2), (0.3, -7.9), (-1200.3, -3000.7), (1e6, -1e6)])
def test_the_centre_of_a_cell_is_within_half_a_cell_of_its_points(point):
    memory = CellMemory(0.5)
    memory.strengthen(memory.cell(np.array([point])), 1.0, 2.0)
    assert np.abs(memory.centers()[0] - point).max() <= 0.25
    assert memory.contains(memory.cell(memory.centers())).all()


def test_evidence_is_added_up_to_its_limit_and_small_evidence_is_forgotten():
    memory = CellMemory(1.0)
    both = np.sort(memory.cell(np.array([[0.5, 0.5], [4.5, 0.5]])))
    memory.strengthen(both, 0.8, 2.0)
    memory.strengthen(both[:1], 0.8, 2.0)
    assert memory.log_odds.tolist() == pytest.approx([1.6, 0.8])
    memory.strengthen(both[:1], 0.8, 2.0)
    assert memory.log_odds.tolist() == pytest.approx([2.0, 0.8])
    memory.weaken(np.array([0.5, 0.0]), 0.5, 0.45)
    assert memory.cells.tolist() == both[:1].tolist()
    assert memory.log_odds.tolist() == pytest.approx([0.5])


def ring(range_m, low_deg=0.0, high_deg=360.0):
    angle = np.radians(np.arange(low_deg, high_deg, 0.25))
    return range_m * np.stack([np.cos(angle), np.sin(angle)], axis=1)


def free(place, *returns):
    return bool(free_places(np.array([place], dtype=float), np.concatenate(returns), 1.0)[0])


def test_a_place_before_all_returns_is_free_and_one_among_or_behind_them_is_not():
    assert free((10.0, 0.0), ring(15.0))
    assert free((0.0, -10.0), ring(11.5))
    assert not free((10.0, 0.0), ring(10.5))
    assert not free((10.0, 0.0), ring(5.0))


def test_a_near_object_that_may_hide_the_place_from_a_unit_keeps_it():
    """At 10 m, a unit 2.5 m beside the centre sees the place in a direction 14.5 degrees = asin(0.25) off."""
    assert not free((10.0, 0.0), ring(15.0), ring(5.0, 12.0, 14.0))
    assert free((10.0, 0.0), ring(15.0), ring(5.0, 16.0, 18.0))


def test_open_sky_and_places_at_the_ego_say_nothing():
    assert not free((10.0, 0.0), ring(15.0, 90.0, 270.0))
    assert not free((10.0, 0.0), ring(15.0, 0.0, 5.0))
    assert not free((1.0, 0.0), ring(15.0))
    assert not free((10.0, 0.0), np.zeros((5, 2)))


def test_windows_equal_a_search_over_all_returns():
    rng = np.random.default_rng(3)
    places, returns = rng.uniform(-40.0, 40.0, (300, 2)), rng.uniform(-45.0, 45.0, (400, 2))
    range_m, far = np.hypot(*returns.T), np.hypot(*places.T)
    bins = np.floor(np.arctan2(returns[:, 1], returns[:, 0]) / (2 * np.pi) * BINS).astype(int) % BINS
    expected = []
    for place, distance in zip(places, far, strict=True):
        half = np.arcsin(min(1.0, UNIT_OFFSET_M / distance))
        first = int(np.floor((np.arctan2(place[1], place[0]) - half) / (2 * np.pi) * BINS))
        window = [(first + i) % BINS for i in range(max(1, int(np.ceil(half / np.pi * BINS))))]
        inside = np.isin(bins, window) & (range_m > UNIT_OFFSET_M)
        covered = len(set(bins[inside])) >= COVERED * len(window)
        expected.append(distance > UNIT_OFFSET_M and covered and (range_m[inside] > distance + 1.0).all())
    assert 5 < sum(expected) < 295
    assert free_places(places, returns, 1.0).tolist() == expected
