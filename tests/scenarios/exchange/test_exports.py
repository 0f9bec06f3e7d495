"""Exported folders: read without luxloop's readers, and back through them; tokens, counts, positions and points."""

import json
import re
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from support import short_run
from support.optional import need

from luxloop.scenarios.cli import main
from luxloop.scenarios.exchange.kitti import kitti_labels
from luxloop.scenarios.exchange.nuscenes import nuscenes_reader
from luxloop.scenarios.offline.recorded_scans import RecordedRun

MOVING = 'ego = { motion = [{ kind = "arc", speed_mps = 3.0, radius_m = 12.0 }] }'
SCENE = short_run.TEXT.replace('kind = "scripted"', f'kind = "scripted"\n{MOVING}')
"""An ego in a bend: a wrong pose or axis shows."""
FOREIGN = {
    "scene": {"log_token": "log", "first_sample_token": "sample", "last_sample_token": "sample"},
    "sample": {"scene_token": "scene", "prev": "sample", "next": "sample"},
    "sample_data": {
        "sample_token": "sample", "ego_pose_token": "ego_pose", "calibrated_sensor_token": "calibrated_sensor",
        "prev": "sample_data", "next": "sample_data",
    },
    "sample_annotation": {
        "sample_token": "sample", "instance_token": "instance", "visibility_token": "visibility",
        "attribute_tokens": "attribute", "prev": "sample_annotation", "next": "sample_annotation",
    },
    "instance": {
        "category_token": "category", "first_annotation_token": "sample_annotation",
        "last_annotation_token": "sample_annotation",
    },
    "calibrated_sensor": {"sensor_token": "sensor"},
    "map": {"log_tokens": "log"},
    **{name: {} for name in ("category", "attribute", "visibility", "sensor", "ego_pose", "log")},
}  # fmt: skip
"""Foreign keys of all tables, from docs/schema_nuscenes.md of the development kit of nuScenes."""
FIELDS = {
    "scene": "name description nbr_samples", "sample": "timestamp", "map": "category filename",
    "sample_data": "filename fileformat width height timestamp is_key_frame", "category": "name description index",
    "sample_annotation": "translation size rotation num_lidar_pts num_radar_pts", "instance": "nbr_annotations",
    "calibrated_sensor": "translation rotation camera_intrinsic", "attribute": "name description",
    "visibility": "level description", "sensor": "channel modality", "ego_pose": "translation rotation timestamp",
    "log": "logfile vehicle date_captured location",
}  # fmt: skip
"""The other fields of the schema."""


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    folder = tmp_path_factory.mktemp("exports")
    path = short_run.write(folder, SCENE)
    assert main(["run", str(path), "--out", str(folder / "run"), "--no-recording", "--record-scans"]) == 0
    for name in ("kitti", "nuscenes"):
        assert main(["export", str(folder / "run"), "--format", name, "--out", str(folder / name)]) == 0
    return folder


@pytest.fixture(scope="module")
def mcap(run):
    need("mcap")
    assert main(["mcap", str(run / "run"), str(run / "run.mcap")]) == 0
    return run / "run.mcap"


@pytest.fixture(scope="module")
def frames(run):
    return list(RecordedRun.open(run / "run").scans())


@pytest.fixture(scope="module")
def tables(run):
    return {path.stem: json.loads(path.read_text()) for path in (run / "nuscenes" / "v1.0-luxloop").iterdir()}


def test_every_foreign_key_of_nuscenes_is_a_token_of_its_table(tables):
    assert tables.keys() == FOREIGN.keys()
    tokens = {name: [row["token"] for row in rows] for name, rows in tables.items()}
    every = [token for name, found in tokens.items() for token in found if name != "visibility"]
    assert len(set(every)) == len(every) > 50
    assert all(re.fullmatch("[0-9a-f]{32}", token) for token in every)
    for name, rows in tables.items():
        assert rows, name
        for row in rows:
            assert row.keys() == {"token", *FOREIGN[name], *FIELDS[name].split()}, name
            for key, target in FOREIGN[name].items():
                links = row[key] if isinstance(row[key], list) else [row[key]]
                assert all(link in tokens[target] or (link == "" and key in ("prev", "next")) for link in links), key


@pytest.mark.parametrize("name", ["sample", "sample_data", "sample_annotation"])
def test_rows_of_nuscenes_are_chains_in_the_order_of_time(tables, name):
    rows = {row["token"]: row for row in tables[name]}
    samples = {row["token"]: row for row in tables["sample"]}
    time = {token: samples[row.get("sample_token", token)]["timestamp"] for token, row in rows.items()}
    for token, row in rows.items():
        if row["next"]:
            assert rows[row["next"]]["prev"] == token
            assert time[row["next"]] > time[token]
    firsts = sum(not row["prev"] for row in rows.values())
    assert firsts == (len(tables["instance"]) if name == "sample_annotation" else 1)


def test_instances_and_scenes_of_nuscenes_count_their_rows(tables):
    annotations = {row["token"]: row for row in tables["sample_annotation"]}
    for row in tables["instance"]:
        own = [token for token, found in annotations.items() if found["instance_token"] == row["token"]]
        assert len(own) == row["nbr_annotations"]
        assert annotations[row["first_annotation_token"]]["prev"] == ""
        assert annotations[row["last_annotation_token"]]["next"] == ""
    (scene,) = tables["scene"]
    assert scene["nbr_samples"] == len(tables["sample"]) == short_run.FRAMES


def test_boxes_poses_and_points_of_nuscenes_are_exact(run, frames, tables):
    sizes = {row["token"]: row for row in tables["ego_pose"]}
    for (frame, scan, truth), sample, data in zip(frames, tables["sample"], tables["sample_data"], strict=True):
        here = [row for row in tables["sample_annotation"] if row["sample_token"] == sample["token"]]
        found = sorted((*row["translation"][:2], *row["size"], row["num_lidar_pts"]) for row in here)
        points = [int((truth.actor_id == actor).sum()) for actor in frame.actors.id]
        size = frame.actors.size[:, [1, 0, 2]]
        expected = sorted((*p[:2], *s, n) for p, s, n in zip(frame.actors.pose_world, size, points, strict=True))
        assert found == expected
        pose = sizes[data["ego_pose_token"]]
        assert pose["translation"] == [*frame.ego.pose_world[:2], 0.0]
        assert 2.0 * np.arctan2(pose["rotation"][3], pose["rotation"][0]) == pytest.approx(frame.ego.pose_world[2])
        assert data["timestamp"] == sample["timestamp"] == round(1e6 * frame.time)
        cloud = np.fromfile(run / "nuscenes" / data["filename"], "<f4").reshape(-1, 5)
        np.testing.assert_array_equal(cloud[:, :3], scan.points_ego)
        np.testing.assert_array_equal(cloud[:, 3], scan.echo_pulse_width)
        np.testing.assert_array_equal(cloud[:, 4], 4 * scan.unit.astype(int) + scan.layer)


def test_the_map_of_nuscenes_is_an_image(run, tables):
    from matplotlib import image

    (row,) = tables["map"]
    assert image.imread(run / "nuscenes" / row["filename"]).shape == (1, 1)


def test_boxes_of_nuscenes_are_read_back_exactly(run, frames):
    found = nuscenes_reader.read_tables(run / "nuscenes")
    for frame, _, _ in frames:
        rows = found.select(found.frame == frame.index)
        actors = frame.actors
        order, there = np.lexsort(rows.boxes[:, :2].T), np.lexsort(actors.pose_world[:, :2].T)
        np.testing.assert_array_equal(rows.boxes[order][:, :2], actors.pose_world[there][:, :2])
        np.testing.assert_array_equal(rows.boxes[order][:, 3:], actors.size[there][:, :2])
        turn = rows.boxes[order][:, 2] - actors.pose_world[there][:, 2]
        np.testing.assert_allclose(np.cos(turn), 1.0, atol=1e-15)
        np.testing.assert_allclose(rows.time_s, frame.time, atol=1e-6)
    inner = found.select((found.frame > 0) & (found.frame < short_run.FRAMES - 1))
    truth = {
        (f.index, *f.actors.pose_world[a, :2]): f.actors.velocity_world[a]
        for f, _, _ in frames
        for a in range(len(f.actors))
    }
    expected = [truth[int(k), *box[:2]] for k, box in zip(inner.frame, inner.boxes, strict=True)]
    np.testing.assert_allclose(inner.velocity, expected, atol=0.2)


def test_files_of_kitti_have_its_layout(run, frames):
    training = run / "kitti" / "training"
    assert {path.name for path in training.iterdir()} == {"velodyne", "label_02", "calib", "poses", "times"}
    calib = dict(line.split(maxsplit=1) for line in (training / "calib" / "0000.txt").read_text().splitlines())
    assert [len(calib[key].split()) for key in ("P0:", "P3:", "R_rect", "Tr_velo_cam", "Tr_imu_velo")] == [
        12,
        12,
        9,
        12,
        12,
    ]
    velo_to_cam = np.array(calib["Tr_velo_cam"].split(), float).reshape(3, 4)
    lines = [line.split() for line in (training / "label_02" / "0000.txt").read_text().splitlines()]
    assert {len(words) for words in lines} == {17}
    inside = hits = 0
    for frame, scan, truth in frames:
        cloud = np.fromfile(training / "velodyne" / "0000" / f"{frame.index:06d}.bin", "<f4").reshape(-1, 4)
        np.testing.assert_array_equal(cloud[:, :3], scan.points_ego)
        np.testing.assert_array_equal(cloud[:, 3], scan.echo_pulse_width)
        camera = np.column_stack([cloud[:, :3], np.ones(len(cloud))]) @ velo_to_cam.T
        for words in lines:
            if int(words[0]) == frame.index:
                own = camera[(truth.actor_id == int(words[1])) & (truth.cause == 0)]
                hits += len(own)
                inside += int(in_label(own, *map(float, words[10:17])).sum())
    assert hits > 200
    assert inside > 0.95 * hits


def in_label(points, height, width, length, x, y, z, rotation_y):
    """Mask of camera points in a 3D box of KITTI, turned about y at its bottom centre, with 0.3 m to spare."""
    cos, sin = np.cos(rotation_y), np.sin(rotation_y)
    local = (points - (x, y, z)) @ np.array([[cos, 0, sin], [0, 1, 0], [-sin, 0, cos]])
    half = (np.abs(local[:, 0]) < length / 2 + 0.3) & (np.abs(local[:, 2]) < width / 2 + 0.3)
    return half & (local[:, 1] < 0.3) & (local[:, 1] > -height - 0.3)


def test_poses_of_kitti_carry_a_standing_point_into_the_first_frame(run, frames):
    """The same point of the world, seen from each frame, is at one place of the first camera."""
    rows = np.loadtxt(run / "kitti" / "training" / "poses" / "0000.txt").reshape(-1, 3, 4)
    times = np.loadtxt(run / "kitti" / "training" / "times" / "0000.txt")
    places = []
    for (frame, _, _), pose, time in zip(frames, rows, times, strict=True):
        assert time == frame.time
        x, y, yaw = frame.ego.pose_world
        ahead, left = np.array([[np.cos(yaw), np.sin(yaw)], [-np.sin(yaw), np.cos(yaw)]]) @ (30.0 - x, 7.0 - y)
        places.append(pose @ (-left, -1.0, ahead, 1.0))
    np.testing.assert_allclose(places, np.broadcast_to(places[0], (len(places), 3)), atol=1e-9)
    assert np.linalg.norm(rows[-1][:, 3]) > 0.1


def test_labels_of_kitti_are_read_back_within_their_digits(run, frames):
    found = kitti_labels.read(run / "kitti" / "training" / "label_02" / "0000.txt")
    for frame, _, _ in frames:
        rows = found.select(found.frame == frame.index)
        assert rows.id.tolist() == [str(actor) for actor in frame.actors.id]
        x, y, yaw = frame.ego.pose_world
        turn = np.array([[np.cos(yaw), -np.sin(yaw)], [np.sin(yaw), np.cos(yaw)]])
        np.testing.assert_allclose(rows.boxes[:, :2] @ turn.T + (x, y), frame.actors.pose_world[:, :2], atol=2e-6)
        off = rows.boxes[:, 2] + yaw - frame.actors.pose_world[:, 2]
        np.testing.assert_allclose(np.cos(off), 1.0, atol=1e-11)
        np.testing.assert_allclose(rows.boxes[:, 3:], frame.actors.size[:, :2], atol=1e-6)


def metrics(capsys, *words):
    assert main(["grade", *map(str, words), "--json"]) == 0
    return {name: found["value"] for name, found in json.loads(capsys.readouterr().out)["metrics"].items()}


def test_all_exports_of_a_run_have_the_same_grades(run, mcap, capsys):
    """Within the digits of KITTI's text; without velocities, which not all formats have."""
    tables = run / "run" / "tables"
    labels = run / "run" / "scans" / "labels.parquet"
    graded = [
        metrics(capsys, "--truth", labels, "--tracks", tables / "tracks.parquet"),
        metrics(capsys, "--truth", run / "nuscenes", "--tracks", run / "nuscenes" / "tracking_result.json"),
        metrics(
            capsys, "--truth", run / "kitti/training/label_02/0000.txt", "--tracks", run / "kitti/results/0000.txt"
        ),
        metrics(capsys, "--truth", run / "kitti", "--tracks", run / "kitti"),
        metrics(capsys, "--truth", mcap, "--tracks", mcap),
    ]
    for name in (
        "hota",
        "mota",
        "idf1",
        "id_switches",
        "false",
        "gospa_m",
        "orientation_abs_mean_deg",
        "length_abs_mean_m",
    ):
        values = [found[f"track.{name}"] for found in graded]
        assert values == pytest.approx([values[0]] * 5, abs=1e-3), name
    assert graded[0]["track.hota"] > 0.2
    assert graded[1]["track.velocity_abs_mean_mps"] is not None


def test_exports_with_numbers_of_points_have_the_same_grades_of_seen_actors(run, mcap, capsys):
    """The limit is the median of the points, so it leaves out about half of the boxes."""
    labels = run / "run" / "scans" / "labels.parquet"
    seen = ("--points-min", int(pd.read_parquet(labels)["points"].median()) + 1)
    pairs = [
        (labels, run / "run" / "tables" / "tracks.parquet"),
        (run / "nuscenes", run / "nuscenes" / "tracking_result.json"),
        (mcap, mcap),
    ]
    graded = [metrics(capsys, "--truth", truth, "--tracks", tracks, *seen) for truth, tracks in pairs]
    for name in ("hota", "missed", "false"):
        values = [found[f"track.{name}"] for found in graded]
        assert values == pytest.approx([values[0]] * 3, abs=1e-6), name
    every = metrics(capsys, "--truth", mcap, "--tracks", mcap)
    assert graded[0]["track.hota"] != every["track.hota"]


def test_exports_are_reproducible(run, tmp_path):
    for name in ("kitti", "nuscenes"):
        assert main(["export", str(run / "run"), "--format", name, "--out", str(tmp_path / name)]) == 0
        first, again = (
            {p.relative_to(f): p.read_bytes() for p in f.rglob("*") if p.is_file()}
            for f in (run / name, tmp_path / name)
        )
        assert first == again


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--format", "waymo", "--out", "new"], "--format waymo: is none of kitti, lux, nuscenes, osi, t4"),
        (["--format", "kitti", "--out", "there"], "there: already exists; choose another folder with --out"),
        (["--format", "nuscenes", "--out", "file/x"], "cannot write there (Not a directory)"),
    ],
)
def test_invalid_requests_are_one_line(words, message, run, tmp_path, monkeypatch, capfd):
    monkeypatch.chdir(tmp_path)
    Path("there").mkdir()
    Path("file").write_text("mine")
    assert main(["export", str(run / "run"), *words]) == 2
    error = capfd.readouterr().err
    assert message in error
    assert error.count("\n") == 1
    assert sorted(path.name for path in Path().iterdir()) == ["file", "there"]


def test_a_file_as_run_is_named_as_such(tmp_path, monkeypatch, capfd):
    monkeypatch.chdir(tmp_path)
    Path("a.csv").write_text("frame,id\n")
    for words in (["export", "a.csv", "--format", "kitti", "--out", "new"], ["grade", "a.csv"], ["view", "a.csv"]):
        assert main(words) == 2
        assert capfd.readouterr().err == "luxloop: error: a.csv: is a file; give a folder that luxloop run wrote\n"
