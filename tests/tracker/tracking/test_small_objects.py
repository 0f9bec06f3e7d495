"""Tracks of small road users: confirmed by motion, with the size of a person or a bicycle."""

import numpy as np
import pytest
from support.few import few

from luxloop.tracker.records import MODELS, SmallBoxes, Status
from luxloop.tracker.tracking import small_tracks
from luxloop.tracker.tracking.mma import MmaConfig
from luxloop.tracker.tracking.model_selection import model_selection
from luxloop.tracker.tracking.output import report
from luxloop.tracker.tracking.small_objects import FIRST_ID, SmallObjects
from luxloop.tracker.tracking.track_table import empty

DT = 0.08
NOISE_M = 0.05
NONE = empty(MODELS)


def boxes(centers, size=(0.4, 0.3), heading=0.0):
    count = len(centers)
    return SmallBoxes(
        segment=np.arange(count),
        center=np.array(centers, dtype=float).reshape(count, 2),
        heading=np.full(count, heading),
        size=np.tile(size, (count, 1)).astype(float),
        time_offset=np.zeros(count),
    )


def track(paths, frames=40, size=(0.4, 0.3), seed=1):
    """Return the records of all frames; `paths` give a position by time, or None for no box."""
    objects, rng, out = SmallObjects(), np.random.default_rng(seed), []
    for frame in range(frames):
        places = [path(frame * DT) for path in paths]
        seen = [np.array(place) + rng.normal(0.0, NOISE_M, 2) for place in places if place is not None]
        objects.step(boxes(seen, size), NONE, DT if frame else 0.0)
        out.append(objects.report(NONE, report(NONE, model_selection(MmaConfig())), np.zeros(2)))
    return out


def walker(speed, y=8.0):
    return lambda t: (2.0 + speed * t, y)


def test_walker_is_confirmed_with_its_speed():
    records = track([walker(1.34)])
    first = next(index for index, tracks in enumerate(records) if len(tracks))
    # 0.8 m take 0.6 s; the filter's delay adds less than half a second.
    assert 0.6 <= first * DT <= 1.1
    last = records[-1]
    assert last.id.tolist() == [FIRST_ID]
    assert last.small.tolist() == [True]
    assert last.status.tolist() == [Status.CONFIRMED]
    assert last.mean[0, 2:4] == pytest.approx([1.34, 0.0], abs=0.35)
    assert last.mean[0, :2] == pytest.approx([2.0 + 1.34 * 39 * DT, 8.0], abs=0.25)
    assert last.size[0].tolist() == [0.5, 0.5]


@pytest.mark.parametrize("seed", few(range(20), *range(5)))
def test_pole_is_never_confirmed(seed):
    assert not any(len(tracks) for tracks in track([walker(0.0)], frames=120, seed=seed))


def test_fast_one_is_a_rider():
    assert track([walker(5.0)])[-1].size[0].tolist() == [1.7, 0.6]


def test_wide_across_its_motion_is_no_small_road_user():
    """The rear of a car, 1.7 m across its motion along x."""
    assert not any(len(tracks) for tracks in track([walker(5.0)], size=(0.3, 1.7)))


def test_long_along_its_motion_is_a_bicycle():
    assert track([walker(5.0)], size=(1.7, 0.3))[-1].size[0].tolist() == [1.7, 0.6]


def test_track_survives_a_short_occlusion_and_coasts():
    path = walker(1.34)
    records = track([lambda t: None if 2.0 < t < 2.7 else path(t)], frames=50)
    hidden = records[round(2.6 / DT)]
    assert hidden.status.tolist() == [Status.COASTING]
    assert {one for tracks in records for one in tracks.id.tolist()} == {FIRST_ID}


def test_track_ends_after_a_second_unseen():
    path = walker(1.34)
    assert not len(track([lambda t: None if t > 2.0 else path(t)], frames=45)[-1])


def test_two_walkers_keep_their_ids_when_they_pass():
    records = track([walker(1.34, 8.0), lambda t: (6.0 - 1.34 * t, 9.2)], frames=45)
    ids = {tuple(sorted(tracks.id.tolist())) for tracks in records if len(tracks) == 2}
    assert len(ids) == 1
    first = min(ids.pop())
    y = [tracks.mean[tracks.id == first, 1][0] for tracks in records if first in tracks.id]
    assert max(y) - min(y) < 0.6


def test_hidden_part_of_a_bicycle_lies_behind_its_visible_end():
    """The rear of a bicycle 10 m ahead is visible, 0.3 m of 1.7: its centre is 0.7 m further on."""
    objects = SmallObjects()
    for frame in range(60):
        objects.step(boxes([(10.0 + 5.0 * frame * DT, 0.0)], (0.3, 0.6)), NONE, DT if frame else 0.0)
    record = objects.report(NONE, report(NONE, model_selection(MmaConfig())), np.zeros(2))
    assert record.mean[0, 0] == pytest.approx(10.0 + 5.0 * 59 * DT + 0.7, abs=0.1)


def test_box_is_moved_to_the_time_of_the_scan():
    """Points that are 0.04 s old lie 0.2 m behind a bicycle of 5 m/s."""
    objects = SmallObjects()
    for frame in range(60):
        late = boxes([(10.0 + 5.0 * (frame * DT - 0.04), 0.0)], (1.7, 0.6))
        objects.step(SmallBoxes(late.segment, late.center, late.heading, late.size, np.array([-0.04])), NONE, DT)
    record = objects.report(NONE, report(NONE, model_selection(MmaConfig())), np.zeros(2))
    assert record.mean[0, 0] == pytest.approx(10.0 + 5.0 * 59 * DT, abs=0.05)


def test_the_way_of_a_track_has_its_predicted_part():
    """A box at the predicted place moves the estimate by nothing, and the person by a step."""
    tracks = small_tracks.start(boxes([(8.0, 2.0)]), FIRST_ID)
    tracks.mean[0, 2:] = 1.5, 2.0
    for step in range(1, 5):
        small_tracks.predict(tracks, DT)
        ahead = boxes([(8.0 + 1.5 * DT * step, 2.0 + 2.0 * DT * step)])
        small_tracks.update(tracks, ahead, np.array([0]), np.array([0]))
    assert tracks.way_m[0] == pytest.approx(4 * 2.5 * DT)


def test_the_way_of_a_track_joins_its_estimates_at_successive_observations():
    """Boxes lie ahead of the predicted places, beside them and behind them; one scan of each pair has no box."""
    tracks = small_tracks.start(boxes([(8.0, 2.0)]), FIRST_ID)
    tracks.mean[0, 2:] = 1.5, 2.0
    way, rows = 0.0, np.array([0])
    for apart in ((0.3, 0.4), (0.4, -0.3), (-0.3, -0.4)):
        before = tracks.mean[0, :2].copy()
        small_tracks.predict(tracks, DT)
        small_tracks.predict(tracks, DT)
        small_tracks.update(tracks, boxes([tracks.mean[0, :2] + apart]), rows, rows)
        way += float(np.linalg.norm(tracks.mean[0, :2] - before))
    assert tracks.way_m[0] == pytest.approx(way)
