"""Export of a recorded run as an MCAP file.

| topic | message | content |
|---|---|---|
| `/tf` | `tf2_msgs/TFMessage` | pose of the ego by odometry |
| `/lidar/points` | `sensor_msgs/PointCloud2` | the scan, as input of the tracker |
| `/truth/points` | `sensor_msgs/PointCloud2` | the same points with their ground truth |
| `/truth/boxes` | `foxglove_msgs/SceneUpdate` | boxes of the actors |
| `/tracks` | `foxglove_msgs/SceneUpdate` | tracks of the run |

Times start at 0, as in the run; the file does not depend on the time of writing.
"""

from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pandas as pd
from mcap_ros2.writer import Writer

from scenarios.errors import OutputError
from scenarios.files import atomic_file
from scenarios.grading.plane_geometry import into_frame
from scenarios.offline.mcap.definitions import definition, full_name
from scenarios.offline.mcap.messages import Box, Color, cloud, nanoseconds, scene, transform
from scenarios.offline.recorded_run import RecordedRun
from sensor_model.truth import ScanTruth
from sim.world import Kind, WorldFrame
from tracker.scan import Scan

CLOUD, BOXES, TRANSFORM = "sensor_msgs/PointCloud2", "foxglove_msgs/SceneUpdate", "tf2_msgs/TFMessage"
CHUNK_BYTES = 1
"""Chunk size that gives each message its own chunk: rerun's importer overlaps clouds of one chunk in time."""
TRACK_HEIGHT_M = 1.5
"""Height of track boxes; tracks have no height."""
TRUTH: Color = (1.0, 1.0, 1.0, 0.3)
COLORS: dict[str, Color] = {
    "tentative": (0.6, 0.6, 0.6, 0.3),
    "confirmed": (0.2, 0.8, 0.4, 0.5),
    "coasting": (0.3, 0.5, 1.0, 0.4),
}
"""Colour of tracks by status; dead tracks are not exported."""


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
    tracks = dict(list(run.result.tables["tracks"].groupby("frame")))
    try:
        with (
            atomic_file.create(path) as temporary,
            temporary.open("wb") as stream,
            Writer(stream, chunk_size=CHUNK_BYTES) as writer,
        ):
            types = (CLOUD, BOXES, TRANSFORM)
            schemas = {name: writer.register_msgdef(full_name(name), definition(name)) for name in types}
            for frame, scan, truth in scans:
                time_ns = nanoseconds(frame.time)
                for topic, name, message in _messages(time_ns, frame, scan, truth, tracks.get(frame.index)):
                    writer.write_message(topic, schemas[name], message, log_time=time_ns, sequence=frame.index)
    except OSError as error:
        raise OutputError(f"{path}: cannot write there ({error.strerror}); choose another file") from error
    return len(scans)


def _messages(
    time_ns: int, frame: WorldFrame, scan: Scan, truth: ScanTruth, tracks: pd.DataFrame | None
) -> list[tuple[str, str, dict[str, Any]]]:
    """Return topic, type and content of all messages of one frame."""
    return [
        ("/tf", TRANSFORM, transform(time_ns, scan.ego_pose_odom)),
        ("/lidar/points", CLOUD, cloud(time_ns, _scan_columns(scan))),
        ("/truth/points", CLOUD, cloud(time_ns, _truth_columns(scan, truth))),
        ("/truth/boxes", BOXES, scene(time_ns, _actors(frame, truth))),
        ("/tracks", BOXES, scene(time_ns, [] if tracks is None else _tracks(frame, tracks))),
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


def _actors(frame: WorldFrame, truth: ScanTruth) -> list[Box]:
    actors, fraction = frame.actors, truth.visible_fraction
    pose_ego = into_frame(actors.pose_world, frame.ego.pose_world)
    return [
        Box(
            id=f"actor {actors.id[a]}",
            pose_ego=pose_ego[a],
            size=actors.size[a],
            color=TRUTH,
            label=str(actors.name[a]),
            metadata={
                "name": actors.name[a],
                "kind": Kind(actors.kind[a]).name.lower(),
                "visible_fraction": f"{fraction[a]:.3f}",
            },
        )
        for a in range(len(actors))
    ]


def _tracks(frame: WorldFrame, tracks: pd.DataFrame) -> list[Box]:
    """Return boxes in the true ego frame: the tables hold track poses without the odometry drift."""
    shown = tracks[tracks["status"].isin(list(COLORS))]
    pose_world = shown[["x_world_m", "y_world_m", "yaw_world_rad"]].to_numpy(np.float64)
    pose_ego = into_frame(pose_world, frame.ego.pose_world)
    return [
        Box(
            id=f"track {row.track_id}",
            pose_ego=pose_ego[t],
            size=np.array([row.length_m, row.width_m, TRACK_HEIGHT_M]),
            color=COLORS[row.status],
            label=f"{row.track_id}",
            metadata={"status": row.status, "verdict": row.verdict, "actor_id": row.actor_id},
        )
        for t, row in enumerate(shown.itertuples())
    ]
