"""Tracks from a file of another program, as a device under test for recorded scans.

The layout is documented in docs/own-tracker.md.
"""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pandas as pd

from luxloop.arrays import Bools, Floats, Ints
from luxloop.scenarios.dataset.dataset_columns import Column
from luxloop.scenarios.errors import TracksError
from luxloop.scenarios.files.input_file import read_parquet, require_plain
from luxloop.scenarios.grading.frame_tables import LABELS
from luxloop.sim import input_files
from luxloop.tracker.records import Status, Tracks
from luxloop.tracker.scan import Scan
from luxloop.tracker.tracker import TrackerConfig

WHEN = (
    Column("frame", np.int64, "", "number of the scan, from 0, as in `scans.parquet`"),
    Column("time_s", np.float64, "s", "time of the scan, within 1 ms; used without `frame`"),
)
REQUIRED = (
    Column("track_id", np.int64, "", "id of the track, 0 or more: the same in all frames, never reused"),
    Column("x_odom_m", np.float64, "m", "centre of the box, in the odometry frame of `odom_x_m` and `odom_y_m`"),
    Column("y_odom_m", np.float64, "m", "the same, y"),
    Column("heading_odom_rad", np.float64, "rad", "heading of its front, counter-clockwise from the x axis"),
    Column("length_m", np.float64, "m", "length of the box, along the heading"),
    Column("width_m", np.float64, "m", "width of the box"),
)
VELOCITY = (
    Column("vx_odom_mps", np.float64, "m/s", "velocity over ground, on the axes of the odometry frame"),
    Column("vy_odom_mps", np.float64, "m/s", "the same, y; empty cells where the velocity is unknown"),
)
OPTIONAL = (
    Column(
        "status",
        tuple(status.name.lower() for status in Status),
        "",
        "default `confirmed`; other tracks are not reported",
    ),
    Column("label", LABELS, "", "`small` for people and bicycles; without the column, the classes are unknown"),
)
"""A file needs one of `WHEN` and all of `REQUIRED`; others than these, `VELOCITY` and `OPTIONAL` are not read."""


def read(path: Path) -> pd.DataFrame:
    """Return the columns of a file in their types; `status` as codes.

    Raises
    ------
    TracksError
        The file is missing or not a table, lacks a column, or has an invalid cell. Rows are counted from 1, without
        the header.
    """
    table = read_table(path, parquet=path.suffix == ".parquet")
    when = [column for column in WHEN if column.name in table][:1]
    if not when:
        raise TracksError(f"{path}: no column frame or time_s; add one that gives the scan of each row")
    columns: dict[str, npt.NDArray[Any]] = {}
    for column in (*when, *REQUIRED):
        if column.name not in table:
            raise TracksError(f"{path}: no column {column.name}; found {', '.join(table)}; see docs/own-tracker.md")
        columns[column.name] = numbers(path, table[column.name], column)
    for name in ("length_m", "width_m"):
        require(path, table[name], columns[name] > 0, "should be more than 0")
    require(path, table["track_id"], columns["track_id"] >= 0, "should be 0 or more")
    columns |= _velocity(path, table)
    return pd.DataFrame({**columns, "status": _status(path, table), **_small(path, table)})


def require(path: Path, cells: pd.Series, valid: Bools, remedy: str) -> None:
    """Raise a TracksError for the first row whose cell is not valid; `valid` is (N,)."""
    if not valid.all():
        row = int(np.argmin(valid))
        cell = cells.iloc[row]
        shown = "an empty cell" if pd.api.types.is_scalar(cell) and pd.isna(cell) else str(cell)[:60]
        raise TracksError(f"{path}: column {cells.name}, row {row + 1}: {shown}: {remedy}")


def read_table(path: Path, *, parquet: bool) -> pd.DataFrame:
    """Return a CSV or Parquet file; the cells of CSV are texts.

    Raises
    ------
    TracksError
        The file cannot be read as a table, the rows of a CSV file have more cells than its header, or a column occurs
        twice.
    """
    try:
        if parquet:
            return _with_unique_columns(path, read_parquet(path).to_pandas())
        require_plain(path)
        table = pd.read_csv(path, dtype=str, skipinitialspace=True, keep_default_na=False, na_values=[""])
    except (ValueError, OSError) as error:  # not Parquet, not UTF-8 and not rectangular are ValueErrors
        reason = getattr(error, "strerror", None) or " ".join(str(error).split())
        raise TracksError(
            f"{path}: cannot be read ({reason}); give a CSV file with a header, or a .parquet file"
        ) from error
    if fault := input_files.surplus(table):
        raise TracksError(f"{path}: {fault}")
    return _with_unique_columns(path, table.rename(columns=str.strip))


def _with_unique_columns(path: Path, table: pd.DataFrame) -> pd.DataFrame:
    if not table.columns.is_unique:
        twice = table.columns[table.columns.duplicated()][0]
        raise TracksError(f"{path}: column {twice} occurs twice; give each column once")
    return table


def numbers(path: Path, cells: pd.Series, column: Column) -> npt.NDArray[Any]:
    """Return (N,) finite numbers, as integers if the column has an integer type.

    Raises
    ------
    TracksError
        A cell is no such number.
    """
    values: Floats = pd.to_numeric(cells, errors="coerce").to_numpy(np.float64, na_value=np.nan)
    require(path, cells, np.isfinite(values), "should be a number")
    if column.kind is not np.int64:
        return values
    require(path, cells, (values == np.rint(values)) & (np.abs(values) < 2**53), "should be an integer")
    return values.astype(np.int64)


def _velocity(path: Path, table: pd.DataFrame) -> dict[str, npt.NDArray[Any]]:
    """Return (N,) both components, NaN where they are empty or the file has no such columns."""
    found = [column for column in VELOCITY if column.name in table]
    if len(found) == 1:
        raise TracksError(f"{path}: column {found[0].name} without the other of vx_odom_mps and vy_odom_mps; add it")
    values = {column.name: np.full(len(table), np.nan) for column in VELOCITY}
    for column in found:
        cells = table[column.name]
        numbers: Floats = pd.to_numeric(cells, errors="coerce").to_numpy(np.float64, na_value=np.nan)
        require(path, cells, np.isfinite(numbers) | cells.isna().to_numpy(), "should be a number, or empty")
        values[column.name] = numbers
    x, y = (np.isnan(numbers) for numbers in values.values())
    for column in found:
        require(path, table[column.name], x == y, "should be empty in both columns of the velocity, or in none")
    return values


def _status(path: Path, table: pd.DataFrame) -> npt.NDArray[np.uint8]:
    """Return (N,) `Status`; all are confirmed if the file has no such column."""
    if "status" not in table:
        return np.full(len(table), Status.CONFIRMED, np.uint8)
    names = {status.name.lower(): status for status in Status}
    valid = table["status"].isin(list(names)).to_numpy(np.bool_)
    require(path, table["status"], valid, f"should be one of {', '.join(names)}")
    return np.array([names[name] for name in table["status"]], dtype=np.uint8)


def _small(path: Path, table: pd.DataFrame) -> dict[str, Bools]:
    """Return `small`, (N,) True for people and bicycles; nothing if the file has no column `label`."""
    if "label" not in table:
        return {}
    valid = table["label"].isin(LABELS).to_numpy(np.bool_)
    require(path, table["label"], valid, f"should be one of {', '.join(LABELS)}")
    return {"small": (table["label"] == "small").to_numpy(np.bool_)}


TIME_TOLERANCE_S = 1e-3
"""[s] Tolerance between the time of a row and of its scan: programs round times."""
WITHOUT_ROWS_MAX = 0.05
"""Fraction of the scans after the first row that have no row, above which a warning says so."""


class TrackFile:
    """Device under test that returns the tracks of a file for each scan.

    Parameters
    ----------
    path
        Path of the file.
    time_s
        (F,) times of the scans [s].

    Raises
    ------
    TracksError
        The file has an invalid layout, or belongs to other scans.
    """

    def __init__(self, path: Path, time_s: Floats) -> None:
        rows = read(path)
        frame = _frames(path, rows, time_s)
        _refuse_duplicates(path, rows["track_id"].to_numpy(), frame)
        self.warnings = _scans_without_rows(path, frame, len(time_s))
        """At most one line, on scans without tracks."""
        order = np.argsort(frame, kind="stable")
        ends = np.searchsorted(frame[order], np.arange(1, len(time_s)))
        self._tracks_by_frame: Iterator[pd.DataFrame] = iter([rows.iloc[part] for part in np.split(order, ends)])

    def as_device(self, _config: TrackerConfig) -> "TrackFile":
        """Return this object; a `luxloop.scenarios.run.device.DeviceFactory`."""
        return self

    def step(self, scan: Scan) -> Tracks:
        """Return the tracks of the next scan."""
        del scan  # the file has all of its tracks
        return _tracks(next(self._tracks_by_frame))


def _frames(path: Path, rows: pd.DataFrame, time_s: Floats) -> Ints:
    """Return (N,) frame number of each row."""
    if "frame" in rows:
        frame: Ints = rows["frame"].to_numpy()
        known = (frame >= 0) & (frame < len(time_s))
        require(path, rows["frame"], known, f"the run has frames 0 to {len(time_s) - 1}")
        return frame
    time = rows["time_s"].to_numpy()
    nearest: Ints = np.searchsorted(0.5 * (time_s[1:] + time_s[:-1]), time)
    near = np.abs(time - time_s[nearest]) <= TIME_TOLERANCE_S
    require(path, rows["time_s"], near, "no scan is within 1 ms of it; see time_s in scans.parquet")
    return nearest


def _scans_without_rows(path: Path, frame: Ints, count: int) -> tuple[str, ...]:
    """Return a line on the scans of `count` without rows of tracks, if they are many."""
    known = np.unique(frame)
    after = count - int(known[0]) if len(known) else 0
    if after - len(known) <= WITHOUT_ROWS_MAX * after:
        return ()
    return (
        f"{path}: {after - len(known)} of the {after} scans from frame {known[0]} on have no tracks, so vehicles in "
        "them count as missed; if the tracker skips scans, give its tracks in them, too",
    )


def _refuse_duplicates(path: Path, track_id: Ints, frame: Ints) -> None:
    duplicate = pd.DataFrame({"frame": frame, "track_id": track_id}).duplicated().to_numpy(np.bool_)
    if duplicate.any():
        row = int(np.argmax(duplicate))
        raise TracksError(
            f"{path}: column track_id, row {row + 1}: {track_id[row]}: occurs twice in frame {frame[row]}; "
            "give each track one row per frame"
        )


def _tracks(rows: pd.DataFrame) -> Tracks:
    """Return the rows of a frame as tracks."""
    return Tracks.from_boxes(
        rows["track_id"].to_numpy(),
        rows[["x_odom_m", "y_odom_m"]].to_numpy(),
        rows["heading_odom_rad"].to_numpy(),
        rows[["length_m", "width_m"]].to_numpy(),
        velocity=rows[["vx_odom_mps", "vy_odom_mps"]].to_numpy(),
        status=rows["status"].to_numpy(),
        small=rows["small"].to_numpy() if "small" in rows else None,
    )
