"""ROS bags and MCAP as recorded scans: the drive of `support.recorded_drive`, whose motion is known."""

import json

import numpy as np
import pyarrow.parquet as pq
import pytest
from support import recorded_drive as drive
from support.optional import need

from luxloop.scenarios.cli import main
from luxloop.scenarios.recordings.recording import Recording

CENTRE_AT_1S = (8.0 + 8.0, 3.0)
"""Position of the car's centre after 1 s in the odometry frame: the ego frame of the first scan."""


def write(kind, folder):
    if kind == "ros1":
        return drive.write_ros1(folder / "drive.bag")
    if kind == "ros2":
        return drive.write_ros2(folder / "drive")
    return next(drive.write_ros2(folder / "drive", "MCAP").glob("*.mcap"))


@pytest.fixture(scope="module", params=["ros1", "ros2", "mcap"])
def recording(request, tmp_path_factory):
    folder = tmp_path_factory.mktemp(request.param)
    out = folder / "recorded"
    assert main(["import", str(write(request.param, folder)), "--out", str(out), *drive.OPTIONS]) == 0
    return Recording(out)


def test_scans_have_the_times_and_poses_of_the_drive(recording):
    assert len(recording) == drive.SCANS
    assert recording.time_s == pytest.approx(np.arange(drive.SCANS) / drive.RATE_HZ, abs=1e-6)
    poses = np.array([scan.ego_pose_odom for _, scan, _ in recording.frames()])
    assert poses[:, 0] == pytest.approx(drive.EGO_MPS * recording.time_s, abs=1e-6)
    assert poses[:, 1:] == pytest.approx(np.zeros((drive.SCANS, 2)), abs=1e-9)


def test_labels_have_the_motion_of_the_car(recording):
    frame = [frame for frame, _, _ in recording.frames()][10]
    car = frame.actors
    assert car.name.tolist() == ["car"]
    assert car.pose_world[0] == pytest.approx([*CENTRE_AT_1S, 0.0], abs=1e-6)
    assert car.velocity_world[0] == pytest.approx([drive.CAR_MPS, 0.0], abs=1e-6)
    assert car.acceleration_world[0] == pytest.approx([0.0, 0.0], abs=1e-4)
    assert car.size[0, :2] == pytest.approx(drive.CAR_SIZE)


def test_points_lie_on_the_outline_of_the_car(recording):
    frame, scan, truth = list(recording.frames())[10]
    body = scan.points_ego[:, :2] + scan.ego_pose_odom[:2] - frame.actors.pose_world[0, :2]
    outside = np.abs(body) - 0.5 * np.array(drive.CAR_SIZE)
    assert len(scan) > 20
    assert np.abs(outside.max(axis=1)).max() < 1e-4
    assert (truth.actor_id == 0).all()
    assert scan.points_ego[:, 2] == pytest.approx(0.5)


def test_the_summary_names_the_options(recording):
    summary = json.loads((recording.folder / "summary.json").read_text())
    assert summary["odometry"] == "/ego"
    assert summary["truth"][0]["length_m"] == drive.CAR_SIZE[0]
    assert summary["start_time_s"] == pytest.approx(drive.START_S)
    assert "points.parquet" in (recording.folder / "README.md").read_text()
    names = pq.read_schema(recording.folder / "points.parquet").names
    assert "actor_id" not in names


def test_parts_of_an_mcap_recording_are_one(tmp_path):
    """Recorders start a new file after some time; the order of the arguments does not matter."""
    need("recordings")
    parts = [
        next(drive.write_ros2(tmp_path / f"part {begin}", "MCAP", begin, end).glob("*.mcap"))
        for begin, end in ((1.0, np.inf), (-np.inf, 1.0))
    ]
    whole = [str(write("mcap", tmp_path))]
    for name, paths in (("whole", whole), ("parts", map(str, parts))):
        assert main(["import", *paths, "--out", str(tmp_path / name), *drive.OPTIONS]) == 0
    one, other = (Recording(tmp_path / name) for name in ("whole", "parts"))
    assert other.time_s.tolist() == one.time_s.tolist()
    assert [len(scan) for scan in other.scans()] == [len(scan) for scan in one.scans()]


def test_stamps_since_power_on_name_both_clocks_and_the_times_of_logging_help(tmp_path, capsys):
    bag = str(drive.write_ros1(tmp_path / "drive.bag", power_on_s=990.0))
    assert main(["import", bag, "--out", str(tmp_path / "out"), *drive.OPTIONS]) == 2
    said = capsys.readouterr().err
    assert "sweeps without a pose are from 10.0 to 12.9 s, poses from 999.9 to 1003.2 s; --time log" in said
    assert main(["import", bag, "--out", str(tmp_path / "out"), *drive.OPTIONS, "--time", "log"]) == 0
    assert Recording(tmp_path / "out").time_s == pytest.approx(np.arange(drive.SCANS) / drive.RATE_HZ, abs=1e-6)


def test_scale_applies_to_lengths_and_times(tmp_path):
    bag = drive.write_ros1(tmp_path / "drive.bag")
    scale = ("--scale-length", "10", "--scale-time", "2")
    assert main(["import", str(bag), "--out", str(tmp_path / "out"), *drive.OPTIONS, *scale]) == 0
    recording = Recording(tmp_path / "out")
    frame, scan, _ = list(recording.frames())[10]
    assert scan.time == pytest.approx(2.0)
    assert frame.actors.pose_world[0, :2] == pytest.approx(10.0 * np.array(CENTRE_AT_1S), abs=1e-4)
    assert frame.actors.velocity_world[0] == pytest.approx([5.0 * drive.CAR_MPS, 0.0], abs=1e-4)
    assert frame.actors.size[0, :2] == pytest.approx(10.0 * np.array(drive.CAR_SIZE))
    assert scan.points_ego[:, 2] == pytest.approx(5.0)


def test_without_odometry_the_ego_stands(tmp_path):
    bag = drive.write_ros1(tmp_path / "drive.bag")
    assert main(["import", str(bag), "--out", str(tmp_path / "out"), "--mount", "1,0,0.5"]) == 0
    recording = Recording(tmp_path / "out")
    assert not recording.has_truth
    assert all((scan.ego_pose_odom == 0.0).all() for scan in recording.scans())


def test_true_poses_that_lag_behind_the_scans_are_moved_on(tmp_path):
    """The pose of the car that was recorded 0.2 s after a scan is the one at the scan."""
    given = ("import", str(drive.write_ros1(tmp_path / "drive.bag")), *drive.OPTIONS, "--truth-delay", "0.2")
    assert main([*given, "--out", str(tmp_path / "recorded")]) == 0
    frame = [frame for frame, _, _ in Recording(tmp_path / "recorded").frames()][10]
    expected = CENTRE_AT_1S[0] + 0.2 * drive.CAR_MPS, CENTRE_AT_1S[1]
    assert frame.actors.pose_world[0, :2] == pytest.approx(expected, abs=1e-6)
