"""Messages of `luxloop mcap` for ROS 2, read by `rosbags`, and boxes read back from them."""

import numpy as np
import pandas as pd
import pytest
from support.box_files import assert_same_grades, grades
from support.optional import need

need("recordings")

from rosbags.highlevel import AnyReader
from support import exported_run

from luxloop.scenarios.cli import main
from luxloop.scenarios.exchange import mcap_boxes
from luxloop.scenarios.grading.plane_geometry import into_frame
from luxloop.scenarios.offline.recorded_scans import RecordedRun
from luxloop.sensor_model.rig.beams import unit_table
from luxloop.sim.world import Mode

WORLD = ["x_world_m", "y_world_m", "yaw_world_rad", "length_m", "width_m"]
VELOCITY = ["vx_world_mps", "vy_world_mps"]


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("ros2")
    assert main(["mcap", str(exported_run.recorded(folder)), str(folder / "run.mcap")]) == 0
    return folder


@pytest.fixture(scope="module")
def run(folder):
    return RecordedRun.open(folder / "run")


@pytest.fixture(scope="module")
def frames(run):
    return list(run.scans())


@pytest.fixture(scope="module")
def bag(folder):
    """Messages by topic, decoded by rosbags with the definitions of the file: a wrong one shows."""
    found = {}
    with AnyReader([folder / "run.mcap"]) as reader:
        for connection, time_ns, raw in reader.messages():
            message = reader.deserialize(raw, connection.msgtype)
            found.setdefault(connection.topic, []).append((time_ns, connection.msgtype, message))
    return found


@pytest.fixture(scope="module")
def confirmed(run):
    tracks = run.result.tables["tracks"]
    return tracks[tracks["status"] == "confirmed"].reset_index(drop=True)


def matrix(transform):
    """(4, 4) transform of a `geometry_msgs/Transform`, by the formula of quaternions."""
    at, q = transform.translation, transform.rotation
    out = np.eye(4)
    out[:3, :3] = [
        [1 - 2 * (q.y**2 + q.z**2), 2 * (q.x * q.y - q.z * q.w), 2 * (q.x * q.z + q.y * q.w)],
        [2 * (q.x * q.y + q.z * q.w), 1 - 2 * (q.x**2 + q.z**2), 2 * (q.y * q.z - q.x * q.w)],
        [2 * (q.x * q.z - q.y * q.w), 2 * (q.y * q.z + q.x * q.w), 1 - 2 * (q.x**2 + q.y**2)],
    ]
    out[:3, 3] = at.x, at.y, at.z
    return out


def heading(pose):
    return 2.0 * np.arctan2(pose.orientation.z, pose.orientation.w)


def cloud_points(cloud):
    """Points as C++ drivers read them: by the offsets of `velodyne_pcl::PointXYZIRT`."""
    offsets = {field.name: (field.offset, field.datatype, field.count) for field in cloud.fields}
    assert offsets == {"x": (0, 7, 1), "y": (4, 7, 1), "z": (8, 7, 1), "intensity": (16, 7, 1), "ring": (20, 4, 1),
                       "time": (24, 7, 1)}  # fmt: skip
    assert cloud.point_step == 32
    raw = np.frombuffer(cloud.data.tobytes(), np.uint8).reshape(-1, 32)
    number = {
        name: raw[:, at : at + 4].copy().view("<f4")[:, 0] for name, (at, code, _) in offsets.items() if code == 7
    }
    return number | {"ring": raw[:, 20:22].copy().view("<u2")[:, 0]}


def test_the_clock_and_all_stamps_are_the_time_of_the_frame(bag, frames):
    times = [round(1e9 * frame.time) for frame, _, _ in frames]
    assert [message.clock.sec * 10**9 + message.clock.nanosec for _, _, message in bag["/clock"]] == times
    for topic, messages in bag.items():
        if topic not in ("/tf_static", "/tracks", "/truth/boxes"):
            assert [time_ns for time_ns, _, _ in messages] == times, topic


def test_the_units_are_mounted_by_static_transforms(bag, run):
    """The rig file gives them from the rear axle; yaw about z, then pitch about y, then roll about x."""
    ((_, kind, message),) = bag["/tf_static"]
    assert kind == "tf2_msgs/msg/TFMessage"
    found = {transform.child_frame_id: transform for transform in message.transforms}
    assert all(transform.header.frame_id == "ego" for transform in found.values())
    assert matrix(found["base_link"].transform)[:3, 3].tolist() == [run.rig.rear_axle_x_m, 0.0, 0.0]
    for mount in run.rig.mounts:
        pose = matrix(found[f"lidar_{mount.name.replace(' ', '_')}"].transform)
        np.testing.assert_allclose(pose[:3, 3], [run.rig.rear_axle_x_m + mount.x_m, mount.y_m, mount.z_m])
        yaw, pitch = np.deg2rad([mount.yaw_deg, mount.pitch_deg])
        ahead = [np.cos(yaw) * np.cos(pitch), np.sin(yaw) * np.cos(pitch), -np.sin(pitch)]
        np.testing.assert_allclose(pose[:3, 0], ahead, atol=1e-12)
    assert len(found) == 1 + len(run.rig.mounts)


def test_clouds_of_units_are_the_scan_in_the_layout_of_drivers(bag, run, frames):
    statics = {found.child_frame_id: matrix(found.transform) for found in bag["/tf_static"][0][2].transforms}
    total = 0
    for unit, mount in enumerate(run.rig.mounts):
        name = mount.name.replace(" ", "_")
        for (_, scan, _), (_, _, cloud) in zip(frames, bag[f"/lidar/{name}/points"], strict=True):
            rows, points = np.flatnonzero(scan.unit == unit), cloud_points(cloud)
            assert cloud.header.frame_id == f"lidar_{name}"
            local = np.column_stack([points["x"], points["y"], points["z"], np.ones(len(rows))])
            np.testing.assert_allclose(
                (local @ statics[cloud.header.frame_id].T)[:, :3], scan.points_ego[rows], atol=2e-5
            )
            np.testing.assert_array_equal(points["intensity"], scan.echo_pulse_width[rows])
            np.testing.assert_array_equal(points["ring"], scan.layer[rows])
            np.testing.assert_array_equal(points["time"], scan.time_offset[rows])
            total += len(rows)
    assert total == sum(len(scan) for _, scan, _ in frames) > 1000
    assert len(unit_table(run.rig)) == len(run.rig.mounts)


def test_the_odometry_frame_closes_the_way_from_the_world_to_the_ego(bag, frames):
    for (frame, _, _), (_, _, message) in zip(frames, bag["/tf"], strict=True):
        by_child = {found.child_frame_id: found for found in message.transforms}
        assert {name: found.header.frame_id for name, found in by_child.items()} == {"ego": "odom", "odom": "map"}
        pose = matrix(by_child["odom"].transform) @ matrix(by_child["ego"].transform)
        x, y, yaw = frame.ego.pose_world
        np.testing.assert_allclose(pose[:2, 3], [x, y], atol=1e-9)
        np.testing.assert_allclose(pose[:2, 0], [np.cos(yaw), np.sin(yaw)], atol=1e-12)


def test_objects_of_autoware_are_the_actors(bag, frames):
    """Velocities lie on the axes of the object; turned back, they are those of the truth."""
    moving = 0
    for (frame, _, _), (_, kind, message) in zip(frames, bag["/truth/objects"], strict=True):
        assert kind == "autoware_perception_msgs/msg/TrackedObjects"
        assert message.header.frame_id == "map"
        assert [
            int.from_bytes(bytes(found.object_id.uuid), "big") for found in message.objects
        ] == frame.actors.id.tolist()
        for a, found in enumerate(message.objects):
            pose, twist = found.kinematics.pose_with_covariance.pose, found.kinematics.twist_with_covariance.twist
            assert (pose.position.x, pose.position.y) == tuple(frame.actors.pose_world[a, :2])
            yaw = heading(pose)
            assert np.cos(yaw - frame.actors.pose_world[a, 2]) == pytest.approx(1.0)
            turn = np.array([[np.cos(yaw), -np.sin(yaw)], [np.sin(yaw), np.cos(yaw)]])
            np.testing.assert_allclose(
                turn @ (twist.linear.x, twist.linear.y), frame.actors.velocity_world[a], atol=1e-12
            )
            size = found.shape.dimensions
            assert (size.x, size.y, size.z) == tuple(frame.actors.size[a])
            assert pose.position.z == size.z / 2
            assert (found.shape.type, found.classification[0].label) == (0, 1)
            assert found.kinematics.is_stationary == (frame.actors.mode[a] == Mode.STATIONARY)
            moving += not found.kinematics.is_stationary
    assert moving


def test_detections_are_the_actors_and_the_confirmed_tracks(bag, frames, confirmed):
    for role, expected in (("truth", None), ("tracks", confirmed)):
        for (frame, _, _), (_, kind, message) in zip(frames, bag[f"/{role}/detections"], strict=True):
            assert kind == "vision_msgs/msg/Detection3DArray"
            if expected is None:
                rows = np.column_stack([frame.actors.id, frame.actors.pose_world[:, :2], frame.actors.size[:, :2]])
            else:
                own = expected[expected["frame"] == frame.index]
                rows = own[["track_id", "x_world_m", "y_world_m", "length_m", "width_m"]].to_numpy(float)
            found = [
                [int(d.id), d.bbox.center.position.x, d.bbox.center.position.y, d.bbox.size.x, d.bbox.size.y]
                for d in message.detections
            ]
            np.testing.assert_array_equal(np.array(found).reshape(-1, 5), rows)


def test_tracks_and_truth_are_read_back_bit_for_bit(folder, frames, confirmed):
    world, ego = mcap_boxes.read(folder / "run.mcap", "tracks")
    assert (world.axes, ego.axes) == ("world", "ego")
    assert world.id.tolist() == [f"track {track}" for track in confirmed["track_id"]]
    assert world.frame.tolist() == confirmed["frame"].tolist()
    assert world.boxes.tobytes() == confirmed[WORLD].to_numpy(np.float64).tobytes()
    assert world.velocity.tobytes() == confirmed[VELOCITY].to_numpy(np.float64).tobytes()
    poses = {frame.index: frame.ego.pose_world for frame, _, _ in frames}
    rows = zip(confirmed["frame"], confirmed[WORLD[:3]].to_numpy(np.float64), strict=True)
    expected = np.array([into_frame(pose[None], poses[frame])[0] for frame, pose in rows])
    assert ego.boxes[:, :3].tobytes() == expected.tobytes()
    truth, _ = mcap_boxes.read(folder / "run.mcap", "truth")
    actors = [frame.actors for frame, _, _ in frames]
    boxes = np.concatenate([np.column_stack([found.pose_world, found.size[:, :2]]) for found in actors])
    assert truth.boxes.tobytes() == boxes.tobytes()
    assert truth.velocity.tobytes() == np.concatenate([found.velocity_world for found in actors]).tobytes()


def test_grades_are_those_of_the_tables(folder, capsys):
    labels, tracks = folder / "run/scans/labels.parquet", folder / "run/tables/tracks.parquet"
    own = grades(capsys, labels, tracks)
    assert_same_grades(grades(capsys, folder / "run.mcap", folder / "run.mcap"), own)
    assert_same_grades(grades(capsys, labels, folder / "run.mcap"), own)
    assert own["track.hota"] > 0.2
    assert own["track.velocity_abs_mean_mps"] is not None


@pytest.mark.parametrize(("kept", "velocity"), [("objects", True), ("detections", False)])
def test_objects_of_other_programs_are_read(kept, velocity, folder, run, confirmed, tmp_path):
    """A file with one topic of Autoware or vision_msgs and its header's frame of reference."""
    from mcap.reader import make_reader
    from mcap.writer import Writer

    path = tmp_path / "other.mcap"
    with (folder / "run.mcap").open("rb") as stream, path.open("wb") as out:
        writer = Writer(out)
        writer.start("ros2")
        channels = {}
        for schema, channel, message in make_reader(stream).iter_messages(topics=[f"/tracks/{kept}"]):
            if not channels:
                written = writer.register_schema(schema.name, schema.encoding, schema.data)
                channels[channel.id] = writer.register_channel("/perception/objects", "cdr", written)
            writer.add_message(channels[channel.id], message.log_time, message.data, message.log_time)
        writer.finish()
    (table,) = mcap_boxes.read(path, "tracks")
    assert table.axes == "world"
    assert table.frame is None
    np.testing.assert_allclose(table.boxes, confirmed[WORLD].to_numpy(float), atol=1e-12)
    np.testing.assert_allclose(table.time_s, confirmed["time_s"], atol=1e-9)
    assert set(table.score.tolist()) == {1.0}
    assert pd.Series(table.id).nunique() == confirmed["track_id"].nunique()
    if velocity:
        np.testing.assert_allclose(table.velocity, confirmed[VELOCITY].to_numpy(float), atol=1e-12)
    else:
        assert table.velocity is None
    assert len(run.rig.mounts) > 1
