"""Trajectories through recorded samples: splitting, interpolation and yaw."""

import numpy as np
import pytest
import scipy
from hypothesis import given
from hypothesis import strategies as st

from luxloop.sim.replay.recording import Recording, RoadUser
from luxloop.sim.replay.trajectories import Trajectories
from luxloop.sim.source import TrafficInputError
from luxloop.sim.world import Kind


def recording(*tracks):
    """Return a recording with one road user per track: rows of time, x, y and optionally yaw."""
    tracks = [np.array(track, dtype=np.float64) for track in tracks]
    full = [np.column_stack([track, np.full((len(track), 4 - track.shape[1]), np.nan)]) for track in tracks]
    rows = np.concatenate(full)
    user = np.repeat(np.arange(len(tracks)), [len(track) for track in tracks])
    users = [RoadUser(f"n{number}", Kind.CAR, (4.0, 1.8, 1.5)) for number in range(len(tracks))]
    return Recording(users, user, rows[:, 0], rows[:, 1:])


def along_x(times, speed=10.0):
    return [(time, speed * time, 0.0, 0.0) for time in times]


@given(
    st.lists(st.floats(0.1, 0.9), min_size=1, max_size=12),
    st.lists(st.integers(-3, 3), min_size=13, max_size=13),
    st.randoms(use_true_random=False),
)
def test_interpolation_equals_scipy_s_monotone_interpolation(steps, moves, random):
    """Detects wrong weights, ends that use samples of the next trajectory, and unsorted rows."""
    time = np.cumsum([5.0, *steps])
    x = np.cumsum(moves[: len(time)]).astype(float)
    track = np.column_stack([time, x, 2 * x[::-1], 0.1 * x])
    twice = recording(track, track + np.array([0.3, 50.0, 0.0, 0.0]))
    order = random.sample(range(len(twice.time)), len(twice.time))
    trajectories = Trajectories.of(
        Recording(twice.users, twice.user[order], twice.time[order], twice.pose[order]), gap_s=1.0
    )
    assert list(trajectories.user) == [0, 1]
    oracle = scipy.interpolate.PchipInterpolator(time, track[:, 1:])
    for when in np.linspace(time[0], time[-1], 17):
        pose, rate = trajectories.at(np.array([0, 1]), when)
        assert pose[0] == pytest.approx(oracle(when), abs=1e-9)
        assert rate[0] == pytest.approx(oracle.derivative()(when), abs=1e-6)
        pose, _ = trajectories.at(np.array([1]), when + 0.3)
        assert pose[0] == pytest.approx(oracle(when) + np.array([50.0, 0.0, 0.0]), abs=1e-9)


def test_a_stopping_body_does_not_roll_back():
    """A cubic by central differences would overshoot at the stop and undershoot at the start."""
    track = [(time, min(time, 2.0) * 5.0 + 5.0 * max(time - 4.0, 0.0), 0.0, 0.0) for time in np.arange(0, 6, 0.5)]
    trajectories = Trajectories.of(recording(track), gap_s=1.0)
    x = np.array([trajectories.at(np.array([0]), when)[0][0, 0] for when in np.arange(0, 5.5, 0.01)])
    assert (np.diff(x) >= -1e-12).all()
    assert x.max() <= track[-1][1]


def test_a_gap_splits_a_trajectory():
    trajectories = Trajectories.of(recording(along_x([0.0, 0.5, 1.0, 2.0, 2.5])), gap_s=0.9)
    assert list(zip(trajectories.begin, trajectories.end, strict=True)) == [(0.0, 1.0), (2.0, 2.5)]
    (bridged,) = Trajectories.of(recording(along_x([0.0, 0.5, 1.0, 2.0, 2.5])), gap_s=1.0).end
    assert bridged == 2.5


def test_a_teleport_splits_a_trajectory_and_a_lane_change_does_not():
    there = [(0.0, 0.0, 0.0, 0.0), (0.1, 1.0, 0.0, 0.0), (0.2, 2.0, 3.5, 0.0), (0.3, 40.0, 3.5, 0.0)]
    trajectories = Trajectories.of(recording(there), gap_s=1.0)
    assert list(trajectories.end) == [0.2, 0.3]


def test_yaw_takes_the_shorter_direction():
    trajectories = Trajectories.of(
        recording([(0.0, 0.0, 0.0, np.radians(170)), (1.0, -1.0, 0.0, np.radians(-170))]), gap_s=1.0
    )
    pose, rate = trajectories.at(np.array([0]), 0.5)
    assert np.cos(pose[0, 2]) == pytest.approx(-1.0)
    assert rate[0, 2] == pytest.approx(np.radians(20))


def test_a_missing_yaw_is_replaced_by_the_course():
    """A standing body keeps its course despite noise; before its first motion it has the later course; else east."""
    noise = [0.01, -0.01, 0.02, 0.0, -0.01]
    stands = [(0.1 * step, 5.0 + wobble, 1.0, np.nan) for step, wobble in enumerate(noise)]
    goes = [(0.5 + 0.1 * step, 5.0, 1.0 + 0.5 * step, np.nan) for step in range(10)]
    rests = [(1.5 + 0.1 * step, 5.0 + wobble, 5.5, np.nan) for step, wobble in enumerate(noise)]
    parked = [(0.1 * step, -5.0, 0.0, np.nan) for step in range(20)]
    trajectories = Trajectories.of(recording([*stands, *goes, *rests], parked), gap_s=1.0)
    for when in (0.05, 0.2, 0.9, 1.3, 1.65, 1.9):
        pose, _ = trajectories.at(np.array([0, 1]), when)
        assert pose[:, 2] == pytest.approx([np.pi / 2, 0.0], abs=0.1)


def test_poses_are_constant_beyond_the_ends_and_for_single_samples():
    trajectories = Trajectories.of(recording(along_x([0.0, 0.5]), [(3.0, 7.0, 8.0, 1.0)]), gap_s=1.0)
    pose, rate = trajectories.at(np.array([0, 1]), 3.0)
    assert pose == pytest.approx(np.array([[5.0, 0.0, 0.0], [7.0, 8.0, 1.0]]))
    assert rate[1] == pytest.approx(np.zeros(3))


LINE = [(0.0, 0.0, 0.0, 0.0), (0.5, 5.0, 0.0, 0.0), (1.0, 10.0, 0.0, 0.0)]
"""Time [s], x, y [m] and yaw [rad]."""


def test_a_repeated_sample_counts_once():
    """CommonRoad files may hold the initial state again as the first state of the trajectory."""
    once, twice = (Trajectories.of(recording(rows), gap_s=1.0) for rows in ([*LINE], [LINE[0], *LINE]))
    assert twice.pose.tolist() == once.pose.tolist()
    assert twice.time.tolist() == once.time.tolist()


def test_two_samples_at_the_same_time_are_rejected():
    twice = [*along_x([0.0, 0.5]), (0.5, 5.01, 0.0, 0.0)]
    with pytest.raises(TrafficInputError, match=r"^.n1. has two samples at 0\.5 s, rows 4 and 5; keep one$"):
        Trajectories.of(recording(along_x([0.0, 0.5]), twice), gap_s=1.0)
