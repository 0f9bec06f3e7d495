"""Reader of boxes in CSV and Parquet: tracks as in docs/own-tracker.md, labels of data sets, and tables of runs."""

from pathlib import Path
from typing import NamedTuple

import numpy as np
import pandas as pd

from luxloop.arrays import Bools, Floats
from luxloop.scenarios.dataset.dataset_columns import Column
from luxloop.scenarios.errors import TracksError
from luxloop.scenarios.exchange.box_table import ANY_AXES, BoxTable, Texts, checked
from luxloop.scenarios.offline.track_file import numbers, read_table, require

AXES = (ANY_AXES, "odom", "world", "ego")
"""Frames of reference in names of columns: `x_m`, `x_odom_m`, `x_world_m`, `x_ego_m`."""
IDS = ("track_id", "actor_id", "id")
KINDS, SCENES = ("class", "kind"), ("scene", "sequence")
FRAME, POINTS = Column("frame", np.int64, "", ""), Column("points", np.int64, "", "")
CONFIRMED = "confirmed"
"""Only rows with this `status` are reported, where there is such a column."""


class Position(NamedTuple):
    """Names of the columns of a pose in one frame of reference."""

    axes: str
    x: str
    y: str
    heading: str


def read(path: Path, *, parquet: bool = False) -> list[BoxTable]:
    """Return the boxes of a file, once for each frame of reference that it has.

    Raises
    ------
    TracksError
        The file is not a table, lacks a column, or has an invalid cell. Rows are counted from 1, without the header.
    """
    return boxes_of(path, read_table(path, parquet=parquet))


def boxes_of(path: Path, table: pd.DataFrame) -> list[BoxTable]:
    """Return the boxes of the table of a file, as `read`."""
    positions = [position for axes in AXES if (position := _position(table, axes))]
    if not positions:
        raise TracksError(
            f"{path}: no columns x_m, y_m and heading_rad, nor with odom, world or ego in their names; found "
            f"{', '.join(map(str, table.columns))[:300]}; see docs/formats.md"
        )
    boxes = [checked(_table(path, table, position), lambda row: f"row {row + 1}") for position in positions]
    if "status" not in table:
        return boxes
    reported = (table["status"] == CONFIRMED).to_numpy(np.bool_)
    return [found.select(reported) for found in boxes]


def _position(table: pd.DataFrame, axes: str) -> Position | None:
    """Return the columns of a frame of reference, or None if one is missing; `yaw` stands for `heading`, too."""
    of = f"_{axes}" if axes else ""
    for heading in ("heading", "yaw"):
        names = Position(axes, f"x{of}_m", f"y{of}_m", f"{heading}{of}_rad")
        if all(name in table for name in names[1:]):
            return names
    return None


def _table(path: Path, table: pd.DataFrame, position: Position) -> BoxTable:
    missing = [name for name in ("length_m", "width_m") if name not in table]
    if missing:
        raise TracksError(f"{path}: no column {missing[0]}; add it; see docs/formats.md")
    names = (position.x, position.y, position.heading, "length_m", "width_m")
    boxes = np.column_stack([_floats(path, table, name) for name in names])
    frame = numbers(path, table["frame"], FRAME) if "frame" in table else None
    time_s = _floats(path, table, "time_s") if "time_s" in table else None
    if frame is None and time_s is None:
        raise TracksError(f"{path}: no column frame or time_s; add one that gives the scan of each row")
    return BoxTable(
        source=path,
        axes=position.axes,
        id=_texts(path, table, IDS),
        boxes=boxes.reshape(-1, len(names)),
        frame=frame,
        time_s=time_s,
        scene=_texts(path, table, SCENES) if any(name in table for name in SCENES) else None,
        velocity=_velocity(path, table, position.axes),
        z_m=_floats(path, table, "z_m") if "z_m" in table else None,
        height_m=_floats(path, table, "height_m") if "height_m" in table else None,
        score=_floats(path, table, "score") if "score" in table else None,
        points=numbers(path, table["points"], POINTS) if "points" in table else None,
        kind=np.char.lower(_texts(path, table, KINDS)) if any(name in table for name in KINDS) else None,
    )


def _floats(path: Path, table: pd.DataFrame, name: str) -> Floats:
    values: Floats = numbers(path, table[name], Column(name, np.float64, "", ""))
    return values


def _texts(path: Path, table: pd.DataFrame, names: tuple[str, ...]) -> Texts:
    """(N,) texts of the first of some columns that the table has; no cell is empty."""
    name = next((name for name in names if name in table), None)
    if name is None:
        raise TracksError(f"{path}: no column {names[0]}; add it, with the id of each row")
    cells = table[name]
    require(path, cells, ~cells.isna().to_numpy(np.bool_), "give a value")
    return np.array([str(cell) for cell in cells], dtype=np.str_)


def _velocity(path: Path, table: pd.DataFrame, axes: str) -> Floats | None:
    """(N, 2) velocity on the axes of the positions, NaN in empty cells; None without its columns."""
    of = f"_{axes}" if axes else ""
    names = (f"vx{of}_mps", f"vy{of}_mps")
    found = [name for name in names if name in table]
    if len(found) == 1:
        raise TracksError(f"{path}: column {found[0]} without the other of {names[0]} and {names[1]}; add it")
    if not found:
        return None
    columns = []
    for name in names:
        values: Floats = pd.to_numeric(table[name], errors="coerce").to_numpy(np.float64, na_value=np.nan)
        valid: Bools = np.isfinite(values) | table[name].isna().to_numpy(np.bool_)
        require(path, table[name], valid, "should be a number, or empty")
        columns.append(values)
    return np.column_stack(columns)
