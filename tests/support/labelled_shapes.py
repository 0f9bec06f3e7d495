"""Labelled vehicles and data sets with points set by hand."""

import json
from pathlib import Path

import numpy as np
import pandas as pd

from luxloop.scenarios.realism.labelled_vehicle import LabelledVehicle

SIZE = (4.4, 1.8)
BEHIND, ABREAST = (-20.0, 0.0), (0.0, 20.0)
"""Positions of a LIDAR that sees the rear only, and the left flank only [m]."""


def vehicle(
    points_box, line=0, height=0.5, lidars=(BEHIND,), size=SIZE, pose=(0.0, 0.0, 0.0), actor_id=1
) -> LabelledVehicle:
    """Return a vehicle whose points (N, 2) and LIDARs (U, 2) are given in the frame of its box at `pose`."""
    points = np.asarray(points_box, np.float64)
    x, y, yaw = pose
    turn = np.array([(np.cos(yaw), np.sin(yaw)), (-np.sin(yaw), np.cos(yaw))])
    heights = np.broadcast_to(np.asarray(height, np.float64), len(points))
    return LabelledVehicle(
        data_set=0,
        actor_id=actor_id,
        frame=0,
        kind="car",
        points_ego=np.column_stack([points @ turn + (x, y), heights]),
        line=np.broadcast_to(np.asarray(line, np.int64), len(points)),
        box=np.array([x, y, yaw, *size]),
        lidars=np.asarray(lidars) @ turn + (x, y),
    )


def rear(depth, along, size=SIZE) -> np.ndarray:
    """Return points (N, 2) at depths behind the rear face, at coordinates along it [m]."""
    depth, along = np.broadcast_arrays(np.asarray(depth, np.float64), np.asarray(along, np.float64))
    return np.column_stack([depth - 0.5 * size[0], along])


def left(depth, along, size=SIZE) -> np.ndarray:
    """Return points (N, 2) at depths behind the left flank, at coordinates along it [m]."""
    depth, along = np.broadcast_arrays(np.asarray(depth, np.float64), np.asarray(along, np.float64))
    return np.column_stack([along, 0.5 * size[1] - depth])


def l_shape(gap=0.1, size=SIZE) -> np.ndarray:
    """Return points (N, 2) on the rear and the left flank, `gap` apart, in the order of a scan to the right."""
    flank = left(0.0, np.arange(0.5 * size[0], -0.5 * size[0], -gap), size)
    return np.concatenate([flank, rear(0.0, np.arange(0.5 * size[1], -0.5 * size[1], -gap), size)])


def write_data_set(folder: Path, points: pd.DataFrame, labels: list[dict], ego: dict | None = None, **summary) -> Path:
    """Write the files that the comparison reads; columns that are not given are zero.

    Parameters
    ----------
    folder
        New folder.
    points
        Rows of points.parquet: x_ego_m, y_ego_m and z_ego_m.
    labels
        Rows of labels.parquet.
    ego
        Columns of scans.parquet for every frame.
    """
    folder.mkdir(parents=True)
    still = ["x_ego_m", "y_ego_m", "heading_ego_rad", "vx_world_mps", "vy_world_mps", "yaw_rate_radps"]
    size = dict(zip(("length_m", "width_m", "height_m"), (*SIZE, 1.5), strict=True))
    label = {"frame": 0, "actor_id": 1, "kind": "car", "graded": True, **dict.fromkeys(still, 0.0), **size}
    standing = {"ego_yaw_world_rad": 0.0, "ego_vx_world_mps": 0.0, "ego_vy_world_mps": 0.0, "ego_yaw_rate_radps": 0.0}
    rows = pd.DataFrame([{**label, **row} for row in labels])
    frames = np.unique(rows["frame"])
    defaults = {"frame": 0, "time_offset_s": 0.0, "unit": 0, "layer": 0}
    missing = {name: value for name, value in defaults.items() if name not in points}
    points.assign(**missing).to_parquet(folder / "points.parquet")
    rows.to_parquet(folder / "labels.parquet")
    pd.DataFrame({"frame": frames, **standing, **(ego or {})}).to_parquet(folder / "scans.parquet")
    (folder / "summary.json").write_text(json.dumps(summary))
    return folder
