"""Sweeps of several LIDARs as scans: grouping, times, order, layers."""

import numpy as np
import pytest

from luxloop.scenarios.errors import InputError
from luxloop.scenarios.recordings.ego_mount import EgoMount
from luxloop.scenarios.recordings.ego_scans import EgoScans
from luxloop.scenarios.recordings.import_options import ImportOptions
from luxloop.scenarios.recordings.pose_track import PoseTrack
from luxloop.scenarios.recordings.sweep import Sweep

MOUNTS = (EgoMount.parse("1,0,0.5"), EgoMount.parse("-1,0,0.5,180"))


def sweep(time, unit=0, offsets=(0.0, 0.04)):
    points = np.array([[5.0, 0.0, 0.0], [6.0, 1.0, 0.0]])
    return Sweep(time, unit, points, np.array(offsets), np.array([3, 7]))


def scans(sweeps, ego=None, **options):
    maker = EgoScans(ImportOptions(MOUNTS, **options), ego)
    return [scan for _, scan in maker.of(sweeps)], maker


def test_a_scan_takes_the_sweeps_until_the_next_one_of_the_first_lidar():
    found, maker = scans([sweep(9.95, 1), sweep(10.0), sweep(10.03, 1), sweep(10.1), sweep(10.13, 1)])
    assert [len(scan) for scan in found] == [4, 4]
    assert [scan.time for scan in found] == pytest.approx([0.0, 0.1])
    assert found[0].unit.tolist() == [0, 0, 1, 1]
    assert found[0].points_ego[:, 0].tolist() == [6.0, 7.0, -6.0, -7.0]
    # The middle of the first LIDAR's sweep is 10.02 s.
    assert found[0].time_offset == pytest.approx([-0.02, 0.02, 0.01, 0.05], abs=1e-6)
    assert maker.skipped.before_first == 1


def test_repeated_late_and_empty_sweeps_are_left_out_and_counted():
    empty = sweep(10.3).subset(np.zeros(2, dtype=bool))
    found, maker = scans([sweep(10.0), sweep(10.0), sweep(9.0), sweep(10.1), empty])
    assert [scan.time for scan in found] == pytest.approx([0.0, 0.1])
    assert (maker.skipped.not_later, maker.skipped.empty) == (2, 1)


def test_sweeps_outside_the_poses_are_left_out():
    ego = PoseTrack(np.array([[10.0, 0, 0, 0], [10.2, 1, 0, 0]]))
    found, maker = scans([sweep(9.0), sweep(10.08), sweep(11.0)], ego)
    assert len(found) == 1
    assert maker.skipped.without_pose == 2
    assert maker.first_pose == pytest.approx([0.5, 0.0, 0.0])
    assert found[0].ego_pose_odom.tolist() == [0.0, 0.0, 0.0]


@pytest.mark.parametrize("offsets", [(0.0, 0.0), (0.0, 2e-7), (3.0, 3.5)])
def test_a_given_sweep_time_replaces_wrong_times_of_points(offsets):
    found, _ = scans([sweep(10.0, offsets=offsets)], sweep_time_s=0.1)
    assert found[0].time_offset == pytest.approx([-0.05, 0.05])


def test_a_lidar_without_a_mount_is_an_error():
    with pytest.raises(InputError, match="--mount"):
        scans([sweep(10.0), sweep(10.0, 2)])


def test_layers_are_those_of_the_rings():
    found, _ = scans([sweep(10.0)])
    assert sorted(found[0].layer.tolist()) == [0, 1]
