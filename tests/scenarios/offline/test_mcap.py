"""MCAP export: read with the mcap package, and checked by rerun."""

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from support.optional import need

need("mcap")

from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory
from support import short_run

from luxloop.scenarios.cli import main
from luxloop.scenarios.offline.mcap import export as export_module
from luxloop.scenarios.offline.mcap.messages import definition
from luxloop.scenarios.offline.recorded_scans import RecordedRun
from luxloop.tracker.tracker import Tracker

TYPES = {1: "i1", 2: "u1", 3: "i2", 4: "u2", 5: "i4", 6: "u4", 7: "f4", 8: "f8"}
"""Type codes of `sensor_msgs/PointField`."""


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    """A recorded run, and its file."""
    folder = tmp_path_factory.mktemp("mcap")
    path = short_run.write(folder)
    assert main(["run", str(path), "--out", str(folder / "run"), "--no-recording", "--record-scans"]) == 0
    assert main(["mcap", str(folder / "run"), str(folder / "run.mcap")]) == 0
    return RecordedRun.open(folder / "run"), folder / "run.mcap"


@pytest.fixture(scope="module")
def messages(run):
    """All messages of the file by topic, as (log time, message type, message)."""
    with run[1].open("rb") as stream:
        found = {}
        for schema, channel, message, ros in make_reader(
            stream, decoder_factories=[DecoderFactory()]
        ).iter_decoded_messages():
            found.setdefault(channel.topic, []).append((message.log_time, schema.name, ros))
        return found


def columns(cloud):
    """Decode a `PointCloud2` as ROS readers do, by offset and type."""
    dtype = np.dtype(
        {
            "names": [field.name for field in cloud.fields],
            "formats": [TYPES[field.datatype] for field in cloud.fields],
            "offsets": [field.offset for field in cloud.fields],
            "itemsize": cloud.point_step,
        }
    )
    assert len(cloud.data) == cloud.row_step * cloud.height == cloud.point_step * cloud.width
    return np.frombuffer(cloud.data, dtype)


def yaw(turn):
    return np.arctan2(2.0 * (turn.w * turn.z + turn.x * turn.y), 1.0 - 2.0 * (turn.y**2 + turn.z**2))


def test_every_topic_has_every_frame_at_its_time(run, messages):
    times = [round(1e9 * frame.time) for frame, _, _ in run[0].scans()]
    assert len(times) == short_run.FRAMES
    units = {f"/lidar/{mount.name.replace(' ', '_')}/points" for mount in run[0].rig.mounts}
    assert {topic: {name for _, name, _ in found} for topic, found in messages.items()} == {
        **{topic: {"sensor_msgs/msg/PointCloud2"} for topic in units},
        "/clock": {"rosgraph_msgs/msg/Clock"},
        "/tf_static": {"tf2_msgs/msg/TFMessage"},
        **{f"/{role}/detections": {"vision_msgs/msg/Detection3DArray"} for role in ("truth", "tracks")},
        **{f"/{role}/objects": {"autoware_perception_msgs/msg/TrackedObjects"} for role in ("truth", "tracks")},
        "/tf": {"tf2_msgs/msg/TFMessage"},
        "/lidar/points": {"sensor_msgs/msg/PointCloud2"},
        "/truth/points": {"sensor_msgs/msg/PointCloud2"},
        "/truth/boxes": {"foxglove_msgs/msg/SceneUpdate"},
        "/tracks": {"foxglove_msgs/msg/SceneUpdate"},
    }
    for topic, found in messages.items():
        assert [time for time, _, _ in found] == (times[:1] if topic == "/tf_static" else times)
    for time, _, cloud in messages["/lidar/points"]:
        assert 1_000_000_000 * cloud.header.stamp.sec + cloud.header.stamp.nanosec == time
        assert cloud.header.frame_id == "ego"


def test_points_agree_with_the_scans(run, messages):
    """Fails if an offset, a type or a byte order is wrong."""
    for (_, scan, _), (_, _, cloud) in zip(run[0].scans(), messages["/lidar/points"], strict=True):
        points = columns(cloud)
        for axis, values in zip("xyz", scan.points_ego.T, strict=True):
            np.testing.assert_array_equal(points[axis], values)
        for name in ("time_offset", "unit", "layer", "echo", "echo_pulse_width", "flags"):
            np.testing.assert_array_equal(points[name], getattr(scan, name), err_msg=name)
            assert points[name].dtype == getattr(scan, name).dtype
        assert not cloud.is_bigendian
        assert cloud.is_dense
    assert max(len(scan) for _, scan, _ in run[0].scans()) > 100


def test_the_sensor_topic_contains_no_truth(messages):
    names = {field.name for _, _, cloud in messages["/lidar/points"] for field in cloud.fields}
    assert names == {"x", "y", "z", "time_offset", "unit", "layer", "echo", "echo_pulse_width", "flags"}


def test_truth_of_points_agrees_with_the_scans(run, messages):
    for (_, scan, truth), (_, _, cloud) in zip(run[0].scans(), messages["/truth/points"], strict=True):
        points = columns(cloud)
        np.testing.assert_array_equal(points["x"], scan.points_ego[:, 0])
        for name in ("actor_id", "part", "cause", "true_range"):
            np.testing.assert_array_equal(points[name], getattr(truth, name), err_msg=name)


def test_the_transform_is_the_odometry_pose(run, messages):
    for (_, scan, _), (_, _, message) in zip(run[0].scans(), messages["/tf"], strict=True):
        pose, _ = message.transforms
        assert (pose.header.frame_id, pose.child_frame_id) == ("odom", "ego")
        at, turn = pose.transform.translation, pose.transform.rotation
        np.testing.assert_allclose([at.x, at.y, yaw(turn)], scan.ego_pose_odom, atol=1e-12)


def boxes(scene):
    """Return centre, heading and size of each entity's box, by id."""
    found = {}
    for entity in scene.entities:
        (cube,) = entity.cubes
        at = cube.pose.position
        assert at.z == pytest.approx(0.5 * cube.size.z)
        assert entity.frame_id == "ego"
        found[entity.id] = [at.x, at.y, yaw(cube.pose.orientation), cube.size.x, cube.size.y]
    assert [deletion.type for deletion in scene.deletions] == [1]
    return found


def test_true_boxes_enclose_their_points(run, messages):
    for (frame, scan, truth), (_, _, scene) in zip(run[0].scans(), messages["/truth/boxes"], strict=True):
        found = boxes(scene)
        assert sorted(found) == sorted(f"actor {actor}" for actor in frame.actors.id)
        for actor in frame.actors.id:
            x, y, heading, length, width = found[f"actor {actor}"]
            seen = scan.points_ego[(truth.actor_id == actor) & (truth.cause == 0), :2] - (x, y)
            turn = np.array([[np.cos(heading), -np.sin(heading)], [np.sin(heading), np.cos(heading)]])
            inside = np.abs(seen @ turn) <= 0.5 * np.array([length, width]) + 0.5
            assert len(seen)
            assert inside.all(axis=1).mean() > 0.95


def test_track_boxes_agree_with_the_tracker(run, messages):
    tracker, shown = Tracker(run[0].scenario.tracker), 0
    for (_, scan, _), (_, _, scene) in zip(run[0].scans(), messages["/tracks"], strict=True):
        tracks, _ = tracker.step(scan)
        x, y, turn = scan.ego_pose_odom
        into_ego = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])
        found = boxes(scene)
        for t, center in enumerate(tracks.center_odom):
            if f"track {tracks.id[t]}" not in found:
                continue
            shown += 1
            box = found[f"track {tracks.id[t]}"]
            np.testing.assert_allclose(box[:2], (center - (x, y)) @ into_ego, atol=1e-9)
            off = box[2] - (tracks.mean[t, 6] - turn)
            assert np.cos(off) == pytest.approx(1.0)
            np.testing.assert_allclose(box[3:], tracks.size[t])
    assert shown > short_run.FRAMES


def test_rerun_accepts_the_file(run):
    """The text output is checked, because the exit code is always 0."""
    command = [sys.executable, "-m", "rerun_cli", "mcap", "check", "--full", str(run[1])]
    checked = subprocess.run(command, capture_output=True, text=True, check=True)
    topics = [line.split() for line in checked.stdout.splitlines() if " /" in line]
    own = {"/clock", "/tf", "/tf_static", "/lidar/points", "/truth/points", "/truth/boxes", "/tracks"}
    units = {f"/lidar/{mount.name.replace(' ', '_')}/points" for mount in run[0].rig.mounts}
    objects = {f"/{role}/{kind}" for role in ("truth", "tracks") for kind in ("detections", "objects")}
    assert {words[3] for words in topics} == own | units | objects
    assert {words[0] for words in topics} == {"ok"}, checked.stdout
    assert "ros2_timestamp" in checked.stdout


def test_the_export_is_reproducible(run, tmp_path):
    export_module.export(run[0], tmp_path / "again.mcap")
    assert (tmp_path / "again.mcap").read_bytes() == run[1].read_bytes()


def test_a_definition_contains_each_part_once():
    text = definition("foxglove_msgs/SceneUpdate")
    parts = [line.removeprefix("MSG: ") for line in text.splitlines() if line.startswith("MSG: ")]
    assert len(parts) == len(set(parts)) > 10
    assert "geometry_msgs/Quaternion" in parts


@pytest.mark.parametrize(
    ("name", "message"),
    [("there.mcap", "already exists"), ("nowhere/x.mcap", "cannot write there (No such file or directory)")],
)
def test_an_invalid_output_file_is_a_one_line_error(name, message, run, tmp_path, monkeypatch, capfd):
    monkeypatch.chdir(tmp_path)
    Path("there.mcap").write_text("mine")
    assert main(["mcap", str(run[0].folder), name]) == 2
    error = capfd.readouterr().err
    assert message in error
    assert error.count("\n") == 1
    assert [path.name for path in Path().iterdir()] == ["there.mcap"]
    assert Path("there.mcap").read_text() == "mine"


def test_a_failed_export_leaves_no_file(run, tmp_path, monkeypatch):
    monkeypatch.setattr(export_module, "transforms", lambda *_: (_ for _ in ()).throw(KeyboardInterrupt))
    with pytest.raises(KeyboardInterrupt):
        export_module.export(run[0], tmp_path / "x.mcap")
    assert list(tmp_path.iterdir()) == []
