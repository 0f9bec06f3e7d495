"""OSI traces: read by `osi3`, the implementation of ASAM, and by luxloop; counts, positions, points and velocities."""

import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from support.box_files import assert_same_grades, grades
from support.optional import need

need("osi")

from support import exported_run, separate_packages, short_run

from luxloop.scenarios.cli import main
from luxloop.scenarios.errors import TracksError
from luxloop.scenarios.exchange import file_formats
from luxloop.scenarios.exchange.osi import osi_values, trace_boxes
from luxloop.scenarios.grading.plane_geometry import into_frame
from luxloop.scenarios.offline.recorded_scans import RecordedRun
from luxloop.sensor_model.rig.beams import unit_table


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return exported_run.exported(tmp_path_factory.mktemp("osi"), "osi")


@pytest.fixture(scope="module")
def trace(folder):
    return folder / "osi" / "trace.mcap"


@pytest.fixture(scope="module")
def run(folder):
    return RecordedRun.open(folder / "run")


@pytest.fixture(scope="module")
def frames(run):
    return list(run.scans())


@pytest.fixture(scope="module")
def seen(trace):
    """The trace as `osi3` reads it, in a process with its own protobuf."""
    reader = Path(exported_run.__file__).with_name("osi3_reader.py")
    command, packages = [sys.executable, str(reader), str(trace)], str(separate_packages.folder_of("osi3"))
    done = subprocess.run(command, capture_output=True, check=True, env=os.environ | {"PYTHONPATH": packages})
    return json.loads(done.stdout)


def confirmed(run):
    tracks = run.result.tables["tracks"]
    return tracks[tracks["status"] == "confirmed"].reset_index(drop=True)


WORLD = ["x_world_m", "y_world_m", "yaw_world_rad", "length_m", "width_m"]
VELOCITY = ["vx_world_mps", "vy_world_mps"]


def test_the_file_is_a_multi_channel_trace_as_asam_defines_it(seen, run):
    """OSI trace file formats, multi channel trace file format: metadata, schemas, channels, chunks and times."""
    ((name, metadata),) = seen["metadata"]
    assert name == "net.asam.osi.trace"
    assert {key: metadata[key] for key in ("version", "min_osi_version", "max_osi_version")} == dict.fromkeys(
        ("version", "min_osi_version", "max_osi_version"), "3.8.0"
    )
    assert {"min_protobuf_version", "max_protobuf_version", "zero_time", "description"} <= metadata.keys()
    units = [mount.name for mount in run.rig.mounts]
    data = ["tracks", *(f"lidar/{unit}" for unit in units), *(f"truth/lidar/{unit}" for unit in units)]
    schemas = {"ground_truth": "osi3.GroundTruth", "tracks/world": "osi3.TrafficUpdate"}
    assert {topic: row[0] for topic, row in seen["channels"].items()} == schemas | dict.fromkeys(
        data, "osi3.SensorData"
    )
    for _, schema_encoding, encoding, channel in seen["channels"].values():
        assert (schema_encoding, encoding) == ("protobuf", "protobuf")
        assert channel["net.asam.osi.trace.channel.osi_version"] == "3.8.0"
        assert "net.asam.osi.trace.channel.protobuf_version" in channel
    assert seen["chunks"] > 0
    for messages in seen["messages"].values():
        assert all(message["time"] == message["publish"] == message["stamp"] for message in messages)
        assert {message["version"] for message in messages} == {8}


def test_the_truth_is_that_of_the_run(seen, frames, run):
    messages = seen["messages"]["ground_truth"]
    assert len(messages) == len(frames)
    for (frame, _, _), message in zip(frames, messages, strict=True):
        assert message["stamp"] == round(1e9 * frame.time)
        host, *others = message["moving"]
        ego, actors = frame.ego, frame.actors
        height = ego.size[2]
        assert host == [
            message["host"], 2, *ego.pose_world, *ego.size[:2], *ego.velocity_world, *ego.acceleration_world,
            ego.yaw_rate, height, height / 2,
        ]  # fmt: skip
        assert message["rear"] == [run.rig.rear_axle_x_m, 0.0, -height / 2]
        assert others == [
            [
                actors.id[a], 2, *actors.pose_world[a], *actors.size[a, :2], *actors.velocity_world[a],
                *actors.acceleration_world[a], actors.yaw_rate[a], actors.size[a, 2], actors.size[a, 2] / 2,
            ]
            for a in range(len(actors))
        ]  # fmt: skip
        assert [name for name, _ in message["kinds"][1:]] == actors.name.tolist()
    ids = {row[0] for message in messages for row in (*message["moving"], *message["stationary"])}
    assert len(ids) == 1 + len(frames[0][0].actors) + 2


def test_obstacles_have_the_boxes_of_the_scenario(seen):
    """By hand: a wall from (-20, 15) to (20, 15), 3 m high, and a house from (-12, -20) to (-4, -14), 1 m to 6 m."""
    for message in seen["messages"]["ground_truth"]:
        wall, house = (row[1:] for row in message["stationary"])
        assert wall == pytest.approx([0.0, 15.0, 0.0, 40.0, 0.0, 3.0, 1.5])
        assert house == pytest.approx([-8.0, -17.0, 0.0, 8.0, 6.0, 6.0, 3.0])


def test_detections_are_the_points_of_each_unit(seen, frames, run):
    """Turned back by the definition of OSI: elevation about y by the right-hand rule, then azimuth about z."""
    units, total = unit_table(run.rig), 0
    for unit, mount in enumerate(run.rig.mounts):
        both = (seen["messages"][f"{prefix}lidar/{mount.name}"] for prefix in ("", "truth/"))
        for (_, scan, truth), message, known in zip(frames, *both, strict=True):
            rows = np.flatnonzero(scan.unit == unit)
            found = np.array(message["points"]).reshape(-1, 7)
            distance, azimuth, elevation = found[:, :3].T
            level = distance * np.cos(elevation)
            local = np.column_stack([level * np.cos(azimuth), level * np.sin(azimuth), -distance * np.sin(elevation)])
            ego = local @ units.R_ego_unit[unit].T + units.origin_ego[unit]
            np.testing.assert_allclose(ego, scan.points_ego[rows], atol=1e-9)
            np.testing.assert_array_equal(found[:, 3], scan.layer[rows])
            np.testing.assert_array_equal(found[:, 4], scan.echo_pulse_width[rows])
            assert not found[:, 6].any(), "the truth is in its own channel"
            angles = np.deg2rad([mount.yaw_deg, mount.pitch_deg, mount.roll_deg])
            np.testing.assert_allclose(message["mounting"], [mount.x_m, mount.y_m, mount.z_m, *angles])
            actors = [2**64 - 1 if actor < 0 else actor for actor in truth.actor_id[rows].tolist()]
            assert [row[5] for row in known["points"]] == actors
            true = np.array(known["points"]).reshape(-1, 7)
            np.testing.assert_array_equal(true[:, 0], truth.true_range[rows])
            np.testing.assert_array_equal(true[:, 1:4], found[:, 1:4])
            total += len(rows)
    assert total == sum(len(scan) for _, scan, _ in frames) > 1000


def test_tracks_are_those_of_the_run_in_both_frames(seen, frames, run):
    tracks, updates = confirmed(run), seen["messages"]["tracks/world"]
    expected = tracks[["track_id", *WORLD, *VELOCITY]].to_numpy(float)
    np.testing.assert_array_equal([message["update"] for message in updates], expected)
    assert len(updates) > short_run.FRAMES / 2
    for (frame, _, _), message in zip(frames, seen["messages"]["tracks"], strict=True):
        own = tracks[tracks["frame"] == frame.index]
        assert [row[0] for row in message["tracks"]] == own["track_id"].tolist()
        assert message["mounting"] == [-run.rig.rear_axle_x_m, 0.0, 0.0, 0.0, 0.0, 0.0]
        for row, pose in zip(message["tracks"], own[WORLD[:3]].to_numpy(), strict=True):
            np.testing.assert_array_equal(row[1:4], into_frame(pose[None], frame.ego.pose_world)[0])


def test_both_implementations_find_the_same_objects(seen, trace):
    """`osi3` and `betterosi`, which luxloop uses: the same counts, ids, positions and sizes."""
    truth, _ = trace_boxes.read(trace, "truth")
    others = [row for message in seen["messages"]["ground_truth"] for row in message["moving"][1:]]
    assert truth.id.tolist() == [str(row[0]) for row in others]
    np.testing.assert_array_equal(truth.boxes, [row[2:7] for row in others])
    world, ego = trace_boxes.read(trace, "tracks")
    updates = [message["update"] for message in seen["messages"]["tracks/world"]]
    detected = [row for message in seen["messages"]["tracks"] for row in message["tracks"]]
    for table, rows in ((world, updates), (ego, detected)):
        assert table.id.tolist() == [str(row[0]) for row in rows]
        np.testing.assert_array_equal(table.boxes, [row[1:6] for row in rows])


def test_numbers_of_points_are_those_of_the_data_set(folder, trace):
    labels = pd.read_parquet(folder / "run" / "scans" / "labels.parquet")
    expected = {(row.frame, str(row.actor_id)): row.points for row in labels.itertuples()}
    for table in trace_boxes.read(trace, "truth"):
        assert dict(zip(zip(table.frame, table.id, strict=True), table.points, strict=True)) == expected
    assert max(expected.values()) > 0


@pytest.mark.parametrize("text", ["many", "-1", "9" * 30])
def test_another_text_than_a_number_of_points_is_no_number(text):
    import betterosi as osi

    moving = osi.MovingObject(
        source_reference=[osi.ExternalReference(type=osi_values.POINTS_REFERENCE, identifier=[text])]
    )
    assert osi_values.points(moving) is None


def test_tracks_are_read_back_bit_for_bit(trace, run, frames):
    world, ego = trace_boxes.read(trace, "tracks")
    tracks = confirmed(run)
    assert (world.axes, ego.axes) == ("world", "ego")
    assert world.id.tolist() == ego.id.tolist() == [str(track) for track in tracks["track_id"]]
    assert world.boxes.tobytes() == tracks[WORLD].to_numpy(np.float64).tobytes()
    assert world.velocity.tobytes() == tracks[VELOCITY].to_numpy(np.float64).tobytes()
    poses = {frame.index: frame.ego.pose_world for frame, _, _ in frames}
    rows = zip(tracks["frame"], tracks[WORLD[:3]].to_numpy(np.float64), strict=True)
    expected = np.array([into_frame(pose[None], poses[frame])[0] for frame, pose in rows])
    assert ego.boxes[:, :3].tobytes() == expected.tobytes()
    turn = np.array([poses[frame][2] for frame in tracks["frame"]])
    x, y = world.velocity.T
    turned = np.column_stack([np.cos(turn) * x + np.sin(turn) * y, np.cos(turn) * y - np.sin(turn) * x])
    np.testing.assert_allclose(ego.velocity, turned, atol=1e-12)


def test_relative_velocities_are_differences_of_relative_positions(trace):
    """The ego turns, so that a standing object moves in its frame: OSI's velocity is d(position)/dt there."""
    import betterosi

    places, speeds, times = {}, {}, {}
    truth = [m for m in betterosi.read(str(trace)) if isinstance(m, betterosi.SensorData) and m.moving_object]
    for message in truth:
        for item in message.moving_object:
            name, base = item.header.tracking_id.value, item.base
            places.setdefault(name, []).append((base.position.x, base.position.y))
            speeds.setdefault(name, []).append((base.velocity.x, base.velocity.y))
            times.setdefault(name, []).append(message.timestamp.seconds + 1e-9 * message.timestamp.nanos)
    checked = 0
    for name, place in places.items():
        if len(place) < 4:
            continue
        rate = np.diff(place, axis=0) / np.diff(times[name])[:, None]
        np.testing.assert_allclose(np.mean(rate, axis=0), np.mean(speeds[name], axis=0), atol=0.5)
        checked += 1
    assert checked
    assert np.abs(np.concatenate([*speeds.values()])).max() > 1.0


def test_grades_are_those_of_the_tables(folder, trace, capsys):
    own = grades(capsys, folder / "run/scans/labels.parquet", folder / "run/tables/tracks.parquet")
    assert_same_grades(grades(capsys, trace, trace), own)
    assert_same_grades(grades(capsys, folder / "run/scans/labels.parquet", trace), own)
    assert own["track.hota"] > 0.2
    assert own["track.velocity_abs_mean_mps"] is not None


def test_a_trace_is_recognised_and_its_export_is_reproducible(folder, trace, tmp_path):
    assert file_formats.recognise(trace) == "osi"
    assert main(["export", str(folder / "run"), "--format", "osi", "--out", str(tmp_path / "again")]) == 0
    assert (tmp_path / "again" / "trace.mcap").read_bytes() == trace.read_bytes()


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ("cut", "cannot be read ("),
        ("empty", "has no message osi3.SensorData or TrafficUpdate; give a trace with one"),
        ("bare", "cannot be read (time 2 s, object 5: its base has no position or no dimension)"),
    ],
)
def test_a_damaged_trace_is_one_line(content, message, trace, tmp_path, capfd):
    import betterosi

    path = tmp_path / "bad.mcap"
    if content == "cut":
        path.write_bytes(trace.read_bytes()[:5000])
    elif content == "bare":
        item = betterosi.DetectedMovingObject(
            header=betterosi.DetectedItemHeader(tracking_id=betterosi.Identifier(value=5))
        )
        with betterosi.Writer(path) as writer:
            writer.add(
                betterosi.SensorData(timestamp=betterosi.Timestamp(seconds=2, nanos=0), moving_object=[item]), "sd"
            )
    else:
        with betterosi.Writer(path) as writer:
            writer.add(betterosi.HostVehicleData(timestamp=betterosi.Timestamp(seconds=0, nanos=0)), "host")
    capfd.readouterr()
    assert main(["grade", "--truth", str(trace), "--tracks", str(path)]) == 2
    error = capfd.readouterr().err
    assert str(path) in error
    assert message in error
    assert error.count("\n") == 1


@pytest.mark.parametrize(
    ("role", "fields", "message"),
    [
        ("truth", {}, "osi3.GroundTruth 2: no timestamp; give each message its time"),
        ("tracks", {}, "osi3.TrafficUpdate 2: no timestamp; give each message its time"),
        ("truth", {"moving_object": True}, "time 1 s: an object without id; give each object an id"),
        ("tracks", {"update": True}, "time 1 s: an object without id; give each object an id"),
    ],
)
def test_a_missing_field_of_a_message_is_named(role, fields, message, tmp_path):
    import betterosi as osi

    kind, path = osi.GroundTruth if role == "truth" else osi.TrafficUpdate, tmp_path / "bad.mcap"
    stamp = osi.Timestamp(seconds=1, nanos=0)
    second = kind(timestamp=stamp, **{name: [osi.MovingObject()] for name in fields}) if fields else kind()
    with osi.Writer(path) as writer:
        writer.add(kind(timestamp=osi.Timestamp(seconds=0, nanos=0)), "a", 0)
        writer.add(second, "a", 10**9)
    with pytest.raises(TracksError) as error:
        trace_boxes.read(path, role)
    assert str(error.value) == f"{path}: {message}"


def test_a_trace_of_another_program_is_placed_by_its_rear_axle(tmp_path):
    """By hand: the host at (100, 50) heads north at 5 m/s; its axle is 1.5 m behind, the sensor 2 m before the axle.

    An object 10 m ahead of the sensor and 1 m to the left is 10.5 m ahead of the box centre; it approaches at 3 m/s,
    so it drives north at 2 m/s.
    """
    import betterosi as osi

    now = osi.Timestamp(seconds=1, nanos=0)
    host = osi.MovingObject(
        id=osi.Identifier(value=7),
        base=osi.BaseMoving(
            dimension=osi.Dimension3d(length=4.5, width=1.8, height=1.5),
            position=osi.Vector3d(x=100.0, y=50.0, z=0.75),
            orientation=osi.Orientation3d(yaw=np.pi / 2),
            velocity=osi.Vector3d(x=0.0, y=5.0, z=0.0),
        ),
        vehicle_attributes=osi.MovingObject.VehicleAttributes(bbcenter_to_rear=osi.Vector3d(x=-1.5, y=0.0, z=-0.4)),
    )
    item = osi.DetectedMovingObject(
        header=osi.DetectedItemHeader(tracking_id=osi.Identifier(value=3)),
        base=osi.BaseMoving(
            dimension=osi.Dimension3d(length=4.0, width=1.7, height=1.4),
            position=osi.Vector3d(x=10.0, y=1.0, z=0.0),
            orientation=osi.Orientation3d(yaw=0.1),
            velocity=osi.Vector3d(x=-3.0, y=0.0, z=0.0),
        ),
    )
    mounted = osi.MountingPosition(position=osi.Vector3d(x=2.0, y=0.0, z=0.5))
    path = tmp_path / "other.mcap"
    with osi.Writer(path) as writer:
        writer.add(osi.GroundTruth(timestamp=now, host_vehicle_id=osi.Identifier(value=7), moving_object=[host]), "gt")
        writer.add(osi.SensorData(timestamp=now, mounting_position=mounted, moving_object=[item]), "sd")
    (table,) = trace_boxes.read(path, "tracks")
    assert table.axes == "ego"
    np.testing.assert_allclose(table.boxes, [[10.5, 1.0, 0.1, 4.0, 1.7]])
    np.testing.assert_allclose(table.velocity, [[2.0, 0.0]], atol=1e-12)
    np.testing.assert_allclose(table.time_s, [1.0])
