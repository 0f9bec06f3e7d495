"""Labelled vehicles: the points, the labelled box and the LIDARs of a vehicle in one frame, read from a data set."""

import json
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pandas as pd

from luxloop.arrays import Bools, Floats, Ints
from luxloop.scenarios.errors import InputError
from luxloop.scenarios.grading.plane_geometry import turned

GROWN_M = 0.15
"""[m] Margin around the labelled box: points this far outside belong to the vehicle."""
GROUND_M = 0.15
"""[m] Points below this height may be ground."""
ABOVE_M = 0.20
"""[m] Margin above the labelled box."""
POINTS_MIN = 10
"""Least number of points of a vehicle with statistics."""


@dataclass(frozen=True, slots=True, eq=False)
class LabelledVehicle:
    """Points of a vehicle in one frame, with its label."""

    data_set: int
    """Number of its data set."""
    actor_id: int
    """Id in that data set."""
    frame: int
    """Frame in that data set."""
    kind: str
    """Kind of vehicle."""
    points_ego: Floats
    """(N, 3) ego frame, z from the ground [m]."""
    line: Ints
    """(N,) scan line, unit and layer, of each point."""
    box: Floats
    """(5,) label: x, y [m] and yaw [rad] in the ego frame, length and width [m]."""
    lidars: Floats
    """(U, 2) positions of the LIDARs with points on the vehicle, ego frame [m]; the first has most of them."""

    @property
    def points_box(self) -> Floats:
        """(N, 2) points in the frame of the box, x forward from its centre [m]."""
        return turned(self.points_ego[:, :2] - self.box[:2], -self.box[2])

    @property
    def lidars_box(self) -> Floats:
        """(U, 2) LIDARs in the frame of the box [m]."""
        return turned(self.lidars - self.box[:2], -self.box[2])

    @property
    def range_m(self) -> float:
        """Horizontal distance from the first LIDAR to the box centre [m]."""
        return float(np.hypot(*self.lidars_box[0]))

    @property
    def aspect_deg(self) -> float:
        """Angle between the long axis and the line of sight [deg], from 0, end on, to 90, abreast."""
        forward, left = np.abs(self.lidars_box[0])
        return float(np.degrees(np.arctan2(left, forward)))

    @property
    def front_seen(self) -> bool:
        """True if the first LIDAR is ahead of the box centre."""
        return bool(self.lidars_box[0, 0] > 0.0)

    @property
    def seen_from_outside(self) -> bool:
        """True if a LIDAR is in front of the plane of a face."""
        return bool((np.abs(self.lidars_box) > 0.5 * self.box[3:]).any())


def in_box(points: Floats, box: Floats, height_m: float) -> Bools:
    """Mask the points of a vehicle: inside its box grown by 15 cm, clear of the ground and of objects above.

    Parameters
    ----------
    points
        (N, 3) in the frame of the box's x, y and yaw, z from the ground [m].
    box
        (5,) x, y [m], yaw [rad], length and width [m].
    height_m
        Height of the vehicle [m].
    """
    local = np.abs(turned(points[:, :2] - box[:2], -box[2]))
    inside = (local <= 0.5 * box[3:] + GROWN_M).all(axis=1)
    mask: Bools = inside & (points[:, 2] >= GROUND_M) & (points[:, 2] <= height_m + ABOVE_M)
    return mask


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
    labels["heading_ego_rad"] = labels["heading_ego_rad"] + np.radians(error_deg)
    labels = {name: values[labels["graded"]] for name, values in labels.items()}
    return vehicles_in(scans, points, labels, lidars, number)


def vehicles_in(scans: Rows, points: Rows, labels: Rows, lidars: Floats, number: int) -> list[LabelledVehicle]:
    """Return the vehicles of every frame with at least `POINTS_MIN` points, from tables sorted by frame.

    Parameters
    ----------
    scans, points, labels
        Columns of `FILES`; all labels are used.
    lidars
        (U, 2) positions of the LIDARs, ego frame [m].
    number
        Number of the data set.
    """
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
