"""Folders of nuScenes, KITTI and Argoverse 2, and tables of truth, imported, tracked and graded as their run."""

import json
import shutil

import numpy as np
import pandas as pd
import pytest
from support import exported_run, short_run
from support.av2_log import write_av2
from support.few import few
from support.real_data import real_file

from luxloop.scenarios.cli import main
from luxloop.scenarios.grading.figures import Figures
from luxloop.scenarios.grading.grader import Grader
from luxloop.scenarios.grading.grading_config import GradingConfig
from luxloop.scenarios.grading.plane_geometry import into_frame, turned
from luxloop.scenarios.offline.recorded_scans import RecordedRun
from luxloop.scenarios.recordings.recording import Recording
from luxloop.tracker.scan import Scan
from luxloop.tracker.tracker import Tracker

TEXT = exported_run.TEXT.replace("duration_s = 0.8", "duration_s = 2.4")
KITTI_MOUNT = ("--mount", "0,0,0")
"""The exported velodyne frame is on the ground."""


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    folder = tmp_path_factory.mktemp("run")
    path = short_run.write(folder, TEXT)
    assert main(["run", str(path), "--out", str(folder / "run"), "--no-recording", "--record-scans"]) == 0
    return folder / "run"


def imported(folder, *arguments):
    assert main(["import", *map(str, arguments), "--out", str(folder / "recorded")]) == 0
    return folder / "recorded"


def export(run, folder, kind):
    assert main(["export", str(run), "--format", kind, "--out", str(folder)]) == 0
    return folder


FOLDERS = {
    "nuscenes": (lambda run, folder: export(run, folder, "nuscenes"), ()),
    "t4": (lambda run, folder: export(run, folder, "t4"), ()),
    "kitti": (lambda run, folder: export(run, folder, "kitti"), KITTI_MOUNT),
    "av2": (write_av2, ()),
}
"""Writer of a folder of each format, and options of its import."""


@pytest.fixture(scope="module", params=FOLDERS)
def read(request, run, tmp_path_factory):
    """Name of the format and its recording."""
    folder = tmp_path_factory.mktemp(request.param)
    write, options = FOLDERS[request.param]
    name = "nuscenes" if request.param == "t4" else request.param
    return request.param, imported(folder, write(run, folder / "set"), "--format", name, *options)


def kept(run):
    """Yield the frames of a run, each with its truth, its scan, and the pose of its ego in the first ego frame."""
    first = None
    for frame, scan, truth in RecordedRun.open(run).scans():
        first = frame.ego.pose_world if first is None else first
        yield frame, truth, scan, into_frame(frame.ego.pose_world[None], first)[0], first


def test_points_and_poses_are_those_of_the_run(run, read):
    name, recording = read
    scans = list(Recording(recording).scans())
    axle = 0.0 if name != "t4" else RecordedRun.open(run).rig.rear_axle_x_m
    for scan, (frame, _, true, pose, _) in zip(scans, kept(run), strict=True):
        assert scan.time == pytest.approx(frame.time, abs=1e-6)
        assert scan.ego_pose_odom[2] == pytest.approx(pose[2], abs=1e-6)
        assert np.allclose(scan.points_ego, true.points_ego - [axle, 0.0, 0.0], atol=3e-6)
        if not axle:
            assert np.allclose(scan.ego_pose_odom, pose, atol=1e-6)
    assert len(scans) == 30
    assert scans[-1].ego_pose_odom[2] > 0.5, "the ego turns"
    assert (len(np.unique(scans[-1].layer)) > 1) == (name != "kitti"), "rings are layers, where there are any"


def test_labels_are_the_actors_of_the_run(run, read):
    name, recording = read
    if name == "t4":
        pytest.skip("its ego frame is that of the rear axle, so the labels are about another origin")
    for (shown, _, _), (frame, _, _, _, first) in zip(Recording(recording).frames(), kept(run), strict=True):
        pose = into_frame(frame.actors.pose_world, first)
        nearest = np.hypot(*(pose[:, None, :2] - shown.actors.pose_world[None, :, :2]).T).T.argmin(axis=1)
        assert sorted(nearest) == list(range(len(pose)))
        assert np.allclose(shown.actors.pose_world[nearest, :2], pose[:, :2], atol=3e-6)
        turn = np.angle(np.exp(1j * (shown.actors.pose_world[nearest, 2] - pose[:, 2])))
        assert np.allclose(turn, 0.0, atol=3e-6)
        assert np.allclose(shown.actors.size[nearest], frame.actors.size, atol=1e-6)
        assert np.allclose(
            shown.actors.velocity_world[nearest], turned(frame.actors.velocity_world, -first[2]), atol=1e-3
        )


FIGURES = (
    "track.hota", "track.mota", "track.idf1", "track.missed", "track.false", "track.position_abs_mean_m",
    "track.heading_abs_mean_deg", "track.velocity_abs_mean_mps",
)  # fmt: skip


@pytest.mark.parametrize("read", few(FOLDERS, "kitti"), indirect=True)
def test_figures_are_those_of_the_run(run, read, capsys):
    """The oracle is the grading of the run's own truth, by a tracker that gets what the format keeps of its scans."""
    name, recording = read
    if name == "t4":
        pytest.skip("its ego frame is that of the rear axle, so the tracker's ego is elsewhere")
    tracker, grader = Tracker(), Grader(GradingConfig())
    for scan, (frame, truth, true, pose, _) in zip(Recording(recording).scans(), kept(run), strict=True):
        given = Scan.from_points(frame.time, true.points_ego, pose, layer=scan.layer)
        grader.add(frame, given, truth, *tracker.step(given))
    expected = grader.finish()[0].run
    capsys.readouterr()
    assert main(["grade", str(recording), "--json"]) == 0
    found = json.loads(capsys.readouterr().out)["metrics"]
    figures = Figures(expected, {}, {})
    for figure in FIGURES:
        assert found[figure]["value"] == pytest.approx(figures[figure].value, abs=1e-4), figure
    assert found["track.hota"]["value"] > 0.3


def columns_of(run, axes):
    """Return the truth of a run as columns of boxes, without numbers of frames."""
    rows = []
    for frame, _, _, _, first in kept(run):
        pose = into_frame(frame.actors.pose_world, frame.ego.pose_world if axes == "ego" else first)
        rows += [(frame.time, *row) for row in zip(frame.actors.name, *pose.T, *frame.actors.size.T, strict=True)]
    names = ("time_s", "id", f"x_{axes}_m", f"y_{axes}_m", f"heading_{axes}_rad", "length_m", "width_m", "height_m")
    return pd.DataFrame(rows, columns=names)


@pytest.mark.parametrize("axes", ["ego", "odom"])
@pytest.mark.parametrize("key", few(["time_s", "frame"], "time_s"))
def test_a_table_of_truth_labels_all_vehicles_of_a_recording(run, axes, key, tmp_path):
    table = columns_of(run, axes)
    if key == "frame":
        table = table.assign(frame=np.searchsorted(table["time_s"].unique(), table["time_s"])).drop(columns="time_s")
    gone = table["id"].to_numpy() == table["id"].iloc[0]
    table = table[~gone | (np.cumsum(gone) > 10)]
    table.to_csv(tmp_path / "truth.csv", index=False)
    shutil.copytree(export(run, tmp_path / "set", "nuscenes"), tmp_path / "moved")
    recording = imported(tmp_path, tmp_path / "moved", "--format", "nuscenes", "--truth", tmp_path / "truth.csv")
    counts = []
    for (shown, _, _), (frame, _, _, _, first) in zip(Recording(recording).frames(), kept(run), strict=True):
        pose = into_frame(frame.actors.pose_world, first)
        found = dict(zip(shown.actors.name, shown.actors.pose_world, strict=True))
        expected = dict(zip(frame.actors.name, pose, strict=True))
        assert all(np.allclose(found[name][:2], expected[name][:2], atol=1e-6) for name in found)
        counts.append(len(found))
    assert counts == [len(pose) - 1] * 10 + [len(pose)] * 20, "a vehicle is labelled where the table has it"


def test_boxes_that_lag_behind_the_scans_are_moved_on(run, tmp_path):
    """Each box is where its vehicle was two scans before."""
    table = columns_of(run, "odom")
    frame = np.searchsorted(table["time_s"].unique(), table["time_s"])
    table.assign(frame=frame + 2).drop(columns="time_s").to_csv(tmp_path / "truth.csv", index=False)
    shutil.copytree(export(run, tmp_path / "set", "nuscenes"), tmp_path / "moved")
    options = "--format", "nuscenes", "--truth", tmp_path / "truth.csv", "--truth-delay", "0.16"
    recording, shown = imported(tmp_path, tmp_path / "moved", *options), 0
    for (world, _, _), (frame, _, _, _, first) in zip(Recording(recording).frames(), kept(run), strict=True):
        expected = dict(zip(frame.actors.name, into_frame(frame.actors.pose_world, first), strict=True))
        for name, pose in zip(world.actors.name, world.actors.pose_world, strict=True):
            np.testing.assert_allclose(pose[:2], expected[name][:2], atol=1e-6)
        shown += len(world.actors)
    assert shown >= 0.9 * len(table)


def test_boxes_of_key_frames_are_interpolated(run, tmp_path):
    folder = export(run, tmp_path / "set", "nuscenes")
    tables = folder / "v1.0-luxloop"
    samples = json.loads((tables / "sample.json").read_text())
    keys = {row["token"] for row in samples[::5]}
    rows = json.loads((tables / "sample_annotation.json").read_text())
    kept_rows = [row for row in rows if row["sample_token"] in keys]
    (tables / "sample_annotation.json").write_text(json.dumps([{**row, "prev": "", "next": ""} for row in kept_rows]))
    recording = imported(tmp_path, folder, "--format", "nuscenes")
    frames = list(zip(Recording(recording).frames(), kept(run), strict=True))
    for (shown, _, _), (frame, _, _, _, first) in frames[:26]:
        pose = into_frame(frame.actors.pose_world, first)
        distance = np.hypot(*(pose[:, None, :2] - shown.actors.pose_world[None, :, :2]).T).min(axis=0)
        assert len(shown.actors) == len(pose)
        assert distance.max() < 0.01
        assert np.hypot(*shown.actors.velocity_world.T).max() == pytest.approx(5.0, abs=0.01)
    assert len(frames[27][0][0].actors) == 0, "after the last key frame there are no boxes"


def test_kitti_s_oxts_and_calibration_place_sweeps_and_boxes(tmp_path):
    """By hand: the IMU drives east by 1 m a frame, 0.8 m behind the velodyne; a car stands 10 m ahead of the first."""
    root = tmp_path / "training"
    for name in ("velodyne/0003", "label_02", "calib", "oxts"):
        (root / name).mkdir(parents=True)
    latitude, metre = 49.0, 1.0 / (np.cos(np.radians(49.0)) * 6378137.0 * np.pi / 180.0)
    lines, labels = [], []
    for frame in range(4):
        points = np.array([[10.0 - frame, 0.5, -1.0, 0.3], [10.0 - frame, -0.5, -1.0, 0.0]], "<f4")
        points.tofile(root / "velodyne" / "0003" / f"{frame:06d}.bin")
        lines.append(" ".join(map(str, [latitude, 8.0 + frame * metre, 115.0, 0.0, 0.0, 0.0, *[0.0] * 24])))
        # the camera is 0.27 m ahead of the velodyne: z = 12 - frame - 0.27 at the centre of the car
        labels.append(f"{frame} 7 Van 0 0 0 0 0 0 0 1.5 1.8 4.0 0.0 1.65 {11.73 - frame} {-np.pi / 2}")
    (root / "oxts" / "0003.txt").write_text("\n".join(lines))
    (root / "label_02" / "0003.txt").write_text("\n".join(labels))
    calibration = [
        "R_rect 1 0 0 0 1 0 0 0 1",
        "Tr_velo_cam 0 -1 0 0 0 0 -1 -0.08 1 0 0 -0.27",
        "Tr_imu_velo 1 0 0 -0.8 0 1 0 0 0 0 1 -0.8",
    ]
    (root / "calib" / "0003.txt").write_text("\n".join(calibration))
    recording = imported(tmp_path, tmp_path, "--format", "kitti", "--mount", "0,0,1.73")
    for frame, (world, scan, truth) in enumerate(Recording(recording).frames()):
        assert scan.time == pytest.approx(0.1 * frame)
        assert np.allclose(scan.ego_pose_odom, [frame, 0.0, 0.0], atol=1e-5)
        assert np.allclose(scan.points_ego[0], [10.0 - frame, 0.5, 0.73], atol=1e-6)
        assert np.allclose(world.actors.pose_world, [[12.0, 0.0, 0.0]], atol=1e-5)
        assert truth.unit_hits.sum() == 2


@pytest.mark.parametrize(
    ("arguments", "remedy"),
    [
        (("--format", "kitti", "--mount", "0,0,1"), "no velodyne/0000 in it"),
        (("--format", "av2"), "no city_SE3_egovehicle.feather in it"),
        (("--format", "nuscenes"), "no sample_annotation.json in it"),
    ],
)
def test_a_folder_of_another_kind_is_refused_in_one_line(arguments, remedy, tmp_path, capsys):
    (tmp_path / "set").mkdir()
    assert main(["import", str(tmp_path / "set"), *arguments, "--out", str(tmp_path / "recorded")]) == 2
    assert remedy in capsys.readouterr().err
    assert not (tmp_path / "recorded").exists()


def test_of_several_scenes_one_is_chosen(run, tmp_path, capsys):
    write_av2(run, tmp_path / "set" / "log-a")
    shutil.copytree(tmp_path / "set" / "log-a", tmp_path / "set" / "log-b")
    whole = ("import", str(tmp_path / "set"), "--format", "av2", "--out", str(tmp_path / "recorded"))
    assert main([*whole]) == 2
    assert "has 2 logs; give --scene, one of log-a, log-b" in capsys.readouterr().err
    assert main([*whole, "--scene", "log-b"]) == 0


def test_a_truth_of_another_clock_or_without_a_file_is_refused(run, tmp_path, capsys):
    folder = export(run, tmp_path / "set", "nuscenes")
    columns_of(run, "odom").assign(time_s=lambda table: table["time_s"] + 1e9).to_csv(tmp_path / "late.csv")
    whole = ("import", str(folder), "--format", "nuscenes", "--out", str(tmp_path / "recorded"), "--truth")
    assert main([*whole, str(tmp_path / "late.csv")]) == 2
    assert "its boxes are from 1000000000.0 to 1000000002.3 s, scans from 0.0 to 2.3 s" in capsys.readouterr().err
    assert main([*whole, "missing.csv"]) == 2
    assert "should be an existing file of true boxes" in capsys.readouterr().err


@pytest.mark.slow
def test_a_real_street_is_imported_tracked_and_graded_in_two_commands(tmp_path, capsys):
    street = real_file("street/bumper_points.parquet")
    recording = imported(tmp_path, street, "--truth", street.parent / "labels.parquet")
    labels = pd.read_parquet(street.parent / "labels.parquet")
    shown = pd.read_parquet(recording / "labels.parquet")
    assert len(shown) == len(labels)
    assert shown["actor_id"].nunique() == labels["actor_id"].nunique()
    capsys.readouterr()
    assert main(["track", str(recording), "--out", str(tmp_path / "tracks"), "--no-recording", "--json"]) == 0
    metrics = json.loads(capsys.readouterr().out)["metrics"]
    assert 0.55 < metrics["track.hota"]["value"] < 0.75
