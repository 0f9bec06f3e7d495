"""Sweeps, ego poses and true boxes of one log of Argoverse 2's sensor or lidar data set.

Files are Apache Feather (README of the sensor data set in the development kit): `sensors/lidar/TIMESTAMP_NS.feather`
with `x`, `y`, `z` [m] in the ego frame and `laser_number`, `city_SE3_egovehicle.feather` with the poses, and
`annotations.feather`. The motion of the ego during a sweep is already removed: all points are in the ego frame at the
time of the sweep, and `offset_ns` is not used. The ego frame starts at the rear axle.
"""

from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.feather

from luxloop.arrays import Floats, Ints
from luxloop.scenarios.errors import InputError, TracksError
from luxloop.scenarios.exchange.box_table import BoxTable, checked
from luxloop.scenarios.recordings.ego_mount import EgoMount
from luxloop.scenarios.recordings.formats.format_choice import readable
from luxloop.scenarios.recordings.sweep import DataSet, PoseList, Sweep

ANNOTATIONS, POSES, SWEEPS = "annotations.feather", "city_SE3_egovehicle.feather", "sensors/lidar"
QUATERNION, TRANSLATION = ("qw", "qx", "qy", "qz"), ("tx_m", "ty_m", "tz_m")
WHAT = "Argoverse 2"
NANOSECONDS = 1e-9


def log_folder(path: Path, name: str | None) -> Path:
    """Return the folder of a log: `path`, or the folder below it with this name, or the only one.

    Raises
    ------
    InputError
        There is none, or there are several.
    """
    if (path / POSES).is_file():
        return path
    known = sorted(found.parent.name for found in path.glob(f"*/{POSES}"))
    if name in known or (name is None and len(known) == 1):
        return path / (name or known[0])
    if not known:
        raise InputError(f"{path}: no {POSES} in it or in a folder below; give the folder of a log of Argoverse 2")
    what = f"no log {name}" if name else f"has {len(known)} logs"
    raise InputError(f"{path}: {what}; give --scene, one of {', '.join(known)[:300]}")


def open_recording(path: Path, name: str | None) -> DataSet:
    """Open a log.

    Raises
    ------
    InputError
        A file is missing or damaged.
    """
    folder = log_folder(path, name)
    files = sorted((folder / SWEEPS).glob("[0-9]*.feather"), key=lambda file: int(file.stem))
    if not files:
        raise InputError(f"{folder / SWEEPS}: no TIMESTAMP.feather; give a log with sweeps")
    time = NANOSECONDS * np.array([int(file.stem) for file in files], dtype=np.float64)
    with readable(folder / POSES, WHAT):
        poses = _table(folder / POSES)
        rows = np.column_stack([_seconds(poses), *_columns(poses, TRANSLATION[:2]).T, _yaw(poses)])

    def read(row: int) -> list[Sweep]:
        with readable(files[row], WHAT):
            table = _table(files[row])
            ring = table["laser_number"].to_numpy().astype(np.int64)
            points = _columns(table, ("x", "y", "z"))
            whole = Sweep(float(time[row]), 0, points, np.zeros(len(points)), ring)
            return [whole.subset(np.flatnonzero(np.isfinite(points).all(axis=1)))]

    return DataSet(
        path,
        np.arange(len(files)),
        read,
        PoseList("city", [tuple(row) for row in rows.tolist()]),
        (EgoMount.of(np.zeros(3), 0.0, 0.0, 0.0),),
        (lambda: [read_boxes(folder / ANNOTATIONS)]) if (folder / ANNOTATIONS).is_file() else None,
    )


def read_boxes(path: Path) -> BoxTable:
    """Return the boxes of a file of annotations, about the ego.

    Raises
    ------
    TracksError
        The file cannot be read, lacks a column, or has an invalid box.
    """
    try:
        table = _table(path)
        boxes = _columns(table, (*TRANSLATION[:2], "length_m", "width_m"))
        found = BoxTable(
            source=path,
            axes="ego",
            id=np.array(table["track_uuid"].to_pylist(), dtype=np.str_),
            boxes=np.column_stack([boxes[:, :2], _yaw(table), boxes[:, 2:]]),
            time_s=_seconds(table),
            z_m=_columns(table, ("tz_m",))[:, 0],
            height_m=_columns(table, ("height_m",))[:, 0],
            points=_integers(table, "num_interior_pts"),
            kind=np.char.lower(np.array(table["category"].to_pylist(), dtype=np.str_)),
        )
    except (OSError, KeyError, ValueError, pa.ArrowException) as error:
        reason = " ".join(str(error).split())
        raise TracksError(f"{path}: cannot be read ({reason}); give {ANNOTATIONS} of Argoverse 2") from error
    return checked(found, lambda row: f"row {row + 1}")


def _table(path: Path) -> pa.Table:
    return pyarrow.feather.read_table(path)


def _columns(table: pa.Table, names: tuple[str, ...]) -> Floats:
    """(N, C) columns of numbers."""
    return np.column_stack([table[name].to_numpy().astype(np.float64) for name in names])


def _integers(table: pa.Table, name: str) -> Ints | None:
    return table[name].to_numpy().astype(np.int64) if name in table.column_names else None


def _seconds(table: pa.Table) -> Floats:
    found: Floats = NANOSECONDS * table["timestamp_ns"].to_numpy().astype(np.float64)
    return found


def _yaw(table: pa.Table) -> Floats:
    """(N,) heading [rad] of the x axis."""
    w, x, y, z = _columns(table, QUATERNION).T
    found: Floats = np.arctan2(2.0 * (w * z + x * y), w * w + x * x - y * y - z * z)
    return found
