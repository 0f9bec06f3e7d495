"""Points of a Parquet file in the ego frame, with the times and poses of the scans in `scans.parquet` beside it.

The layout is that of luxloop's data sets and recordings, of which `frame` and positions are required.
"""

from pathlib import Path

import numpy as np
import pyarrow as pa

from luxloop.arrays import Floats
from luxloop.scenarios.errors import InputError
from luxloop.scenarios.exchange import file_formats
from luxloop.scenarios.files.input_file import read_parquet
from luxloop.scenarios.offline.recorded_scans import require_numbers
from luxloop.scenarios.recordings.ego_mount import EgoMount
from luxloop.scenarios.recordings.formats.format_choice import readable
from luxloop.scenarios.recordings.sweep import DataSet, PoseList, Sweep

SCANS, LABELS = "scans.parquet", "labels.parquet"
"""Files beside the points: times and poses, and true boxes."""
POSE = ("time_s", "odom_x_m", "odom_y_m", "odom_yaw_rad")
POSITION = ("x_ego_m", "y_ego_m", "z_ego_m")
OPTIONAL = ("time_offset_s", "unit", "layer", "echo", "echo_pulse_width_m", "flags")
"""Columns of points that are 0 where they are missing."""
WHAT = "points in Parquet"


def open_recording(paths: list[Path]) -> DataSet:
    """Open one file of points.

    Raises
    ------
    InputError
        There are several files, a file is damaged, or a column is missing.
    """
    path = paths[0]
    beside, labels = path.parent / SCANS, path.parent / LABELS
    if len(paths) > 1:
        raise InputError(f"{paths[1]}: give one file of points; times and poses are in {SCANS} beside it")
    if not beside.is_file():
        raise InputError(f"{path}: no {SCANS} beside it; write one with the columns frame, {', '.join(POSE)}")
    with readable(beside, WHAT):
        scans = _columns(read_parquet(beside), ("frame", *POSE))
    with readable(path, WHAT):
        table = read_parquet(path)
        points = _columns(table, ("frame", *POSITION, *(name for name in OPTIONAL if name in table.column_names)))
    order = np.argsort(points["frame"], kind="stable")
    points = {name: values[order] for name, values in points.items()}
    units = int(points.get("unit", np.zeros(1)).max(initial=0.0)) + 1
    start = np.searchsorted(points["frame"], scans["frame"])
    end = np.searchsorted(points["frame"], scans["frame"], side="right")

    def read(row: int) -> list[Sweep]:
        rows = {name: values[start[row] : end[row]] for name, values in points.items()}
        return [_sweep(rows, float(scans["time_s"][row]), unit) for unit in range(units)]

    return DataSet(
        path,
        scans["frame"].astype(np.int64),
        read,
        PoseList(rows=list(zip(*(scans[name].tolist() for name in POSE), strict=True))),
        (EgoMount.of(np.zeros(3), 0.0, 0.0, 0.0),) * units,
        (lambda: file_formats.read(labels, "truth")) if labels.is_file() else None,
    )


def _columns(table: pa.Table, names: tuple[str, ...]) -> dict[str, Floats]:
    """Return columns of numbers."""
    if missing := [name for name in names if name not in table.column_names]:
        raise ValueError(f"no column {missing[0]}; it has {', '.join(table.column_names)[:300]}")
    found = {name: table[name].cast(pa.float64()).to_numpy() for name in names}
    require_numbers(found)
    return found


def _sweep(points: dict[str, Floats], time: float, unit: int) -> Sweep:
    count = len(points["frame"])
    column = {name: points.get(name, np.zeros(count)) for name in OPTIONAL}
    whole = Sweep(
        time,
        unit,
        np.column_stack([points[name] for name in POSITION]),
        column["time_offset_s"],
        column["layer"].astype(np.int64),
        column["echo"].astype(np.uint8),
        column["echo_pulse_width_m"],
        column["flags"].astype(np.int64),
    )
    return whole.subset(column["unit"] == unit)
