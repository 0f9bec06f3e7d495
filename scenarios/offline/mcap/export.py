"""Export of a recorded run as an MCAP file.

| topic | message | content |
|---|---|---|
| `/clock` | `rosgraph_msgs/Clock` | time of the frame |
| `/tf` | `tf2_msgs/TFMessage` | pose of the ego by odometry, and of the odometry frame in the world |
| `/tf_static` | `tf2_msgs/TFMessage` | rear axle and units in the ego frame, once |
| `/lidar/points` | `sensor_msgs/PointCloud2` | the scan, as input of the tracker |
| `/lidar/UNIT/points` | `sensor_msgs/PointCloud2` | points of a unit in its own frame, in the layout of ROS drivers |
| `/truth/points` | `sensor_msgs/PointCloud2` | the same points with their ground truth |
| `/truth/boxes` | `foxglove_msgs/SceneUpdate` | boxes of the actors |
| `/tracks` | `foxglove_msgs/SceneUpdate` | tracks of the run |
| `/truth/detections`, `/tracks/detections` | `vision_msgs/Detection3DArray` | actors; confirmed tracks |
| `/truth/objects`, `/tracks/objects` | `autoware_perception_msgs/TrackedObjects` | the same with motion |

Times start at 0, as in the run; the file does not depend on the time of writing.
"""

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
import scipy
from mcap_ros2.writer import Writer

from luxloop.arrays import Floats
from luxloop.scenarios.errors import OutputError
from luxloop.scenarios.files import atomic_file
from luxloop.scenarios.offline.mcap.messages import (
    BASE_LINK,
    EGO,
    Message,
    clock,
    cloud,
    definition,
    full_name,
    header,
    nanoseconds,
    packed_cloud,
    scene,
    transforms,
    vector,
)
from luxloop.scenarios.offline.mcap.objects import (
    actor_boxes,
    actor_objects,
    detections,
    track_boxes,
    track_objects,
    tracked_objects,
)
from luxloop.scenarios.offline.recorded_scans import RecordedRun
from luxloop.sensor_model.rig.beams import UnitTable, unit_table
from luxloop.sensor_model.rig.rig import Mount, Rig
from luxloop.sensor_model.truth import ScanTruth
from luxloop.sim.world import WorldFrame
from luxloop.tracker.scan import Scan

LAYOUT = np.dtype(
    {
        "names": ["x", "y", "z", "intensity", "ring", "time"],
        "formats": ["<f4", "<f4", "<f4", "<f4", "<u2", "<f4"],
        "offsets": [0, 4, 8, 16, 20, 24],
        "itemsize": 32,
    }
)
"""`velodyne_pcl::PointXYZIRT` of the Velodyne driver (ROS 2 branch); the time is relative to the stamp of the cloud."""


def unit_frame(mount: Mount) -> str:
    """Return the name of the frame of a unit."""
    return f"lidar_{plain_name(mount)}"


def plain_name(mount: Mount) -> str:
    """Return the name of a unit without characters that ROS does not allow in topics."""
    return re.sub(r"\W", "_", mount.name)


def unit_cloud(time_ns: int, scan: Scan, unit: int, mount: Mount, units: UnitTable) -> Message:
    """Return the `sensor_msgs/PointCloud2` of a unit in its own frame; the echo pulse width [m] is the intensity."""
    rows = np.flatnonzero(scan.unit == unit)
    local = (scan.points_ego[rows].astype(np.float64) - units.origin_ego[unit]) @ units.R_ego_unit[unit]
    points = np.zeros(len(rows), LAYOUT)
    points["x"], points["y"], points["z"] = local.T
    points["intensity"], points["ring"] = scan.echo_pulse_width[rows], scan.layer[rows]
    points["time"] = scan.time_offset[rows]
    return packed_cloud(time_ns, unit_frame(mount), points)


def static_transforms(time_ns: int, rig: Rig, units: UnitTable) -> Message:
    """Return a `tf2_msgs/TFMessage` with the rear axle (on the ground) and the units in the ego frame."""
    rotations = scipy.spatial.transform.Rotation.from_matrix(units.R_ego_unit).as_quat()
    axle = _transform(time_ns, BASE_LINK, np.array([rig.rear_axle_x_m, 0.0, 0.0]), np.array([0.0, 0.0, 0.0, 1.0]))
    found = zip(rig.mounts, units.origin_ego, rotations, strict=True)
    return {"transforms": [axle, *(_transform(time_ns, unit_frame(mount), *pose) for mount, *pose in found)]}


def _transform(time_ns: int, child: str, origin: Floats, rotation: Floats) -> Message:
    turn = dict(zip("xyzw", rotation.tolist(), strict=True))
    pose = {"translation": vector(*origin.tolist()), "rotation": turn}
    return {"header": header(time_ns, EGO), "child_frame_id": child, "transform": pose}


CLOUD, BOXES, TRANSFORM = "sensor_msgs/PointCloud2", "foxglove_msgs/SceneUpdate", "tf2_msgs/TFMessage"
CLOCK, DETECTIONS = "rosgraph_msgs/Clock", "vision_msgs/Detection3DArray"
OBJECTS = "autoware_perception_msgs/TrackedObjects"
TYPES = (CLOUD, BOXES, TRANSFORM, CLOCK, DETECTIONS, OBJECTS)
CHUNK_BYTES = 1
"""Chunk size that gives each message its own chunk: rerun's importer overlaps clouds of one chunk in time."""


class Sent(NamedTuple):
    """A message with its topic and type."""

    topic: str
    name: str
    message: Message


def export(run: RecordedRun, path: Path) -> int:
    """Write scans, ground truth and tracks of a run; return the number of frames.

    Raises
    ------
    OutputError
        The run has no scans, or the file exists or cannot be written.
    """
    if path.exists():
        raise OutputError(f"{path}: already exists; choose another file")
    scans = run.scans()
    try:
        with (
            atomic_file.create(path) as temporary,
            temporary.open("wb") as stream,
            Writer(stream, chunk_size=CHUNK_BYTES) as writer,
        ):
            schemas = {name: writer.register_msgdef(full_name(name), definition(name)) for name in TYPES}
            for frame, sent in _messages(run):
                writer.write_message(
                    sent.topic, schemas[sent.name], sent.message, nanoseconds(frame.time), sequence=frame.index
                )
    except OSError as error:
        raise OutputError(f"{path}: cannot write there ({error.strerror}); choose another file") from error
    return len(scans)


def _messages(run: RecordedRun) -> Iterator[tuple[WorldFrame, Sent]]:
    """Yield the messages of all frames; static transforms come with the first one."""
    units, table = unit_table(run.rig), run.result.tables["tracks"]
    tracks, none = dict(list(table.groupby("frame"))), table.iloc[:0]
    for frame, scan, truth in run.scans():
        time_ns, found = nanoseconds(frame.time), tracks.get(frame.index, none)
        sent = [Sent("/clock", CLOCK, clock(time_ns))]
        if frame.index == 0:
            sent.append(Sent("/tf_static", TRANSFORM, static_transforms(time_ns, run.rig, units)))
        for unit, mount in enumerate(run.rig.mounts):
            points = unit_cloud(time_ns, scan, unit, mount, units)
            sent.append(Sent(f"/lidar/{plain_name(mount)}/points", CLOUD, points))
        sent += _scan_messages(time_ns, frame, scan, truth)
        sent.append(Sent("/tracks", BOXES, scene(time_ns, track_boxes(frame, found))))
        for role, objects in (("truth", actor_objects(frame)), ("tracks", track_objects(found))):
            sent.append(Sent(f"/{role}/detections", DETECTIONS, detections(time_ns, objects)))
            sent.append(Sent(f"/{role}/objects", OBJECTS, tracked_objects(time_ns, objects)))
        yield from ((frame, message) for message in sent)


def _scan_messages(time_ns: int, frame: WorldFrame, scan: Scan, truth: ScanTruth) -> list[Sent]:
    """Return the messages of a frame in the ego frame, without those of the tracker."""
    return [
        Sent("/tf", TRANSFORM, transforms(time_ns, scan.ego_pose_odom, frame.ego.pose_world)),
        Sent("/lidar/points", CLOUD, cloud(time_ns, _scan_columns(scan))),
        Sent("/truth/points", CLOUD, cloud(time_ns, _truth_columns(scan, truth))),
        Sent("/truth/boxes", BOXES, scene(time_ns, actor_boxes(frame, truth))),
    ]


def _positions(scan: Scan) -> dict[str, npt.NDArray[Any]]:
    return dict(zip("xyz", scan.points_ego.T, strict=True))


def _scan_columns(scan: Scan) -> dict[str, npt.NDArray[Any]]:
    names = ("time_offset", "unit", "layer", "echo", "echo_pulse_width", "flags")
    return {**_positions(scan), **{name: getattr(scan, name) for name in names}}


def _truth_columns(scan: Scan, truth: ScanTruth) -> dict[str, npt.NDArray[Any]]:
    ids = truth.actor_id.astype(np.int32)  # a PointCloud2 has no 64-bit integers; ids are small
    return {
        **_positions(scan),
        "actor_id": ids,
        "part": truth.part,
        "cause": truth.cause,
        "true_range": truth.true_range,
    }
