"""T4 data sets: requirements of t4-devkit's `t4sanity` on structure, records, references and fields, checked apart."""

import json
import re

import numpy as np
import pytest
from support import exported_run

from luxloop.scenarios.cli import main
from luxloop.scenarios.exchange.nuscenes import nuscenes_reader
from luxloop.scenarios.offline.recorded_scans import RecordedRun

FIELDS = {
    "attribute": {"token": str, "name": str, "description": str},
    "calibrated_sensor": {
        "token": str, "sensor_token": "sensor", "translation": 3, "rotation": 4, "camera_intrinsic": 0,
        "camera_distortion": 0,
    },
    "category": {
        "token": str, "name": str, "description": str, "index": int, "has_orientation": bool, "has_number": bool,
    },
    "ego_pose": {
        "token": str, "timestamp": int, "translation": 3, "rotation": 4, "twist": 6, "acceleration": 3,
        "geocoordinate": None,
    },
    "instance": {
        "token": str, "category_token": "category", "instance_name": str, "nbr_annotations": int,
        "first_annotation_token": "sample_annotation", "last_annotation_token": "sample_annotation",
    },
    "log": {"token": str, "logfile": str, "vehicle": str, "data_captured": str, "location": str},
    "map": {"token": str, "log_tokens": ["log"], "category": str, "filename": str},
    "sample": {"token": str, "timestamp": int, "scene_token": "scene", "next": "?sample", "prev": "?sample"},
    "sample_annotation": {
        "token": str, "sample_token": "sample", "instance_token": "instance", "attribute_tokens": ["attribute"],
        "visibility_token": "visibility", "translation": 3, "rotation": 4, "size": 3, "velocity": 3, "acceleration": 3,
        "num_lidar_pts": int, "num_radar_pts": int, "next": "?sample_annotation", "prev": "?sample_annotation",
        "automatic_annotation": bool, "autolabel_metadata": None,
    },
    "sample_data": {
        "token": str, "sample_token": "sample", "ego_pose_token": "ego_pose",
        "calibrated_sensor_token": "calibrated_sensor", "filename": str, "fileformat": str, "width": int, "height": int,
        "timestamp": int, "is_key_frame": bool, "next": "?sample_data", "prev": "?sample_data", "is_valid": bool,
        "info_filename": None,
    },
    "scene": {
        "token": str, "name": str, "description": str, "log_token": "log", "nbr_samples": int,
        "first_sample_token": "sample", "last_sample_token": "sample",
    },
    "sensor": {"token": str, "channel": str, "modality": str},
    "visibility": {"token": str, "level": str, "description": str},
}  # fmt: skip
"""Mandatory tables of docs/schema/table.md of t4-devkit: types, lengths of numbers, foreign keys (`?`: or empty)."""
NAMES = {"car", "truck", "trailer", "bus", "motorcycle", "bicycle", "pedestrian"}


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return exported_run.exported(tmp_path_factory.mktemp("t4"), "t4")


@pytest.fixture(scope="module")
def run(folder):
    return RecordedRun.open(folder / "run")


@pytest.fixture(scope="module")
def frames(run):
    return list(run.scans())


@pytest.fixture(scope="module")
def tables(folder):
    return {path.stem: json.loads(path.read_text()) for path in (folder / "t4" / "annotation").iterdir()}


def test_the_structure_is_that_of_a_data_set(folder, tables):
    """STR002, 003, 006, 007; REC001 to 006; REF013. Maps and bags, which t4sanity only warns about, are left out."""
    root = folder / "t4"
    assert {path.name for path in root.iterdir()} == {
        "annotation",
        "data",
        "map",
        "status.json",
        "tracking_result.json",
    }
    assert tables.keys() == FIELDS.keys()
    assert len(tables["scene"]) == 1
    assert all(tables[name] for name in ("sample", "sample_data", "ego_pose", "calibrated_sensor", "instance"))
    assert all((root / row["filename"]).is_file() for row in (*tables["sample_data"], *tables["map"]))
    assert json.loads((root / "status.json").read_text())["scenario"] == "short"


@pytest.mark.parametrize("name", FIELDS)
def test_rows_have_the_fields_of_the_schema_and_refer_to_rows(name, tables):
    """FMT001 to 013 and REF001 to 021."""
    tokens = {table: {row["token"] for row in rows} for table, rows in tables.items()}
    assert len(tokens[name]) == len(tables[name])
    for row in tables[name]:
        assert row.keys() == FIELDS[name].keys()
        for key, kind in FIELDS[name].items():
            value = row[key]
            if kind is None:
                assert value is None, key
            elif isinstance(kind, type):
                assert type(value) is kind, key
            elif isinstance(kind, int):
                assert len(value) == kind, key
                assert all(type(number) is float and np.isfinite(number) for number in value), key
            elif isinstance(kind, list):
                assert set(value) <= tokens[kind[0]], key
            else:
                assert value in tokens[kind.removeprefix("?")] or (value == "" and kind.startswith("?")), key


def test_names_and_levels_are_those_of_the_format(tables):
    assert {row["name"] for row in tables["category"]} == NAMES
    assert {row["level"] for row in tables["visibility"]} == {"full", "most", "partial", "none"}
    assert [(row["channel"], row["modality"]) for row in tables["sensor"]] == [("LIDAR_CONCAT", "lidar")]
    assert {row["fileformat"] for row in tables["sample_data"]} == {"pcd.bin"}
    (log,) = tables["log"]
    assert re.fullmatch(r"\d{4}(-\d\d){5}", log["data_captured"])
    (scene,) = tables["scene"]
    assert scene["name"].endswith(f"_{scene['token']}")
    assert all(re.fullmatch(r"short-seed4::[0-9a-f]{32}", row["instance_name"]) for row in tables["instance"])


def test_points_and_poses_are_those_of_the_rear_axle(folder, frames, tables, run):
    """A point of base_link, placed by the ego pose, is where the ego frame and the true pose put it."""
    axle = run.rig.rear_axle_x_m
    assert axle < -1.0
    for (frame, scan, _), data, pose in zip(frames, tables["sample_data"], tables["ego_pose"], strict=True):
        cloud = np.fromfile(folder / "t4" / data["filename"], np.float32).reshape(-1, 5)
        x, y, yaw = frame.ego.pose_world
        turn = np.array([[np.cos(yaw), -np.sin(yaw)], [np.sin(yaw), np.cos(yaw)]])
        w, _, _, z = pose["rotation"]
        own = np.array([[w * w - z * z, -2 * w * z], [2 * w * z, w * w - z * z]])
        np.testing.assert_allclose(
            cloud[:, :2] @ own.T + pose["translation"][:2], scan.points_ego[:, :2] @ turn.T + (x, y), atol=1e-5
        )
        np.testing.assert_array_equal(cloud[:, 2], scan.points_ego[:, 2])
        np.testing.assert_array_equal(cloud[:, 3], scan.echo_pulse_width)
        np.testing.assert_array_equal(cloud[:, 4], 4 * scan.unit.astype(int) + scan.layer)


def test_twists_are_differences_of_the_poses(frames, tables):
    """The rear axle of a car on an arc moves along the car's axis, here within the truth layer's slip."""
    places = np.array([row["translation"][:2] for row in tables["ego_pose"]])
    times = np.array([frame.time for frame, _, _ in frames])
    for k in range(1, len(places) - 1):
        speed = (places[k + 1] - places[k - 1]) / (times[k + 1] - times[k - 1])
        yaw = frames[k][0].ego.pose_world[2]
        local = [np.cos(yaw) * speed[0] + np.sin(yaw) * speed[1], np.cos(yaw) * speed[1] - np.sin(yaw) * speed[0]]
        np.testing.assert_allclose(tables["ego_pose"][k]["twist"][:2], local, atol=0.01)
        assert tables["ego_pose"][k]["twist"][3] == frames[k][0].ego.yaw_rate


def test_boxes_and_velocities_are_read_back_exactly(folder, frames):
    found = nuscenes_reader.read_tables(folder / "t4")
    assert set(found.kind.tolist()) == {"car"}
    for frame, _, _ in frames:
        rows, actors = found.select(found.frame == frame.index), frame.actors
        order, there = np.lexsort(rows.boxes[:, :2].T), np.lexsort(actors.pose_world[:, :2].T)
        np.testing.assert_array_equal(rows.boxes[order][:, :2], actors.pose_world[there][:, :2])
        np.testing.assert_array_equal(rows.boxes[order][:, 3:], actors.size[there][:, :2])
        np.testing.assert_array_equal(rows.velocity[order], actors.velocity_world[there])


def test_tracks_are_graded_against_the_tables(folder, capsys):
    def grades(truth, tracks):
        assert main(["grade", "--truth", str(truth), "--tracks", str(tracks), "--json"]) == 0
        return {name: row["value"] for name, row in json.loads(capsys.readouterr().out)["metrics"].items()}

    own = grades(folder / "run/scans/labels.parquet", folder / "run/tables/tracks.parquet")
    found = grades(folder / "t4", folder / "t4" / "tracking_result.json")
    for name in ("hota", "mota", "idf1", "gospa_m", "velocity_abs_mean_mps"):
        assert found[f"track.{name}"] == pytest.approx(own[f"track.{name}"], abs=1e-9)
    assert own["track.hota"] > 0.2
