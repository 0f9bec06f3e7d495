"""The table of tracks: rows are independent of each other."""

from dataclasses import fields

import numpy as np
import pytest
from support.one_track import CAR, CONFIG, DT, OneTrack, flow_of, follow, joined, start, straight
from support.seen import observe_boxes

from luxloop.tracker.records import MODELS
from luxloop.tracker.tracking.correction import correct
from luxloop.tracker.tracking.filters import motion
from luxloop.tracker.tracking.hypotheses import HypothesisConfig, Predictions, hypothesise
from luxloop.tracker.tracking.mma import MmaConfig
from luxloop.tracker.tracking.prediction import predict
from luxloop.tracker.tracking.track_observation import assigned
from luxloop.tracker.tracking.track_table import TrackTable, empty

COLUMNS = [field.name for field in fields(TrackTable)[1:]]


def arc(speed, yaw_rate, frames):
    """Return (K, 3) poses of a vehicle that turns."""
    yaw = yaw_rate * DT * np.arange(1, frames + 1)
    radius = speed / yaw_rate
    return np.stack([20.0 + radius * np.sin(yaw), 3.5 + radius * (1.0 - np.cos(yaw)), yaw], axis=1)


def mixed_traffic(mma):
    """Return tracks that stand, drive straight on and turn, and a new one."""
    tracks = [start((20.0, 3.5, 0.0), mma=mma) for _ in range(4)]
    follow(tracks[0], straight((20.0, 3.5, 0.0), 0.0, 12))
    follow(tracks[1], arc(9.0, 0.01, 12))
    follow(tracks[2], arc(9.0, 0.6, 12))
    return tracks


def boxes_near(tracks):
    """A box near each track, with a jump or a truncated side."""
    found = []
    for k, track in enumerate(tracks):
        boxes = track.table.boxes(track.table.size)
        place = np.add([*boxes.center[0], boxes.heading[0]], (0.1 * k, 1.5 * (k == 2), 0.01 * k))
        found.append(observe_boxes(place, CAR, cut=(k % 3 == 1, False, False, k % 2 == 0)))
    return found


def assert_equal(one, other):
    """Compare all bits of two tables."""
    for name in COLUMNS:
        np.testing.assert_array_equal(getattr(one, name), getattr(other, name), name)


@pytest.mark.parametrize("method", ["mma", "imm", "average", "paper"])
def test_a_row_changes_as_in_a_table_of_its_own(method):
    tracks = mixed_traffic(MmaConfig(method=method))
    table, selection = joined(tracks), tracks[0].selection
    for _ in range(3):
        predict(table, motion(DT, CONFIG.filters), selection, CONFIG)
        for track in tracks:
            track.predict()
        for k, seen in enumerate(boxes_near(tracks)):
            tracks[k].correct(seen)
            hypotheses = hypothesise(Predictions.of(table), seen, HypothesisConfig())
            correct(table, assigned(hypotheses, seen, [(k, 0)]), selection, CONFIG, DT)
    assert_equal(table, joined(tracks))


def test_all_rows_are_corrected_at_once_as_one_by_one():
    tracks = mixed_traffic(MmaConfig())
    for track in tracks:
        track.predict()
    table, boxes = joined(tracks), [observe_boxes((20.0 + 0.2 * k, 3.5, 0.01 * k), CAR) for k in range(len(tracks))]
    places = np.concatenate([seen.center for seen in boxes])
    seen = observe_boxes(np.column_stack([places, 0.01 * np.arange(len(tracks))]), np.tile(CAR, (len(tracks), 1)))
    hypotheses = hypothesise(Predictions.of(table), seen, HypothesisConfig())
    pairs = [(k, k) for k in range(len(tracks))]
    correct(table, assigned(hypotheses, seen, pairs), tracks[0].selection, CONFIG, DT)
    for track, one in zip(tracks, boxes, strict=True):
        track.correct(one)
    assert_equal(table, joined(tracks))


def test_no_observations_change_nothing():
    track = start((20.0, 3.5, 0.0))
    before = track.table.subset(np.arange(1))
    seen = observe_boxes((20.0, 3.5, 0.0), CAR)
    hypotheses = hypothesise(Predictions.of(track.table), seen, HypothesisConfig())
    correct(track.table, assigned(hypotheses, seen, []), track.selection, CONFIG, DT)
    assert_equal(track.table, before)


def test_a_subset_is_a_copy():
    table = empty(MODELS, rows=2)
    part = table.subset(np.array([1]))
    for name in COLUMNS:
        getattr(part, name)[:] = 1
    assert_equal(table, empty(MODELS, rows=2))


def test_a_table_of_no_tracks_has_valid_boxes():
    none = empty(MODELS)
    boxes = none.boxes(none.size)
    assert (boxes.center.shape, boxes.heading.shape, boxes.size.shape) == ((0, 2), (0,), (0, 2))
    assert none.within(np.zeros((3, 2))).shape == (3, 0)
    assert OneTrack(observe_boxes((20.0, 3.5, 0.0), CAR), flow_of()).table.joined([]).id.tolist() == [0]
