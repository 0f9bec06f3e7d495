"""Recorded scans read from disk."""

import json
import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from luxloop.scenarios.arrays import Floats
from luxloop.scenarios.dataset.dataset_columns import Values
from luxloop.scenarios.errors import OutputError
from luxloop.scenarios.files import atomic_folder
from luxloop.scenarios.offline.recorded_scans import FrameRows, require_distinct, require_numbers
from luxloop.scenarios.recordings.import_options import EGO_SIZE_M
from luxloop.scenarios.recordings.recorded_truth import actors_of, scan_truth, world_frame
from luxloop.scenarios.recordings.recording_checks import require_summary
from luxloop.scenarios.recordings.recording_columns import FILES, LABELS
from luxloop.scenarios.recordings.recording_writer import SUMMARY, VERSION
from luxloop.sensor_model.truth import ScanTruth
from luxloop.sim.world import WorldFrame
from luxloop.tracker.scan import Scan

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
        with _readable(folder):
            self.summary: dict[str, Any] = json.loads((folder / SUMMARY).read_text(encoding="utf-8"))
            require_summary(self.summary)
            origins = [mount["origin_ego_m"] for mount in self.summary["mounts"]]
            self._units: Floats = np.reshape(np.array(origins, dtype=np.float64), (-1, 3))[:, :2]
            scans = pq.read_table(folder / "scans.parquet")
            columns = {name: scans[name].cast(pa.float64()).to_numpy() for name in NUMBERS}
            require_numbers(columns)
            self.time_s: Floats = columns.pop("time_s")
            """(F,) times of the scans [s]."""
            self._pose: Floats = np.column_stack(list(columns.values()))
            if np.any(np.diff(self.time_s) <= 0.0):
                raise ValueError("the times in scans.parquet should ascend")
            if scans["frame"].to_pylist() != list(range(self.summary["frames"])) or not len(self):
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
        here, there = (Path(os.path.realpath(folder)) for folder in (self.folder, out))
        if there.is_relative_to(here) or here.is_relative_to(there):
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
        with _readable(self.folder):
            tables = {name: FrameRows(self.folder / f"{name}.parquet", columns) for name, columns in files.items()}
        for frame in range(len(self)):
            with _readable(self.folder):
                rows = {name: table.of(frame) for name, table in tables.items()}
                for values in rows.values():
                    require_numbers(values)
                require_distinct(rows.get("labels", empty))
            points = rows["points"]
            yield (
                Scan(
                    time=float(self.time_s[frame]),
                    ego_pose_odom=self._pose[frame],
                    points_ego=np.stack([points[name] for name in ("x_ego_m", "y_ego_m", "z_ego_m")], axis=1),
                    time_offset=points["time_offset_s"],
                    unit=points["unit"],
                    layer=points["layer"],
                    echo=points["echo"],
                    echo_pulse_width=points["echo_pulse_width_m"],
                    flags=points["flags"],
                    unit_positions_ego=self._units,
                ),
                rows.get("labels", empty),
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


@contextmanager
def _readable(folder: Path) -> Iterator[None]:
    """Raise errors of missing or damaged files as an OutputError of one line."""
    try:
        yield
    except (OSError, pa.ArrowException, LookupError, ValueError, TypeError) as error:
        reason = " ".join(str(error).split())
        raise OutputError(f"{folder}: cannot be read ({reason}); import the recording again") from error
