"""Second observation of new tracks: fast vehicles at any rate of scans."""

import numpy as np
import pytest
from support.driven_cars import SIZE, confirmed, driven, scan_of
from support.few import few
from support.one_track import CAR, DT, start
from support.seen import observe_boxes

from luxloop.tracker.records import MODELS
from luxloop.tracker.tracker import Tracker, TrackerConfig
from luxloop.tracker.tracking.births import nearby, second_views
from luxloop.tracker.tracking.confirmation import ConfirmationConfig
from luxloop.tracker.tracking.hypotheses import HypothesisConfig, Predictions, hypothesise
from luxloop.tracker.tracking.track_table import empty

HALF = 0.5 * np.array(SIZE)
AHEAD = np.array([4.0, 0.0, 0.0])


def new_track(pose):
    """Return the prediction of a track that was seen once, with its rear right corner tracked."""
    one = np.ones((1, 1))
    cos, sin = np.cos(pose[2]), np.sin(pose[2])
    corner = np.array(pose[:2]) + np.array([[cos, -sin], [sin, cos]]) @ (-HALF)
    return Predictions(
        position=corner[None, None], velocity=np.zeros((1, 1, 2)), covariance=np.eye(2)[None, None], probability=one,
        heading=np.array([pose[2]]), heading_variance=np.array([4e-4]), size=np.array([SIZE]),
        known_size=np.array([SIZE]), whole=np.zeros((1, 2), dtype=bool), corner_sign=np.array([[-1, -1]]),
    )  # fmt: skip


def may_be(first, second, age_s=0.08, size=SIZE):
    """True if a car at `first` may be seen at `second` after `age_s`."""
    tracks, seen = new_track(first), observe_boxes(second, size)
    hypotheses = hypothesise(tracks, seen, HypothesisConfig())
    return bool(second_views(tracks, hypotheses, seen, np.array([age_s]), np.array([SIZE]))[0, 0])


@pytest.mark.parametrize(
    ("moved", "age_s", "expected"),
    [
        ((5.6, 0.0, 0.0), 0.08, True),  # 70 m/s
        ((6.4, 0.0, 0.0), 0.08, False),  # 80 m/s
        ((6.4, 0.0, 0.0), 0.25, True),  # the same way at 4 Hz
        ((-5.6, 0.0, 0.0), 0.08, True),  # the first direction of a vehicle is a guess
        ((4.0, 4.0, 0.0), 0.08, False),  # no vehicle slides diagonally
        ((5.6, 0.4, 0.0), 0.08, True),
        ((5.6, 0.0, 0.4), 0.08, False),  # nor turns by 290 degrees in a second
    ],
)
def test_a_vehicle_moves_along_an_axis(moved, age_s, expected):
    first = np.array([20.0, 10.0, 0.0])
    assert may_be(first, first + moved, age_s) is expected


def test_a_box_of_another_size_is_another_vehicle():
    first = np.array([20.0, 10.0, 0.0])
    assert may_be(first, first + AHEAD, size=(4.3, 1.6))
    assert not may_be(first, first + AHEAD, size=(8.0, 2.5))


@pytest.mark.parametrize(("moved_m", "expected"), [(0.9, True), (1.1, False)])
def test_the_gate_decides_at_the_place_of_the_track(moved_m, expected):
    tracks, seen = new_track((20.0, 10.0, 0.0)), observe_boxes((20.0, 10.0 + moved_m, 0.0), SIZE)
    assert bool(nearby(hypothesise(tracks, seen, HypothesisConfig()))[0, 0]) is expected


def test_no_tracks_have_no_second_views():
    none, seen = Predictions.of(empty(MODELS)), observe_boxes((5.0, 5.0, 0.0), SIZE)
    hypotheses = hypothesise(none, seen, HypothesisConfig())
    assert second_views(none, hypotheses, seen, np.zeros(0), np.zeros((0, 2))).shape == (0, 1)
    assert nearby(hypotheses).shape == (0, 1)


@pytest.mark.parametrize("offsets_s", [(0.0, 0.0), (-0.03, 0.02), (0.03, -0.02)])
def test_the_speed_of_two_views_is_over_the_time_between_them(offsets_s):
    """The boxes are at their places at their own times; the track is at the times of the scans."""
    speed_mps, one_track = 40.0, start((20.0, 10.0, 0.0), time_offset=offsets_s[0])
    moved = speed_mps * (DT + offsets_s[1] - offsets_s[0])
    seen = observe_boxes((20.0 + moved, 10.0, 0.0), CAR, time_offset=offsets_s[1])
    before = one_track.position[0].item()
    one_track.predict()
    one_track.correct(seen)
    at_the_scan = before + speed_mps * (DT - offsets_s[0])
    assert one_track.table.velocity[0, 0] == pytest.approx(speed_mps, rel=0.05)
    assert one_track.position[0] == pytest.approx(at_the_scan, abs=0.1)


@pytest.mark.parametrize("speed_mps", few([20.0, 40.0, 70.0], 20.0, 70.0))
@pytest.mark.parametrize("rate_hz", few([4.0, 12.5, 25.0, 50.0], 4.0, 12.5))
def test_three_cars_in_a_row_keep_their_ids(rate_hz, speed_mps):
    """They pass a stationary ego in the lane beside it, 0.9 s apart: none is mistaken for the next one."""
    dt = 1.0 / rate_hz
    lane = [driven((-48.0 - 0.9 * k * speed_mps, 5.0, 0.0), speed_mps, np.zeros(400), dt) for k in range(3)]
    life = ConfirmationConfig(tentative_coast_s=max(0.2, 1.2 * dt))
    tracker, rng, ids = Tracker(TrackerConfig(confirmation=life)), np.random.default_rng(4), [set(), set(), set()]
    tracked = [0, 0, 0]
    for k in range(int((96.0 + 1.8 * speed_mps) / speed_mps / dt)):
        poses = np.array([car[k] for car in lane])
        near = np.flatnonzero(np.abs(poses[:, 0]) < 48.0)
        if not len(near):
            continue
        tracks, _ = tracker.step(scan_of(poses[near], k * dt, rng))
        sure = confirmed(tracks)
        for car in near.tolist():
            off = np.hypot(*(tracks.center_odom[sure] - poses[car, :2]).T)
            if len(sure) and off.min() < 1.5:
                best = sure[np.argmin(off)]
                ids[car].add(int(tracks.id[best]))
                tracked[car] += 1
                assert tracks.mean[best, 2] == pytest.approx(speed_mps, abs=2.0)
    assert [len(own) for own in ids] == [1, 1, 1]
    assert min(tracked) >= 2
