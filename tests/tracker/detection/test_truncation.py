"""Truncation by occluders, from the order of the sweep."""

import numpy as np
import pytest

from tracker.detection.truncation import TruncationConfig, cut_off
from tracker.records import Segments
from tracker.scan import Scan

BEAM_S = 0.000111
"""Half a degree of a sweep at 12.5 Hz."""


def sweep(range_m, label, beams=None, unit=None):
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
    )
    return scan, Segments(label=np.array(label), count=max(label) + 1)


def cut(range_m, label, **keys):
    scan, segments = sweep(np.array(range_m, dtype=float), label, **keys)
    return np.flatnonzero(cut_off(scan, np.ones(len(scan), bool), segments, TruncationConfig())).tolist()


EDGES = [0, 7]
"""The first and the last return of a layer, which always count as truncated."""


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


def test_points_without_times_have_no_neighbours():
    scan, segments = sweep(np.array([20.0, 20.0, 10.0, 10.0]), [0, 0, 1, 1])
    scan.time_offset[:] = 0.0
    assert not cut_off(scan, np.ones(4, bool), segments, TruncationConfig()).any()


def test_an_empty_scan():
    scan, _ = sweep(np.empty(0), [0])
    assert cut_off(scan, np.empty(0, bool), Segments(np.empty(0, np.int64), 0), TruncationConfig()).shape == (0,)


@pytest.mark.parametrize("values", [{"neighbour_s": -1.0}, {"nearer_m": 0.0}])
def test_invalid_settings_are_rejected_by_name(values):
    with pytest.raises(ValueError, match=next(iter(values))):
        TruncationConfig(**values)
