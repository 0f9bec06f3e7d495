"""Observations of labelled vehicles: heading errors by method, kind of view, and range."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pandas as pd

from luxloop.arrays import Bools, Floats
from luxloop.scenarios.errors import InputError
from luxloop.scenarios.grading.plane_geometry import turned
from luxloop.scenarios.realism import labelled_fits, labelled_vehicle
from luxloop.scenarios.realism.labelled_vehicle import LabelledVehicle, Rows, vehicles_in
from luxloop.scenarios.realism.vehicle_figures import least_depth, visible_faces

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


SIMULATED = "simulated"
"""Name of the observations of data sets."""
RANGE_BANDS_M = ((0, 15), (15, 30), (30, 50), (50, 100))
VIEWS = ("flank over 2.5 m", "end and short flank", "end on", "glass or roof only")
FLANK_MIN_M, SHORT_FLANK_MIN_M = 2.5, 0.8
"""Visible lengths of a flank [m]: a shorter one than the second is the rounded corner of an end."""
LOW_M, LOW_POINTS_MIN = 1.0, 5
"""Height of the body below the glass [m], and least number of its points."""
NEAR_FACE_M = 0.3
"""Largest depth of the points on a flank [m]."""


def of_folders(folders: Sequence[Path]) -> dict[str, pd.DataFrame]:
    """Return the observations of each cut of labelled recordings by its name, and of all data sets as `simulated`.

    Raises
    ------
    InputError
        A folder is neither, or has no vehicle with enough points.
    """
    groups: dict[str, list[LabelledVehicle]] = {}
    for number, folder in enumerate(folders):
        if is_labelled_recording(folder):
            for points in cuts(folder):
                name = f"{folder.resolve().name} {points.stem.removesuffix('points').rstrip('_')}".rstrip()
                groups.setdefault(name, []).extend(read(folder, points, number))
        else:
            groups.setdefault(SIMULATED, []).extend(labelled_vehicle.read(folder, number, 0.0, 0))
    for name, vehicles in groups.items():
        if not vehicles:
            raise InputError(f"{name}: no labelled vehicle has {labelled_vehicle.POINTS_MIN} points or more")
    return {name: observations(vehicles) for name, vehicles in groups.items()}


def observations(vehicles: Sequence[LabelledVehicle]) -> pd.DataFrame:
    """Return a row per vehicle and frame: `vehicle` (number), `view`, `range`, absolute errors [deg] and `deviation`.

    Errors are those of `labelled_fits.COMPARED`, of `best`, and of `oracle`, the least of these; `deviation` is the
    error of `best` over its stated standard deviation.
    """
    fits = labelled_fits.fit(vehicles)
    rows = pd.DataFrame({name: np.abs(error) for name, error in fits.error_deg.items()})
    key = pd.DataFrame({"set": [one.data_set for one in vehicles], "actor": [one.actor_id for one in vehicles]})
    return rows.assign(
        oracle=rows.min(axis=1),
        deviation=rows["best"] / fits.std_deg,
        vehicle=key.groupby(["set", "actor"]).ngroup(),
        view=[view(one) for one in vehicles],
        range=[_range_band(one.range_m) for one in vehicles],
    )


def view(vehicle: LabelledVehicle) -> str:
    """Return the kind of view, one of `VIEWS`, from the points below the glass on the visible flanks."""
    low = vehicle.points_ego[:, 2] < LOW_M
    if low.sum() < LOW_POINTS_MIN:
        return VIEWS[3]
    faces = visible_faces(vehicle)
    nearest = least_depth(faces)
    length = max((_length(face.along[low & _on(face.depth, nearest)]) for face in faces if not face.end), default=0.0)
    return VIEWS[0] if length > FLANK_MIN_M else VIEWS[1] if length > SHORT_FLANK_MIN_M else VIEWS[2]


def _on(depth: Floats, nearest: Floats) -> Bools:
    mask: Bools = (depth <= nearest) & (depth < NEAR_FACE_M)
    return mask


def _length(along: Floats) -> float:
    return float(np.ptp(along)) if len(along) else 0.0


def range_bands() -> list[str]:
    """Return the names of the bands of range."""
    return [f"{low} to {high} m" for low, high in RANGE_BANDS_M]


def _range_band(range_m: float) -> str:
    above = sum(range_m >= high for _, high in RANGE_BANDS_M)
    return range_bands()[min(above, len(RANGE_BANDS_M) - 1)]
