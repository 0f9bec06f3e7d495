"""The layout of track files, and how one is read: every cell is checked, and the first wrong one is named.

docs/other-trackers.md tells the columns to those who write such files.
"""

from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pandas as pd
import pyarrow.parquet as pq

from scenarios.arrays import Bools, Floats
from scenarios.dataset.dataset_columns import Column
from scenarios.errors import TracksError
from tracker.records import Status

WHEN = (
    Column("frame", np.int64, "", "number of the scan, from 0, as in `scans.parquet`"),
    Column("time_s", np.float64, "s", "time of the scan, within 1 ms; read where there is no `frame`"),
)
REQUIRED = (
    Column("track_id", np.int64, "", "who, 0 or more: the same in all frames, never given to another"),
    Column("x_odom_m", np.float64, "m", "middle of the box in the odometry frame, that of `odom_x_m` and so on"),
    Column("y_odom_m", np.float64, "m", "the same"),
    Column("heading_odom_rad", np.float64, "rad", "which way its front points, counter-clockwise from the x axis"),
    Column("length_m", np.float64, "m", "of the box, along the heading"),
    Column("width_m", np.float64, "m", "of the box, across"),
)
OPTIONAL = (
    Column(
        "status", tuple(status.name.lower() for status in Status), "", "`confirmed` if left out; others are no report"
    ),
)
"""One of `WHEN` must be there, all of `REQUIRED`, and `OPTIONAL` may be. Other columns are not read."""


def read(path: Path) -> pd.DataFrame:
    """Read a file's columns, in their types; `status` as codes.

    Raises
    ------
    TracksError
        It is missing or no table, lacks a column, or has a cell that is wrong. Rows count from 1 below the heading.
    """
    table = _table(path)
    when = [column for column in WHEN if column.name in table][:1]
    if not when:
        raise TracksError(f"{path}: no column frame or time_s in it; say of which scan each row is")
    columns: dict[str, npt.NDArray[Any]] = {}
    for column in (*when, *REQUIRED):
        if column.name not in table:
            raise TracksError(
                f"{path}: no column {column.name} in it, but {', '.join(table)}; see docs/other-trackers.md"
            )
        columns[column.name] = _numbers(path, table[column.name], column)
    for name in ("length_m", "width_m"):
        require(path, table[name], columns[name] > 0, "should be more than 0")
    require(path, table["track_id"], columns["track_id"] >= 0, "should be 0 or more")
    return pd.DataFrame({**columns, "status": _status(path, table)})


def require(path: Path, cells: pd.Series, good: Bools, remedy: str) -> None:
    """Raise a TracksError with the first row whose cell is not good."""
    if not good.all():
        row = int(np.argmin(good))
        cell = cells.iloc[row]
        shown = "an empty cell" if pd.isna(cell) else cell
        raise TracksError(f"{path}: column {cells.name}, row {row + 1}: {shown}: {remedy}")


def _table(path: Path) -> pd.DataFrame:
    try:
        if path.suffix == ".parquet":
            return pq.read_table(path).to_pandas()
        return pd.read_csv(path, dtype=str, skipinitialspace=True, keep_default_na=False, na_values=[""]).rename(
            columns=str.strip
        )
    except (ValueError, OSError) as error:  # what is no Parquet, not UTF-8 or not rectangular is a ValueError
        why = getattr(error, "strerror", None) or " ".join(str(error).split())
        raise TracksError(
            f"{path}: cannot be read ({why}); give a CSV file with a heading, or a .parquet one"
        ) from error


def _numbers(path: Path, cells: pd.Series, column: Column) -> npt.NDArray[Any]:
    """(N,) finite numbers, whole ones where the column holds such."""
    values: Floats = pd.to_numeric(cells, errors="coerce").to_numpy(np.float64, na_value=np.nan)
    require(path, cells, np.isfinite(values), "should be a number")
    if column.kind is not np.int64:
        return values
    require(path, cells, (values == np.rint(values)) & (np.abs(values) < 2**53), "should be a whole number")
    return values.astype(np.int64)


def _status(path: Path, table: pd.DataFrame) -> npt.NDArray[np.uint8]:
    """(N,) `Status`; of a file that does not tell, all are confirmed."""
    if "status" not in table:
        return np.full(len(table), Status.CONFIRMED, np.uint8)
    names = {status.name.lower(): status for status in Status}
    good = table["status"].isin(list(names)).to_numpy(np.bool_)
    require(path, table["status"], good, f"should be one of {', '.join(names)}")
    return np.array([names[name] for name in table["status"]], dtype=np.uint8)
