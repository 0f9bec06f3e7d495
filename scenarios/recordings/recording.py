"""Recorded scans and their truth read from disk."""

import json
import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa

from luxloop.arrays import Floats, Ints
from luxloop.scenarios.dataset.dataset_columns import Values
from luxloop.scenarios.dataset.dataset_rows import ACTOR, POINT, fields_of
from luxloop.scenarios.errors import OutputError
from luxloop.scenarios.files import atomic_folder
from luxloop.scenarios.files.input_file import read_parquet
from luxloop.scenarios.grading.plane_geometry import turned
from luxloop.scenarios.offline.recorded_scans import FrameRows, readable, require_distinct, require_numbers
from luxloop.scenarios.recordings.import_options import EGO_SIZE_M
from luxloop.scenarios.recordings.recording_writer import FILES, LABELS, SUMMARY, VERSION
from luxloop.sensor_model.truth import NO_ACTOR, Cause, Part, ScanTruth, View
from luxloop.sim.world import Actors, Ego, WorldFrame
from luxloop.tracker.scan import Scan

REMEDY = "import the recording again"
LARGEST_M = 1e3
"""Absolute value of the coordinates of a mount."""


def require_summary(summary: Any) -> None:
    """Check the content of `summary.json`.

    Raises
    ------
    ValueError, TypeError, LookupError
        A key is missing, or has a value of a wrong type, or a number is not finite.
    """
    _require_finite(summary)
    if not (isinstance(summary["files"], list) and all(isinstance(name, str) for name in summary["files"])):
        raise ValueError("summary.json: files should be a list of names")
    if not isinstance(summary["duration_s"], int | float) or not isinstance(summary["frames"], int):
        raise ValueError("summary.json: duration_s and frames should be numbers")
    for mount in summary["mounts"]:
        origin = np.array(mount["origin_ego_m"], dtype=np.float64)
        if origin.shape != (3,) or not np.all(np.abs(origin) <= LARGEST_M):
            raise ValueError("summary.json: origin_ego_m of a mount should be three numbers")


def _require_finite(value: Any) -> None:
    if isinstance(value, dict | list):
        for child in value.values() if isinstance(value, dict) else value:
            _require_finite(child)
    elif isinstance(value, int | float) and not (abs(value) < 1e300 and math.isfinite(value)):
        raise ValueError("summary.json: a number is not finite")


LABELLED = {
    field: ACTOR[field]
    for field in (
        "id",
        "name",
        "kind",
        "pose_world",
        "velocity_world",
        "acceleration_world",
        "yaw_rate",
        "size",
        "mode",
    )
}
"""Columns of the fields of actors that labels hold."""
MARGIN_M = 0.3
"""[m] A point this far outside a box is on its vehicle: range noise, mirrors, and the error of the recorded pose."""


def actors_of(labels: Values) -> Actors:
    """Return the labels of one scan as actors. What a recording does not hold is 0."""
    count = len(labels["frame"])
    zero, zeros = np.zeros(count), np.zeros((count, 2))
    return Actors(
        articulation=zero,
        changes_lane=np.zeros(count, dtype=np.bool_),
        deviation=zeros,
        ground_z=zero,
        attitude=zeros,
        reflectivity=zero,
        **fields_of(labels, LABELLED),
    )


def world_frame(index: int, scan: Scan, velocity: Floats, yaw_rate: float, size: Floats, actors: Actors) -> WorldFrame:
    """Return the frame of a scan; the world is the odometry frame.

    Parameters
    ----------
    velocity, yaw_rate
        (2,) of the ego in the odometry frame [m/s], and [rad/s].
    size
        (3,) of the ego [m].
    """
    ego = Ego(
        pose_world=scan.ego_pose_odom,
        velocity_world=velocity,
        acceleration_world=np.zeros(2),
        yaw_rate=yaw_rate,
        size=size,
        changes_lane=False,
        deviation=np.zeros(2),
        ground_z=0.0,
        attitude=np.zeros(2),
    )
    return WorldFrame(index, scan.time, ego, actors)


def scan_truth(scan: Scan, frame: WorldFrame) -> ScanTruth:
    """Assign the points of a scan to the vehicles whose boxes they are in; all points count as clean.

    Occluders are not known: a vehicle with points is visible, one without is hidden.
    """
    actor_row = _actor_rows(scan, frame)
    on = actor_row >= 0
    count = len(frame.actors)
    hits = np.bincount(actor_row[on], minlength=count).astype(np.int32)[:, None]
    points = scan.points_ego.astype(np.float64)
    return ScanTruth(
        actor_id=np.append(frame.actors.id, NO_ACTOR)[actor_row],
        part=np.where(on, Part.BODY, Part.NONE).astype(np.uint8),
        cause=np.full(len(scan), Cause.CLEAN, dtype=np.uint8),
        true_range=np.sqrt((points**2).sum(axis=1)).astype(np.float32),
        lost_unit=np.empty(0, np.uint8),
        lost_beam=np.empty(0, np.int32),
        lost_cause=np.empty(0, np.uint8),
        unit_hits=hits,
        unit_hits_alone=hits,
        faces=np.zeros(count, dtype=np.uint8),
        view=np.full(count, View.NONE, dtype=np.uint8),
    )


def _actor_rows(scan: Scan, frame: WorldFrame) -> Ints:
    """(N,) row of the vehicle whose box each point is in at the point's own time, -1 for none."""
    ego, actors, dt = frame.ego, frame.actors, scan.time_offset.astype(np.float64)
    yaw = ego.pose_world[2] + ego.yaw_rate * dt
    points = turned(scan.points_ego[:, :2].astype(np.float64), yaw)
    points += ego.pose_world[:2] + dt[:, None] * ego.velocity_world
    row = np.full(len(scan), -1, dtype=np.int64)
    for k in range(len(actors)):
        heading = actors.pose_world[k, 2] + actors.yaw_rate[k] * dt
        body = turned(points - actors.pose_world[k, :2] - dt[:, None] * actors.velocity_world[k], -heading)
        row[(np.abs(body) <= 0.5 * actors.size[k, :2] + MARGIN_M).all(axis=1)] = k
    return row


NUMBERS = ("time_s", "odom_x_m", "odom_y_m", "odom_yaw_rad")
"""Columns of `scans.parquet` that are read."""


class Recording:
    """Recorded scans of `luxloop import`; can be read repeatedly.

    Parameters
    ----------
    folder
        Folder of the recording.

    Raises
    ------
    OutputError
        The folder holds no recording, or a damaged one.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        if not is_recording(folder):
            raise OutputError(f"{folder}: holds no recording; give a folder that luxloop import wrote")
        with readable(folder, REMEDY):
            self.summary: dict[str, Any] = json.loads((folder / SUMMARY).read_text(encoding="utf-8"))
            require_summary(self.summary)
            origins = [mount["origin_ego_m"] for mount in self.summary["mounts"]]
            self._units: Floats = np.reshape(np.array(origins, dtype=np.float64), (-1, 3))[:, :2]
            scans = read_parquet(folder / "scans.parquet")
            columns = {name: scans[name].cast(pa.float64()).to_numpy() for name in NUMBERS}
            require_numbers(columns)
            self.time_s: Floats = columns.pop("time_s")
            """(F,) times of the scans [s]."""
            self._pose: Floats = np.column_stack(list(columns.values()))
            if np.any(np.diff(self.time_s) <= 0.0):
                raise ValueError("the times in scans.parquet should ascend")
            whole = len(self) == self.summary["frames"] and scans["frame"].to_pylist() == list(range(len(self)))
            if not (whole and len(self)):
                raise ValueError(f"scans.parquet has {len(self)} of {self.summary['frames']} scans")

    def __len__(self) -> int:
        return len(self.time_s)

    @property
    def name(self) -> str:
        """Name of the folder."""
        return self.folder.resolve().name

    @property
    def has_truth(self) -> bool:
        """True if vehicles have recorded poses."""
        return (self.folder / "labels.parquet").is_file()

    def refuse_to_write_to(self, out: Path) -> None:
        """Raise an OutputError if `out` is the folder of the recording, inside it, or contains it."""
        if atomic_folder.overlap(self.folder, out):
            raise OutputError(
                f"{out}: is the folder of the recording, inside it, or contains it; choose another with --out"
            )

    def scans(self) -> Iterator[Scan]:
        """Yield the scans in order."""
        for scan, _ in self._rows():
            yield scan

    def frames(self) -> Iterator[tuple[WorldFrame, Scan, ScanTruth]]:
        """Yield each scan with its ground truth; without recorded poses there are no actors."""
        velocity, yaw_rate = self._ego_motion()
        for index, (scan, labels) in enumerate(self._rows()):
            actors = actors_of(labels)
            frame = world_frame(index, scan, velocity[index], yaw_rate[index], np.array(EGO_SIZE_M), actors)
            yield frame, scan, scan_truth(scan, frame)

    def _rows(self) -> Iterator[tuple[Scan, Values]]:
        files = {name: columns for name, columns in FILES.items() if name != "labels" or self.has_truth}
        empty: Values = {column.name: column.values(pa.array([], column.type)) for column in LABELS}
        with readable(self.folder, REMEDY):
            tables = {name: FrameRows(self.folder / f"{name}.parquet", columns) for name, columns in files.items()}
        for frame in range(len(self)):
            with readable(self.folder, REMEDY):
                rows = {name: table.of(frame) for name, table in tables.items()}
                for values in rows.values():
                    require_numbers(values)
                labels = rows.get("labels", empty)
                require_distinct(labels)
                order = np.argsort(labels["actor_id"], kind="stable")  # other programs may write them in any order
                labels = {name: values[order] for name, values in labels.items()}
            yield (
                Scan(
                    time=float(self.time_s[frame]),
                    ego_pose_odom=self._pose[frame],
                    unit_positions_ego=self._units,
                    **fields_of(rows["points"], POINT),
                ),
                labels,
            )

    def _ego_motion(self) -> tuple[Floats, Floats]:
        """Return velocities (F, 2) and yaw rates (F,) of the ego in the odometry frame, by central differences."""
        if len(self) == 1:
            return np.zeros((1, 2)), np.zeros(1)
        pose = np.column_stack([self._pose[:, :2], np.unwrap(self._pose[:, 2])])
        rate = np.gradient(pose, self.time_s, axis=0)
        return rate[:, :2], rate[:, 2]


def is_recording(folder: Path) -> bool:
    """Return True for a folder that `luxloop import` wrote completely, with this version's layout."""
    if atomic_folder.is_unfinished(folder):
        return False
    try:
        document = json.loads((folder / SUMMARY).read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return False
    return isinstance(document, dict) and document.get("recording") == VERSION
