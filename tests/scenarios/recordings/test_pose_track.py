"""Interpolation and derivatives of poses on motions with known ones."""

import numpy as np
import pytest

from luxloop.scenarios.errors import InputError
from luxloop.scenarios.recordings.pose_track import PoseTrack


def circle(radius=10.0, rate=0.4, start=-2.0):
    """Poses on a circle that passes a yaw of pi."""
    time = np.arange(0.0, 5.0, 0.025)
    yaw = start + rate * time
    yaw = np.arctan2(np.sin(yaw), np.cos(yaw))
    return np.column_stack([time, radius * np.sin(start + rate * time), -radius * np.cos(start + rate * time), yaw])


def test_motion_on_a_circle():
    motion = PoseTrack(circle()).motion(2.0)
    yaw = -2.0 + 0.8
    assert motion.velocity == pytest.approx([4.0 * np.cos(yaw), 4.0 * np.sin(yaw)], abs=0.02)
    assert motion.acceleration == pytest.approx([-1.6 * np.sin(yaw), 1.6 * np.cos(yaw)], abs=0.02)
    assert motion.yaw_rate == pytest.approx(0.4, abs=1e-6)


def test_yaw_is_interpolated_across_a_half_turn():
    track = PoseTrack(np.array([[0.0, 0, 0, np.pi - 0.1], [0.2, 0, 0, -np.pi + 0.1]]))
    assert np.cos(track.at(0.1)[2]) == pytest.approx(-1.0)


def test_order_and_repetition_of_poses_do_not_matter():
    rows = circle()
    mixed = np.vstack([rows[::-1], rows[5:9]])
    assert PoseTrack(mixed).at(1.234) == pytest.approx(PoseTrack(rows).at(1.234))


def test_gaps_and_ends_have_no_pose():
    track = PoseTrack(np.array([[0.0, 0, 0, 0], [0.1, 1, 0, 0], [2.0, 9, 0, 0], [2.1, 9, 0, 0]]))
    assert track.at(1.0) is None
    assert track.motion(1.0) is None
    assert track.at(2.5) is None
    assert track.at(2.2)[0] == 9.0
    assert PoseTrack(np.empty((0, 4))).at(0.0) is None


def test_poses_that_no_body_has_are_refused():
    with pytest.raises(InputError, match="a pose of a body has a number that none has"):
        PoseTrack(np.array([[0.0, 0, 0, 0], [0.1, 1e300, 0, 0]]))
