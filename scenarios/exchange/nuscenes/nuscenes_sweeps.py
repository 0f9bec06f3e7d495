"""Sweeps, ego poses and true boxes of one scene of a nuScenes folder, or of a T4 data set, which has the same tables.

All sweeps of the LIDARs are read, also those between the samples. Points are float32 x, y, z [m], intensity and ring
in the frame of the sensor, without times (nuScenes development kit, `LidarPointCloud`).
"""

from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from luxloop.scenarios.errors import InputError
from luxloop.scenarios.exchange.box_table import BoxTable
from luxloop.scenarios.exchange.nuscenes import nuscenes_reader as reader
from luxloop.scenarios.recordings.ego_mount import EgoMount
from luxloop.scenarios.recordings.formats.format_choice import readable
from luxloop.scenarios.recordings.formats.point_files import sweep_of_table
from luxloop.scenarios.recordings.sweep import DataSet, PoseList, Sweep

POINT = np.dtype([(name, "<f4") for name in ("x", "y", "z", "intensity", "ring")])
WHAT = "nuScenes"
MICROSECONDS = 1e-6

Row = dict[str, Any]


def open_recording(path: Path, scene: str | None) -> DataSet:
    """Open a scene, by name or token; the only one if None.

    Raises
    ------
    InputError
        A table is missing or damaged, the scene is unknown, or it has no sweep of a LIDAR.
    """
    folder = reader.folder_of_tables(path)
    if folder is None:
        raise InputError(f"{path}: no {reader.ANNOTATIONS} in it or in a folder below; give a nuScenes folder")
    with readable(folder, WHAT):
        names = ("scene", "sample", "sample_data", "ego_pose", "calibrated_sensor", "sensor")
        tables = {name: reader.read_table(folder / f"{name}.json") for name in names}
        token = _scene(path, tables["scene"], scene)
        sweeps = _sweeps(tables, token)
        mount_of = {row["calibrated_sensor_token"]: row for row in sweeps}
        sensors = sorted(mount_of, key=lambda key: _channel(tables, tables["calibrated_sensor"][key]))
        poses = [_pose(row, tables["ego_pose"][row["ego_pose_token"]]) for row in sweeps]
        mounts = tuple(_mount(folder, tables["calibrated_sensor"][key]) for key in sensors)
    if not sweeps:
        raise InputError(f"{path}: the scene has no sweep of a LIDAR; give the folder with sample_data of LIDARs")

    def read(row: int) -> list[Sweep]:
        found = sweeps[row]
        file = folder.parent / found["filename"]
        with readable(file, "points of nuScenes"):
            points = np.fromfile(file, POINT)
            if POINT.itemsize * len(points) != file.stat().st_size:
                raise ValueError("its size is not a multiple of five float32")
        return [sweep_of_table(points, _time(found), sensors.index(found["calibrated_sensor_token"]))]

    return DataSet(path, np.arange(len(sweeps)), read, PoseList(rows=poses), mounts, lambda: [_boxes(path, token)])


def _scene(path: Path, scenes: dict[str, Row], name: str | None) -> str:
    known = {str(row["name"]): token for token, row in scenes.items()}
    if name is None and len(scenes) == 1:
        return next(iter(scenes))
    if name in scenes:
        return str(name)
    if name in known:
        return known[name]
    raise InputError(
        f"{path}: {'no' if name else 'several'} scene{f' {name}' if name else 's'}; give --scene, one of "
        f"{', '.join(known)[:300]}"
    )


def _sweeps(tables: dict[str, dict[str, Row]], scene: str) -> list[Row]:
    """Return the sweeps of the LIDARs of a scene in the order of time."""
    samples = {token for token, row in tables["sample"].items() if row["scene_token"] == scene}
    lidars = {
        token
        for token, row in tables["calibrated_sensor"].items()
        if tables["sensor"][row["sensor_token"]]["modality"] == "lidar"
    }
    rows = [
        row
        for row in tables["sample_data"].values()
        if row["calibrated_sensor_token"] in lidars and row["sample_token"] in samples
    ]
    return sorted(
        rows,
        key=lambda row: (_time(row), _channel(tables, tables["calibrated_sensor"][row["calibrated_sensor_token"]])),
    )


def _channel(tables: dict[str, dict[str, Row]], calibrated: Row) -> str:
    return str(tables["sensor"][calibrated["sensor_token"]]["channel"])


def _time(row: Row) -> float:
    return MICROSECONDS * float(row["timestamp"])


def _pose(sweep: Row, pose: Row) -> tuple[float, float, float, float]:
    x, y, _ = pose["translation"]
    return _time(sweep), float(x), float(y), reader.yaw(np.array(pose["rotation"], dtype=np.float64))


def _mount(folder: Path, row: Row) -> EgoMount:
    file = folder / "calibrated_sensor.json"
    w, x, y, z = reader.number_list(file, str(row["token"]), row, "rotation", 4).tolist()
    origin = reader.number_list(file, str(row["token"]), row, "translation", 3)
    return EgoMount(origin, Rotation.from_quat([x, y, z, w]).as_matrix())


def _boxes(path: Path, scene: str) -> BoxTable:
    """Return the boxes of a scene."""
    table = reader.read_tables(path)
    sample = [] if table.sample is None else table.sample.tolist()
    return table.select(np.array([table.scene_of[token] == scene for token in sample], dtype=np.bool_))
