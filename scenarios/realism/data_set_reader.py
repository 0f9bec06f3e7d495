"""Labelled vehicles of data sets that `luxloop run --dataset` wrote."""

import json
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pandas as pd

from scenarios.arrays import Floats
from scenarios.errors import InputError
from scenarios.grading.plane_geometry import turned
from scenarios.realism.labelled_vehicle import POINTS_MIN, LabelledVehicle, in_box

SCANS = ["frame", "ego_yaw_world_rad", "ego_vx_world_mps", "ego_vy_world_mps", "ego_yaw_rate_radps"]
POINTS = ["frame", "x_ego_m", "y_ego_m", "z_ego_m", "time_offset_s", "unit", "layer"]
LABELS = [
    "frame", "actor_id", "kind", "graded", "x_ego_m", "y_ego_m", "heading_ego_rad", "length_m", "width_m", "height_m",
    "vx_world_mps", "vy_world_mps", "yaw_rate_radps",
]  # fmt: skip
"""Columns that are read of each file."""

LAYERS_MAX = 256
"""A layer is a byte, so that unit and layer make one number."""


def read(folder: Path, number: int, label_sigma_deg: float, seed: int) -> list[LabelledVehicle]:
    """Return the graded vehicles of every frame of a data set with at least `POINTS_MIN` points.

    Parameters
    ----------
    folder
        Data set; its `number` keys the label errors, so that another data set changes none of them.
    number
        Number of the data set, from 0.
    label_sigma_deg
        Standard deviation of the error that is added to the heading of each label [deg].
    seed
        Seed of these errors.

    Raises
    ------
    InputError
        The folder holds no data set.
    """
    scans, points, labels = (_table(folder, name, columns) for name, columns in _FILES.items())
    error_deg = np.random.default_rng([seed, number]).normal(0.0, label_sigma_deg, len(labels))
    labels = labels.assign(label_error_rad=np.radians(error_deg))
    lidars = _lidars(folder, int(points["unit"].max()) + 1 if len(points) else 0)
    by_frame = dict(iter(points.groupby("frame", sort=False)))
    ego = scans.set_index("frame")
    found: list[LabelledVehicle] = []
    for frame, rows in labels[labels["graded"]].groupby("frame"):
        if frame in by_frame:
            found += _of_frame(by_frame[frame], rows, ego.loc[frame], lidars, number)
    return found


_FILES = {"scans": SCANS, "points": POINTS, "labels": LABELS}


def _table(folder: Path, name: str, columns: list[str]) -> pd.DataFrame:
    path = folder / f"{name}.parquet"
    remedy = "name a folder that luxloop run SCENARIO --dataset wrote"
    try:
        return pd.read_parquet(path, columns=columns)
    except FileNotFoundError as error:
        raise InputError(f"{folder}: has no {name}.parquet; {remedy}") from error
    except (OSError, ValueError) as error:  # pyarrow's errors are ValueErrors
        reason = str(error).splitlines()[0] if str(error) else type(error).__name__
        raise InputError(f"{path}: cannot be read ({reason}); {remedy}") from error


def _lidars(folder: Path, units: int) -> Floats:
    """Return the positions (units, 2) of the LIDARs in the ego frame [m]: the ego's centre if the summary has none."""
    path = folder / "summary.json"
    try:
        mounts = json.loads(path.read_text(encoding="utf-8")).get("lidars", [])
        positions = np.array([(mount["x_ego_m"], mount["y_ego_m"]) for mount in mounts], dtype=np.float64)
    except (OSError, ValueError, KeyError, TypeError, AttributeError) as error:
        raise InputError(f"{path}: cannot be read; write the data set again") from error
    return positions if len(positions) >= units else np.zeros((units, 2))


def _of_frame(
    points: pd.DataFrame, labels: pd.DataFrame, ego: pd.Series, lidars: Floats, number: int
) -> Iterator[LabelledVehicle]:
    """Yield the vehicles of one frame with enough points."""
    place = points[["x_ego_m", "y_ego_m", "z_ego_m"]].to_numpy(np.float64, copy=True)
    after = points["time_offset_s"].to_numpy(np.float64)
    unit = points["unit"].to_numpy(np.int64)
    line = LAYERS_MAX * unit + points["layer"].to_numpy(np.int64)
    yaw = ego["ego_yaw_world_rad"]
    drive = turned(ego[["ego_vx_world_mps", "ego_vy_world_mps"]].to_numpy(np.float64), -yaw)
    place[:, :2] = turned(place[:, :2], ego["ego_yaw_rate_radps"] * after) + drive * after[:, None]
    for label in labels.itertuples():
        box = np.array([label.x_ego_m, label.y_ego_m, label.heading_ego_rad, label.length_m, label.width_m])
        velocity = turned(np.array([label.vx_world_mps, label.vy_world_mps]), -yaw)
        still = place.copy()
        moved = place[:, :2] - box[:2] - velocity * after[:, None]
        still[:, :2] = box[:2] + turned(moved, -label.yaw_rate_radps * after)
        box[2] += label.label_error_rad
        own = np.flatnonzero(in_box(still, box, label.height_m))
        if len(own) >= POINTS_MIN:
            units, counts = np.unique(unit[own], return_counts=True)
            by_count = units[np.argsort(-counts, kind="stable")]
            vehicle = LabelledVehicle(
                number, label.actor_id, label.frame, str(label.kind), still[own], line[own], box, lidars[by_count]
            )
            if vehicle.seen_from_outside:
                yield vehicle
