"""Data set of a run, read with pandas and compared with the scans, the ground truth and the metrics."""

import json
from dataclasses import fields, replace
from pathlib import Path

import numpy as np
import pandas as pd
import pyarrow.parquet as pq
import pytest
from support import short_run

from luxloop.scenarios.cli import main
from luxloop.scenarios.dataset import dataset_rows
from luxloop.scenarios.dataset import writer as dataset
from luxloop.scenarios.dataset.dataset_columns import FILES, OBSTACLES
from luxloop.scenarios.errors import OutputError
from luxloop.scenarios.files.scenario import Scenario
from luxloop.scenarios.grading.plane_geometry import CORNER_SIGNS, corner
from luxloop.scenarios.run import device, loop
from luxloop.sensor_model.truth import Cause, Part, View
from luxloop.sim.world import Kind, Mode, Obstacles
from luxloop.tracker.records import MODELS

GROUP_FRAMES = 4
"""Frames per row group; the last group has two of the ten frames."""


@pytest.fixture(scope="module")
def written(tmp_path_factory):
    """A data set, the result of its run, and all its frames."""
    folder, frames = tmp_path_factory.mktemp("data"), []
    scenario = Scenario.load(short_run.write(folder))
    with pytest.MonkeyPatch.context() as patch, dataset.create(folder / "set", folder / "run") as writer:
        patch.setattr(dataset, "FRAMES_AT_ONCE", GROUP_FRAMES)

        def export(*records):
            frames.append(records)
            writer.add(*records)

        result = loop.run(scenario, device.load(device.SHIPPED), export=export, start=writer.start)
        writer.finish(result)
    return folder / "set", result, frames


def table(folder, name):
    return pd.read_parquet(folder / f"{name}.parquet")


def test_points_agree_with_scan_and_truth(written):
    """Fails if columns are swapped, a frame is lost between row groups, or codes have wrong names."""
    folder, _, frames = written
    points = table(folder, "points")
    for frame, scan, truth, _ in frames:
        rows = points[points["frame"] == frame.index]
        np.testing.assert_array_equal(rows[["x_ego_m", "y_ego_m", "z_ego_m"]], scan.points_ego)
        for column, values in {
            "time_offset_s": scan.time_offset,
            "unit": scan.unit,
            "layer": scan.layer,
            "echo": scan.echo,
            "echo_pulse_width_m": scan.echo_pulse_width,
            "flags": scan.flags,
            "actor_id": truth.actor_id,
            "true_range_m": truth.true_range,
        }.items():
            np.testing.assert_array_equal(rows[column], values, err_msg=column)
        assert rows["part"].tolist() == [Part(part).name.lower() for part in truth.part]
        assert rows["cause"].tolist() == [Cause(cause).name.lower() for cause in truth.cause]
    assert len(points) == sum(len(scan) for _, scan, _, _ in frames)


def test_obstacles_are_those_of_the_scenario(written):
    """By hand: a wall from (-20, 15) to (20, 15), 3 m high."""
    rows = table(written[0], "obstacles")
    assert rows[["obstacle", "x_world_m", "y_world_m", "base_m", "top_m"]].to_numpy().tolist() == [
        [0, -20.0, 15.0, 0.0, 3.0],
        [0, 20.0, 15.0, 0.0, 3.0],
    ]


def test_obstacles_are_read_back_exactly(tmp_path):
    obstacles = Obstacles.from_polygons(
        [np.array([[0.1, 0.2], [3.3, 0.2]]), np.array([[5.0, 5.0], [9.0, 5.0], [7.0, 8.0]])],
        [3.0, 2.5],
        [0.3, 0.7],
        0.1,
    )
    dataset_rows.write(tmp_path, obstacles)
    found = dataset_rows.read(tmp_path)
    for field in fields(Obstacles):
        np.testing.assert_array_equal(getattr(found, field.name), getattr(obstacles, field.name))
    assert len(dataset_rows.read(tmp_path / "older")) == 0


def test_scans_contain_the_ego_pose(written):
    folder, _, frames = written
    scans = table(folder, "scans")
    assert scans["frame"].tolist() == list(range(short_run.FRAMES))
    for (_, row), (frame, scan, _, _) in zip(scans.iterrows(), frames, strict=True):
        assert row["time_s"] == frame.time
        assert row[["ego_x_world_m", "ego_y_world_m", "ego_yaw_world_rad"]].tolist() == frame.ego.pose_world.tolist()
        assert row[["odom_x_m", "odom_y_m", "odom_yaw_rad"]].tolist() == scan.ego_pose_odom.tolist()
        assert row["points"] == len(scan)


def test_labels_agree_with_the_actors(written):
    folder, _, frames = written
    labels = table(folder, "labels")
    for frame, scan, truth, grade in frames:
        rows, actors = labels[labels["frame"] == frame.index], frame.actors
        assert rows["actor_id"].tolist() == actors.id.tolist()
        assert rows["graded"].tolist() == grade.graded.tolist()
        assert rows["kind"].tolist() == [Kind(kind).name.lower() for kind in actors.kind]
        assert rows["view"].tolist() == [View(view).name.lower() for view in truth.view]
        assert rows["mode"].tolist() == [MODELS[Mode(mode)] for mode in actors.mode]
        np.testing.assert_array_equal(rows[["x_world_m", "y_world_m", "heading_world_rad"]], actors.pose_world)
        np.testing.assert_array_equal(rows[["length_m", "width_m", "height_m"]], actors.size)
        np.testing.assert_array_equal(rows[["vx_world_mps", "vy_world_mps"]], actors.velocity_world)
        np.testing.assert_array_equal(rows["visible_fraction"], truth.visible_fraction)
        assert rows["points"].tolist() == [(truth.actor_id == actor).sum() for actor in actors.id]
        assert len(scan) == len(truth.actor_id)


def test_the_nearest_corner_belongs_to_the_labelled_box(written):
    folder, _, _ = written
    labels = table(folder, "labels")
    boxes = labels[["x_ego_m", "y_ego_m", "heading_ego_rad", "length_m", "width_m"]].to_numpy()
    near = labels[["corner_x_ego_m", "corner_y_ego_m"]].to_numpy()
    corners = corner(boxes[:, None], CORNER_SIGNS)
    np.testing.assert_allclose(np.hypot(*near.T), np.hypot(*np.moveaxis(corners, -1, 0)).min(axis=1))
    sign = np.where(labels[["corner_front", "corner_left"]], 1, -1)
    np.testing.assert_allclose(corner(boxes, sign), near)


def test_the_summary_agrees_with_metrics_and_labels(written):
    folder, result, _ = written
    summary, labels = json.loads((folder / "summary.json").read_text()), table(folder, "labels")
    assert {name for name in result.metrics if name.startswith("dataset.")} - {"dataset.share"} == {
        f"dataset.{name}" for name in summary["table"] if "{" not in name
    }
    assert all(result.metrics[f"dataset.{name}"].value == value for name, value in summary["table"].items())
    assert sum(value for name, value in summary["table"].items() if name.startswith("share{")) == pytest.approx(1.0)
    graded = labels[labels["graded"]]
    assert summary["table"]["observations"] == len(graded) > 0
    assert summary["table"]["vehicles"] == graded["actor_id"].nunique()
    assert summary["table"]["observations{view=l_shape}"] == (graded["view"] == "l_shape").sum()
    assert (summary["seed"], summary["trace_hash"]) == (result.seed, result.trace_hash)


def test_every_column_is_described_in_the_readme_and_in_its_file(written):
    folder, _, _ = written
    text = (folder / "README.md").read_text()
    for name, columns in {**FILES, "obstacles": OBSTACLES}.items():
        schema = pq.read_schema(folder / f"{name}.parquet")
        assert schema.names == [column.name for column in columns]
        section = text.split(f"## {name}.parquet")[1].split("## ")[0]
        for column in columns:
            assert f"| `{column.name}` | " in section
            assert schema.field(column.name).metadata == {
                b"unit": column.unit.encode(),
                b"meaning": column.meaning.encode(),
            }
            assert column.unit or not column.name.endswith(("_m", "_s", "_rad", "_mps", "_radps"))


def test_frames_are_written_in_row_groups(written):
    """Fails if a data set is collected in memory, or if its last frames are missing."""
    folder, _, _ = written
    file = pq.ParquetFile(folder / "scans.parquet")
    assert [file.metadata.row_group(i).num_rows for i in range(file.num_row_groups)] == [4, 4, 2]


# ---- the command line


def test_the_command_line_writes_the_data_set(tmp_path, monkeypatch, capfd):
    monkeypatch.chdir(tmp_path)
    path = short_run.write(tmp_path)
    assert main(["run", str(path), "--no-recording", "--dataset", "set"]) == 0
    assert "The data set is in set" in capfd.readouterr().out
    assert sorted(file.name for file in Path("set").iterdir()) == sorted(
        ["README.md", "summary.json", *(f"{name}.parquet" for name in [*FILES, "obstacles"])]
    )
    assert table(Path("set"), "scans")["frame"].tolist() == list(range(short_run.FRAMES))


@pytest.mark.parametrize(
    ("target", "message"),
    [
        ("there", "already exists; choose another folder with --dataset"),
        ("there/file", "already exists"),
        ("there/file/set", "cannot write there"),
        ("runs/here", "is inside the folder of the run"),
        ("runs/here/set", "is inside the folder of the run"),
        ("runs", "or contains it"),
    ],
)
def test_an_invalid_folder_is_refused_before_the_run(target, message, tmp_path, monkeypatch, capfd):
    monkeypatch.chdir(tmp_path)
    Path("there").mkdir()
    Path("there/file").write_text("mine")
    path = short_run.write(tmp_path)
    monkeypatch.setattr(loop, "run", lambda *_, **__: pytest.fail("the run was started"))
    assert main(["run", str(path), "--out", "runs/here", "--dataset", target]) == 2
    error = capfd.readouterr().err
    assert message in error
    assert error.count("\n") == 1
    assert sorted(file.name for file in Path().iterdir()) == ["short.toml", "there"]
    assert Path("there/file").read_text() == "mine"


def test_a_failed_run_leaves_no_partial_data_set(tmp_path):
    def fail(frames):
        with dataset.create(tmp_path / "set", tmp_path / "run") as writer:
            for frame in frames:
                writer.add(*frame)
            raise KeyboardInterrupt

    frames = []
    loop.run(
        Scenario.load(short_run.write(tmp_path)),
        device.load(device.SHIPPED),
        export=lambda *records: frames.append(records),
    )
    with pytest.raises(KeyboardInterrupt):
        fail(frames)
    assert [file.name for file in tmp_path.iterdir()] == ["short.toml"]


def test_a_folder_created_during_the_run_is_not_replaced(tmp_path):
    def interfere():
        with dataset.create(tmp_path / "set", tmp_path / "run"):
            (tmp_path / "set").mkdir()
            (tmp_path / "set" / "mine").write_text("kept")

    with pytest.raises(OutputError, match="already exists"):
        interfere()
    assert (tmp_path / "set" / "mine").read_text() == "kept"
    assert len(list(tmp_path.iterdir())) == 1


def test_the_summary_states_an_early_end(written):
    _, result, _ = written
    assert dataset.summary(result)["ended_early"] == ""
    assert dataset.summary(replace(result, ended_early="the ego arrived"))["ended_early"] == "the ego arrived"
