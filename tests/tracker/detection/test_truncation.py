"""Truncation by occluders, from the order of the sweep."""

from dataclasses import replace

import numpy as np
import pytest

from luxloop.tracker.detection.truncation import TruncationConfig, cut_off
from luxloop.tracker.records import Segments
from luxloop.tracker.scan import Scan

BEAM_S = 0.000111
"""Half a degree of a sweep at 12.5 Hz."""


RANGE_MAX_M = 200.0


def sweep(range_m, label, beams=None, unit=None, limits=None):
    """A layer with its unit at the ego's centre: range and segment of the points on successive beams."""
    count = len(range_m)
    beams = np.arange(count) if beams is None else np.asarray(beams)
    azimuth = 0.3 - np.deg2rad(0.5) * beams
    nothing = np.zeros(count)
    scan = Scan(
        time=0.0,
        ego_pose_odom=np.zeros(3),
        points_ego=np.stack([range_m * np.cos(azimuth), range_m * np.sin(azimuth), nothing], 1).astype(np.float32),
        time_offset=(BEAM_S * (beams - 3.5)).astype(np.float32),
        unit=np.zeros(count, np.uint8) if unit is None else np.asarray(unit, np.uint8),
        layer=nothing.astype(np.uint8),
        echo=nothing.astype(np.uint8),
        echo_pulse_width=np.ones(count, np.float32),
        flags=nothing.astype(np.uint16),
        sweep_limits=limits,
    )
    return scan, Segments(label=np.array(label), count=max(label) + 1)


def cut(range_m, label, **keys):
    scan, segments = sweep(np.array(range_m, dtype=float), label, **keys)
    return np.flatnonzero(cut_off(scan, np.ones(len(scan), bool), segments, RANGE_MAX_M, TruncationConfig())).tolist()


def fields_of_view(*beams):
    """Return (U, 1, 2) limits of fields of view of units with one layer, from their first and last beams."""
    return (BEAM_S * (np.array(beams, dtype=np.float32) - 3.5)).reshape(-1, 1, 2).astype(np.float32)


EDGES = [0, 7]
"""The first and the last return of a layer, which count as truncated if its field of view is unknown."""


def test_the_farther_object_is_truncated_and_the_nearer_is_not():
    assert cut([20, 20, 20, 10, 10, 20, 20, 20], [0, 0, 0, 1, 1, 2, 2, 2]) == [0, 2, 5, 7]


def test_parts_of_one_object_do_not_truncate_it():
    assert cut([20, 20, 20, 18, 18, 20, 20, 20], [0] * 8) == EDGES


@pytest.mark.parametrize(("lost", "found"), [(1, [0, 3, 7]), (2, EDGES)])
def test_neighbours_may_be_one_lost_beam_apart_but_not_two(lost, found):
    beams = np.arange(8) + np.where(np.arange(8) > 3, lost, 0)
    assert cut([20, 20, 20, 20, 10, 10, 10, 10], [0] * 4 + [1] * 4, beams=beams) == found


def test_units_are_independent():
    assert cut([20, 20, 20, 20, 10, 10, 10, 10], [0] * 4 + [1] * 4, unit=[0] * 4 + [1] * 4) == [0, 3, 4, 7]


def test_layers_that_fire_together_are_independent():
    """Two layers in the order of the sweep: an occluder in each of them, a beam apart, truncates what is behind it."""
    lower, upper = [20, 20, 20, 10, 10, 20, 20, 20], [21, 21, 21, 21, 10, 10, 21, 21]
    range_m, label = np.stack([lower, upper], 1).ravel(), np.stack([np.array(lower) < 15, np.array(upper) < 15], 1)
    scan, segments = sweep(range_m.astype(float), label.ravel().astype(int).tolist(), beams=np.repeat(np.arange(8), 2))
    scan = replace(scan, layer=np.tile([0, 1], 8).astype(np.uint8))
    found = np.flatnonzero(cut_off(scan, np.ones(16, bool), segments, RANGE_MAX_M, TruncationConfig()))
    assert found[found % 2 == 0].tolist() == [2 * beam for beam in (0, 2, 5, 7)]
    assert found[found % 2 == 1].tolist() == [2 * beam + 1 for beam in (0, 3, 6, 7)]


def test_points_without_times_have_no_neighbours():
    scan, segments = sweep(np.array([20.0, 20.0, 10.0, 10.0]), [0, 0, 1, 1])
    scan.time_offset[:] = 0.0
    assert not cut_off(scan, np.ones(4, bool), segments, RANGE_MAX_M, TruncationConfig()).any()


def test_an_empty_scan():
    scan, _ = sweep(np.empty(0), [0])
    nothing = Segments(np.empty(0, np.int64), 0)
    assert cut_off(scan, np.empty(0, bool), nothing, RANGE_MAX_M, TruncationConfig()).shape == (0,)


def test_an_end_beside_free_space_is_whole_and_one_at_the_edge_of_the_field_of_view_is_not():
    """The sweep goes on for 40 beams before and after the object, or it starts with its first beam."""
    assert cut([20] * 8, [0] * 8, limits=fields_of_view((-40, 47))) == []
    assert cut([20] * 8, [0] * 8, limits=fields_of_view((0, 47))) == [0, 1, 2]
    assert cut([20] * 8, [0] * 8, limits=fields_of_view((-40, 7))) == [5, 6, 7]


@pytest.mark.parametrize(("before", "truncated"), [(2, [0]), (3, [])])
def test_two_beam_spacings_from_the_edge_are_the_edge(before, truncated):
    """0.25 ms are 2.25 spacings of 0.111 ms: one beam may be lost."""
    assert cut([20] * 8, [0] * 8, limits=fields_of_view((-before, 47))) == truncated


def test_fields_of_view_belong_to_their_units():
    limits = fields_of_view((0, 47), (-40, 7))
    assert cut([20] * 8, [0] * 8, unit=[0] * 4 + [1] * 4, limits=limits) == [0, 1, 2, 5, 6, 7]
    assert cut([20] * 8, [0] * 8, unit=[1] * 4 + [0] * 4, limits=limits) == []


def test_occluders_truncate_within_a_known_field_of_view():
    limits = fields_of_view((-40, 47))
    assert cut([20, 20, 20, 10, 10, 20, 20, 20], [0, 0, 0, 1, 1, 2, 2, 2], limits=limits) == [2, 5]


def test_points_near_the_maximum_range_are_truncated():
    """0.5 m before it, an object may continue where no point is kept."""
    far = [199.4, 199.6, 199.9, 199.4, 199.4, 199.4, 199.4, 199.4]
    assert cut(far, [0] * 8, limits=fields_of_view((-40, 47))) == [1, 2]


@pytest.mark.parametrize("values", [{"neighbour_s": -1.0}])
def test_invalid_settings_are_rejected_by_name(values):
    with pytest.raises(ValueError, match=next(iter(values))):
        TruncationConfig(**values)


def test_fields_of_view_of_a_second_unit_do_not_depend_on_the_layers_with_returns():
    """Both units have two layers, of which only the lower one has returns."""
    limits = fields_of_view((0, 47), (-40, 47), (-40, 7), (-40, 47)).reshape(2, 2, 2)
    assert cut([20] * 8, [0] * 8, unit=[0] * 4 + [1] * 4, limits=limits) == [0, 1, 2, 5, 6, 7]
