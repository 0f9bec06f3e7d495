"""Labelled vehicles of recordings in the layout of `luxloop import`, and of several cuts of one recording."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pandas as pd

from luxloop.scenarios.arrays import Floats
from luxloop.scenarios.errors import InputError
from luxloop.scenarios.grading.plane_geometry import turned
from luxloop.scenarios.realism.labelled_vehicle import LabelledVehicle, Rows, vehicles_in

SCANS = ("frame", "time_s", "odom_x_m", "odom_y_m", "odom_yaw_rad")
POINTS = ("frame", "x_ego_m", "y_ego_m", "z_ego_m", "time_offset_s", "layer")
LABELS = (
    "frame", "actor_id", "kind", "x_world_m", "y_world_m", "heading_world_rad", "length_m", "width_m", "height_m",
    "vx_world_mps", "vy_world_mps", "yaw_rate_radps",
)  # fmt: skip
"""Columns that are read of each file; `unit` of the points is optional."""


def is_labelled_recording(folder: Path) -> bool:
    """Return True for a folder of scans with labels in the odometry frame."""
    path = folder / "labels.parquet"
    return bool(cuts(folder)) and path.is_file() and "x_ego_m" not in _read(path, ())


def cuts(folder: Path) -> list[Path]:
    """Return the files of points: points.parquet, or NAME_points.parquet of each cut."""
    return sorted(folder.glob("*points.parquet"))


def read(folder: Path, points: Path, number: int) -> list[LabelledVehicle]:
    """Return the vehicles of every frame of one cut; its single LIDAR is at the origin of the ego frame.

    Raises
    ------
    InputError
        A file cannot be read.
    """
    scans, labels = _read(folder / "scans.parquet", SCANS), _read(folder / "labels.parquet", LABELS)
    cloud = _read(points, POINTS)
    cloud.setdefault("unit", np.zeros(len(cloud["frame"]), np.uint8))
    pose = _add_ego_motion(scans)[np.searchsorted(scans["frame"], labels["frame"])]
    world = np.column_stack([labels["x_world_m"], labels["y_world_m"]])
    labels["x_ego_m"], labels["y_ego_m"] = turned(world - pose[:, :2], -pose[:, 2]).T
    labels["heading_ego_rad"] = labels["heading_world_rad"] - pose[:, 2]
    return vehicles_in(scans, cloud, labels, np.zeros((int(cloud["unit"].max(initial=0)) + 1, 2)), number)


def _add_ego_motion(scans: Rows) -> Floats:
    """Add the columns of the ego's motion, by central differences; return its poses (F, 3)."""
    pose = np.column_stack([scans["odom_x_m"], scans["odom_y_m"], np.unwrap(scans["odom_yaw_rad"])])
    rate = np.gradient(pose, scans["time_s"], axis=0) if len(pose) > 1 else np.zeros_like(pose)
    scans["ego_yaw_world_rad"] = pose[:, 2]
    scans["ego_vx_world_mps"], scans["ego_vy_world_mps"], scans["ego_yaw_rate_radps"] = rate.T
    return pose


def _read(path: Path, columns: Sequence[str]) -> Rows:
    """Return all columns of a file, sorted by frame; `columns` are required."""
    try:
        table = pd.read_parquet(path).sort_values("frame", kind="stable")
    except (OSError, ValueError, KeyError) as error:  # pyarrow's errors are ValueErrors
        raise InputError(f"{path}: cannot be read; give a recording in the layout of luxloop import") from error
    missing = [name for name in columns if name not in table]
    if missing:
        raise InputError(f"{path}: has no column {missing[0]}; give a recording in the layout of luxloop import")
    return {str(column): table[column].to_numpy() for column in table}
