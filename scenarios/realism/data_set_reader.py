"""Labelled vehicles of data sets that `luxloop run --dataset` wrote."""

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pandas as pd

from luxloop.scenarios.arrays import Floats
from luxloop.scenarios.errors import InputError
from luxloop.scenarios.grading.plane_geometry import turned
from luxloop.scenarios.realism.labelled_vehicle import POINTS_MIN, LabelledVehicle, in_box

FILES = {
    "scans": ("frame", "ego_yaw_world_rad", "ego_vx_world_mps", "ego_vy_world_mps", "ego_yaw_rate_radps"),
    "points": ("frame", "x_ego_m", "y_ego_m", "z_ego_m", "time_offset_s", "unit", "layer"),
    "labels": (
        "frame", "actor_id", "kind", "graded", "x_ego_m", "y_ego_m", "heading_ego_rad", "length_m", "width_m",
        "height_m", "vx_world_mps", "vy_world_mps", "yaw_rate_radps",
    ),
}  # fmt: skip
"""Columns that are read of each file."""
LAYERS_MAX = 256
"""A layer is a byte, so that unit and layer make one number."""

Rows = dict[str, npt.NDArray[Any]]


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
    scans, points, labels = (_table(folder, name) for name in FILES)
    lidars = _lidars(folder, int(points["unit"].max(initial=0)) + 1)
    error_deg = np.random.default_rng([seed, number]).normal(0.0, label_sigma_deg, len(labels["frame"]))
    labels["label_error_rad"] = np.radians(error_deg)
    labels = {name: values[labels["graded"]] for name, values in labels.items()}
    per_frame = zip(*(_by_frame(rows, scans["frame"]) for rows in (scans, points, labels)), strict=True)
    return [vehicle for scan, own, seen in per_frame for vehicle in _of_frame(scan, own, seen, lidars, number)]


def _table(folder: Path, name: str) -> Rows:
    """Return the columns of a file, sorted by frame."""
    path = folder / f"{name}.parquet"
    remedy = "name a folder that luxloop run SCENARIO --dataset wrote"
    try:
        table = pd.read_parquet(path, columns=list(FILES[name])).sort_values("frame", kind="stable")
    except FileNotFoundError as error:
        raise InputError(f"{folder}: has no {name}.parquet; {remedy}") from error
    except (OSError, ValueError) as error:  # pyarrow's errors are ValueErrors
        reason = str(error).splitlines()[0] if str(error) else type(error).__name__
        raise InputError(f"{path}: cannot be read ({reason}); {remedy}") from error
    return {column: table[column].to_numpy() for column in table}


def _lidars(folder: Path, units: int) -> Floats:
    """Return the positions (units, 2) of the LIDARs in the ego frame [m]: the ego's centre if the summary has none."""
    path = folder / "summary.json"
    try:
        mounts = json.loads(path.read_text(encoding="utf-8")).get("lidars", [])
        positions = np.array([(mount["x_ego_m"], mount["y_ego_m"]) for mount in mounts], dtype=np.float64)
    except (OSError, ValueError, KeyError, TypeError, AttributeError) as error:
        raise InputError(f"{path}: cannot be read; write the data set again") from error
    return positions if len(positions) >= units else np.zeros((units, 2))


def _by_frame(rows: Rows, frames: npt.NDArray[Any]) -> Iterator[Rows]:
    """Yield the rows of each frame."""
    for start, end in zip(*(np.searchsorted(rows["frame"], frames, side) for side in ("left", "right")), strict=True):
        yield {name: values[start:end] for name, values in rows.items()}


def _of_frame(scan: Rows, points: Rows, labels: Rows, lidars: Floats, number: int) -> Iterator[LabelledVehicle]:
    """Yield the vehicles of one frame with enough points."""
    after = points["time_offset_s"].astype(np.float64)
    unit = points["unit"].astype(np.int64)
    line = LAYERS_MAX * unit + points["layer"]
    place = _without_ego_motion(scan, points, after)
    boxes = _stack(labels, "x_ego_m", "y_ego_m", "heading_ego_rad", "length_m", "width_m")
    velocity = turned(_stack(labels, "vx_world_mps", "vy_world_mps"), -scan["ego_yaw_world_rad"])
    for n, box in enumerate(boxes):
        still = place.copy()
        moved = place[:, :2] - box[:2] - velocity[n] * after[:, None]
        still[:, :2] = box[:2] + turned(moved, -labels["yaw_rate_radps"][n] * after)
        box[2] += labels["label_error_rad"][n]
        own = np.flatnonzero(in_box(still, box, labels["height_m"][n]))
        if len(own) < POINTS_MIN:
            continue
        units, counts = np.unique(unit[own], return_counts=True)
        vehicle = LabelledVehicle(
            data_set=number,
            actor_id=int(labels["actor_id"][n]),
            frame=int(labels["frame"][n]),
            kind=str(labels["kind"][n]),
            points_ego=still[own],
            line=line[own],
            box=box,
            lidars=lidars[units[np.argsort(-counts, kind="stable")]],
        )
        if vehicle.seen_from_outside:
            yield vehicle


def _without_ego_motion(scan: Rows, points: Rows, after: Floats) -> Floats:
    """Return the points (N, 3) in the ego frame at the time of the frame, for points `after` (N,) that time [s]."""
    place = _stack(points, "x_ego_m", "y_ego_m", "z_ego_m")
    drive = turned(_stack(scan, "ego_vx_world_mps", "ego_vy_world_mps"), -scan["ego_yaw_world_rad"])
    place[:, :2] = turned(place[:, :2], scan["ego_yaw_rate_radps"] * after) + drive * after[:, None]
    return place


def _stack(rows: Rows, *columns: str) -> Floats:
    return np.column_stack([rows[name].astype(np.float64) for name in columns])
