"""Invalid and unusual scans: the tracker has a defined behaviour for each."""

import math
from dataclasses import replace

import numpy as np
import pytest
from support.shapes import l_shape

from luxloop.tracker.detection.baselines import BaselineConfig
from luxloop.tracker.detection.detector import Detector
from luxloop.tracker.records import METHODS, Status
from luxloop.tracker.scan import Scan
from luxloop.tracker.tracker import Tracker, TrackerConfig

DT = 0.08
SIDE = np.stack([np.linspace(5.0, 9.4, 40), np.full(40, 3.0), np.full(40, 0.6)], axis=1)
CAR = np.vstack([SIDE, np.stack([np.full(20, 5.0), np.linspace(3.0, 4.8, 20), np.full(20, 0.6)], axis=1)])
"""Side and rear of a car: a single stationary side is not confirmed as a car."""
NOTHING = np.empty((0, 3))
GARBAGE = np.array([[np.nan, 1.0, 1.0], [np.inf, -np.inf, 1.0], [6.0, 3.0, np.nan], [np.inf, np.nan, -np.inf]])

with_and_without_baselines = pytest.mark.parametrize("baselines", [False, True], ids=["bare", "baselines"])


def tracker_of(baselines=False):
    return Tracker(TrackerConfig(baselines=BaselineConfig(enabled=baselines)))


def scan_of(points, at, **columns):
    """A scan from an ego that drives a bend at 6 m/s."""
    return Scan.from_points(at, points, (6.0 * at, 0.2 * at, 0.1 * at), **columns)


def same(one, other):
    """Return True if two trackers report identical tracks."""
    fields = ("id", "status", "mean", "covariance", "model_probability", "size")
    return all(np.array_equal(getattr(one, field), getattr(other, field)) for field in fields)


def followed(points=CAR, frames=6):
    """Return a tracker of a stationary object, and its last tracks."""
    tracker = tracker_of()
    for k in range(frames):
        tracks, _ = tracker.step(Scan.from_points(DT * k, points))
    return tracker, tracks


def living(tracks):
    return set(tracks.id[tracks.status != Status.DEAD].tolist())


# --- points


@with_and_without_baselines
@pytest.mark.parametrize(
    ("points", "vehicles"),
    [
        (NOTHING, 0),
        ([[10.0, 2.0, 0.6]], 0),
        ([[10.0, 2.0, 0.6]] * 50, 0),
        (SIDE, 1),
        ([[np.nan] * 3] * 30, 0),
        (GARBAGE, 0),
        (np.concatenate([GARBAGE, SIDE]), 1),
    ],
    ids=["none", "one", "identical", "collinear", "nan", "garbage", "garbage beside a side"],
)
def test_invalid_or_too_few_points_give_no_vehicle_and_collinear_points_a_side(points, vehicles, baselines):
    tracker = tracker_of(baselines)
    for k in range(6):
        tracks, trace = tracker.step(Scan.from_points(DT * k, points, (0.5 * k, 0.0, 0.01 * k), time_offset=0.01))
        assert len(trace.boxes) == len(trace.track_id) == vehicles
        assert np.isfinite(tracks.mean).all()
        assert np.isfinite(tracks.covariance).all()
        assert np.isfinite(trace.candidates.size[:, : len(METHODS)]).all()
    assert bool(len(tracks)) == bool(vehicles)


@pytest.mark.parametrize("first", [True, False])
def test_non_finite_points_have_no_effect(first):
    """Non-finite points precede or follow the valid ones; non-finite times count, too."""
    clean, dirty = tracker_of(), tracker_of()
    unknown_time = np.concatenate([np.zeros(len(GARBAGE)), [np.nan, np.inf]])
    bad = np.concatenate([GARBAGE, [[9.5, 3.0, 0.6], [9.6, 3.0, 0.6]]])
    for k in range(6):
        parts, offsets = (bad, SIDE)[:: 1 if first else -1], (unknown_time, np.full(40, 0.01))[:: 1 if first else -1]
        whole, _ = clean.step(scan_of(SIDE, DT * k, time_offset=0.01))
        mixed, _ = dirty.step(scan_of(np.concatenate(parts), DT * k, time_offset=np.concatenate(offsets)))
        assert same(whole, mixed)
    assert len(whole) == 1


@with_and_without_baselines
def test_a_dense_cluster_of_a_hundred_thousand_points_is_fitted(baselines):
    """A search over all 10^10 pairs would not finish. The fit is as accurate as with few points."""
    rng = np.random.default_rng(0)
    sides = np.repeat(l_shape(0.0, length=4.5, width=1.8, step=0.05), 800, axis=0)[:100_000]
    points = np.column_stack([sides + rng.normal(0.0, 0.025, sides.shape), np.full(len(sides), 0.6)])
    tracker = tracker_of(baselines)
    _, trace = tracker.step(Scan.from_points(DT, points))
    assert len(points) == 100_000
    assert len(trace.boxes) == 1
    assert math.sin(4.0 * trace.boxes.heading[0]) == pytest.approx(0.0, abs=math.radians(2.0))
    assert sorted(trace.boxes.size[0]) == pytest.approx([1.8, 4.5], abs=0.25)


# --- time


@pytest.mark.parametrize("at", [-5.0, 0.0, 0.32, 0.4, 0.4 + 1e-12])
def test_a_time_that_does_not_increase_is_rejected_and_the_tracker_continues(at):
    """A late or repeated scan would be compared with later predictions, or count twice."""
    tracker, before = followed()
    message = rf"scan of {at} s is not later than the one before, of 0\.4 s; drop it, or use a new tracker"
    with pytest.raises(ValueError, match=message):
        tracker.step(Scan.from_points(at, CAR + 1.0))
    after, _ = tracker.step(Scan.from_points(6 * DT, CAR))
    assert same(after, followed(frames=7)[1])
    assert living(after) == living(before)


@pytest.mark.parametrize("first", [-1e6, 0.0, 1.7e9])
def test_a_clock_may_start_anywhere(first):
    """Seconds since 1970, for which a float has a resolution of 2e-7."""
    tracker = tracker_of()
    for k in range(6):
        tracks, _ = tracker.step(Scan.from_points(first + DT * k, CAR))
    assert tracks.status.tolist() == [Status.CONFIRMED]


@pytest.mark.parametrize("then", [CAR, NOTHING], ids=["at once", "a scan later"])
def test_a_gap_of_ten_seconds_terminates_all_tracks(then):
    """A vehicle at the same place after the gap gets a new track."""
    tracker, before = followed()
    tracks, _ = tracker.step(Scan.from_points(10.4, then))
    assert tracks.status[np.isin(tracks.id, before.id)].tolist() == [Status.DEAD]
    for k in range(1, 6):
        after, _ = tracker.step(Scan.from_points(10.4 + DT * k, CAR))
    assert len(after) == 1
    assert not living(after) & living(before)


def test_a_single_gap_below_the_coasting_time_terminates_no_track():
    """The device was silent for 1.5 s, which is no evidence against a track, tentative or not."""
    for frames in (6, 1):
        tracker, before = followed(frames=frames)
        after, _ = tracker.step(Scan.from_points(DT * (frames - 1) + 1.5, CAR))
        assert living(after) == living(before) != set()


@pytest.mark.parametrize(("frames", "taken_up"), [(6, True), (1, False)])
def test_a_scan_without_the_vehicle_in_a_gap_terminates_only_tentative_tracks(frames, taken_up):
    """After six observations a track continues after 1.5 s; after one observation it is tentative."""
    tracker, before = followed(frames=frames)
    end = DT * (frames - 1)
    tracker.step(Scan.from_points(end + 0.75, NOTHING))
    after, _ = tracker.step(Scan.from_points(end + 1.5, CAR))
    assert bool(living(after) & living(before)) == taken_up
    assert len(living(after)) == 1


# --- rejected scans


@pytest.mark.parametrize("pose", [(math.nan, 0.0, 0.0), (0.0, math.inf, 0.0), (0.0, 0.0, math.nan)])
def test_a_non_finite_pose_is_rejected_and_the_tracker_continues(pose):
    """A NaN would propagate to every filter and to the background model."""
    tracker, _ = followed()
    with pytest.raises(ValueError, match=r"ego_pose_odom at 0\.48 s is \[.*extrapolated"):
        tracker.step(replace(Scan.from_points(0.48, CAR), ego_pose_odom=np.array(pose)))
    after, _ = tracker.step(Scan.from_points(0.48, CAR))
    assert same(after, followed(frames=7)[1])


@pytest.mark.parametrize("at", [math.nan, math.inf])
def test_a_non_finite_time_is_rejected(at):
    with pytest.raises(ValueError, match=r"time is (nan|inf); give"):
        tracker_of().step(replace(Scan.from_points(0.0, CAR), time=at))


@pytest.mark.parametrize(
    ("field", "value", "found"),
    [
        ("points_ego", SIDE[:, :2].astype(np.float32), r"float32 \(40, 2\); give an array \(40, 3\) of floats"),
        ("points_ego", SIDE.astype(np.int32), r"int32 \(40, 3\)"),
        ("points_ego", SIDE.tolist(), "list"),
        ("points_ego", SIDE[0], r"float64 \(3,\)"),
        ("ego_pose_odom", np.zeros(2), r"float64 \(2,\); give an array \(3,\)"),
        ("ego_pose_odom", [0.0, 0.0, 0.0], "list"),
        ("time_offset", np.zeros(39), r"float64 \(39,\); give an array \(40,\) of floats"),
        ("unit", np.zeros(40), r"float64 \(40,\); give an array \(40,\) of whole numbers"),
        ("echo", np.zeros((40, 1), np.uint8), r"uint8 \(40, 1\)"),
        ("flags", np.zeros(41, np.uint16), r"uint16 \(41,\)"),
        ("flags", np.array(["ground"] * 40), r"<U6 \(40,\)"),
    ],
)
def test_a_wrong_shape_or_type_is_rejected_by_field_name(field, value, found):
    """Broadcasting or casting would hide the error."""
    for device in (Tracker(), Detector()):
        with pytest.raises(ValueError, match=f"^{field} is {found}"):
            device.step(replace(Scan.from_points(0.0, SIDE), **{field: value}))
        device.step(Scan.from_points(0.0, SIDE))


def test_floats_and_integers_of_other_widths_are_accepted():
    scan = Scan.from_points(0.0, SIDE)
    wide = replace(scan, points_ego=SIDE, time_offset=np.zeros(40), unit=np.zeros(40, int), flags=np.zeros(40, int))
    _, narrow_trace = tracker_of().step(scan)
    _, wide_trace = tracker_of().step(wide)
    np.testing.assert_allclose(wide_trace.boxes.corner_ego, narrow_trace.boxes.corner_ego, atol=1e-6)
