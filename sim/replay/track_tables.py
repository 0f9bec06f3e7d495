"""Recordings in tables: CSV and Parquet files in the layout of docs/own-scenario.md, one row per sample."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from luxloop.arrays import Floats, Ints
from luxloop.sim import input_files
from luxloop.sim.input_files import DAMAGED, open_gz
from luxloop.sim.replay.recording import Recording, ReplayType, RoadUser, kind_and_size
from luxloop.sim.source import TrafficInputError
from luxloop.sim.world import Kind

REQUIRED = ("time_s", "id", "x_m", "y_m")
SIZES = ("length_m", "width_m", "height_m")
OPTIONAL = ("yaw_deg", *SIZES, "kind", "reflectivity")
"""Cells of sizes, kind and reflectivity may be empty, or the columns missing. All other columns are ignored."""

DEFAULT_KIND = "car"
MOST_ROWS = 10_000_000
"""More would take more than a gigabyte of memory. A small file of equal rows may hold billions."""


def read_table(path: Path, types: Mapping[str, ReplayType]) -> Recording:
    """Read a `.csv`, `.csv.gz` or `.parquet`.

    Parameters
    ----------
    path
        The file.
    types
        Meaning of values in the column `kind` that are not names of kinds.

    Raises
    ------
    TrafficInputError
        The file is not a table, lacks a column or rows, or has an invalid cell.
    """
    try:
        table = _parquet(path) if path.suffix == ".parquet" else _csv(path)
    except (ValueError, *DAMAGED) as error:
        raise TrafficInputError(f"not a table: {' '.join(str(error).split())}") from error
    if not len(table):
        raise TrafficInputError("has no rows; each row is one road user at one time")
    time, x, y = (_numbers(table, column) for column in ("time_s", "x_m", "y_m"))
    yaw = np.radians(_numbers(table, "yaw_deg")) if "yaw_deg" in table else np.full(len(table), np.nan)
    user, names = _users(table)
    return Recording(_road_users(table, user, names, types), user, time, np.column_stack([x, y, yaw]))


def _csv(path: Path) -> Any:
    """Read a CSV file; empty cells become NaN, ids and kinds remain text."""
    import pandas as pd

    text = dict.fromkeys(("id", "kind"), str)
    with open_gz(path) if path.suffix == ".gz" else path.open("rb") as stream:
        # pandas' markers of missing values, such as "NA" and "None", are valid ids
        table = pd.read_csv(stream, dtype=text, skipinitialspace=True, keep_default_na=False, na_values=[""])
    if fault := input_files.surplus(table):
        raise TrafficInputError(fault)
    table = table.rename(columns=lambda name: str(name).strip())
    return table[_require_columns(list(table.columns))]


def _parquet(path: Path) -> Any:
    import pyarrow.parquet as pq

    with pq.ParquetFile(path) as file:
        columns = _require_columns(file.schema_arrow.names)
        if file.metadata.num_rows > MOST_ROWS:
            raise TrafficInputError(f"has {file.metadata.num_rows} rows; the limit is {MOST_ROWS}, cut it into parts")
        return file.read(columns).to_pandas()


def _require_columns(names: list[str]) -> list[str]:
    """Return the known columns of a file."""
    if double := sorted({column for column in names if names.count(column) > 1}):
        raise TrafficInputError(f"column {double[0]} occurs twice; remove one")
    if missing := [column for column in REQUIRED if column not in names]:
        raise TrafficInputError(f"column {missing[0]} is missing; the file has {', '.join(names) or 'none'}")
    return [column for column in (*REQUIRED, *OPTIONAL) if column in names]


def _numbers(table: Any, column: str, *, empty: bool = False) -> Floats:
    """Return a column (S,) of finite numbers; NaN where `empty` cells are allowed."""
    import pandas as pd

    cells = _require_scalars(table, column)
    values: Floats = pd.to_numeric(cells, errors="coerce").to_numpy(dtype=np.float64, na_value=np.nan)
    wrong = ~np.isfinite(values)
    if empty:
        wrong &= cells.notna().to_numpy()
    _require(table, column, ~wrong, "should be a number; correct it or remove the row")
    return values


def _require_scalars(table: Any, column: str) -> Any:
    """Return a column of numbers or texts, whose other cells are empty."""
    import pandas as pd

    cells = table[column]
    if not (pd.api.types.is_numeric_dtype(cells) or pd.api.types.is_string_dtype(cells.dropna())):
        raise TrafficInputError(f"column {column} holds {cells.dtype}; write numbers or texts")
    return cells.astype(object) if isinstance(cells.dtype, pd.CategoricalDtype) else cells


def _require(table: Any, column: str, good: Any, remedy: str) -> None:
    """Raise an error for the first row with an invalid cell; rows count from 1 below the heading."""
    if len(bad := np.flatnonzero(~good)):
        cell = table[column].iloc[bad[0]]
        shown = "an empty cell" if cell is None or (isinstance(cell, float) and np.isnan(cell)) else str(cell)[:60]
        raise TrafficInputError(f"column {column}, row {bad[0] + 1}: {shown}: {remedy}")


def _users(table: Any) -> tuple[Ints, list[str]]:
    """Return the index (S,) of each row's road user, and the sorted names of all."""
    import pandas as pd

    cells = _require_scalars(table, "id")
    if pd.api.types.is_float_dtype(cells):
        _require(table, "id", ~np.isinf(cells.to_numpy()), "should be an id; correct it or remove the row")
    user, names = pd.factorize(cells, sort=True)
    _require(table, "id", user >= 0, "should be an id; fill it in or remove the row")
    return user.astype(np.int64), [str(int(name) if isinstance(name, float) else name) for name in names]


def _road_users(table: Any, user: Ints, names: list[str], types: Mapping[str, ReplayType]) -> list[RoadUser]:
    defaults = _kinds(table, user, len(names), types)
    size = np.array([size for _, size in defaults])
    for axis, column in enumerate(SIZES):
        if column in table:
            medians = _medians(table, column, user)
            size[:, axis] = np.where(np.isnan(medians), size[:, axis], medians)
    reflectivity = _medians(table, "reflectivity", user) if "reflectivity" in table else np.full(len(names), np.nan)
    return [
        RoadUser(name, kind, (length, width, height), None if np.isnan(paint) else paint)
        for name, (kind, _), (length, width, height), paint in zip(
            names, defaults, size.tolist(), reflectivity.tolist(), strict=True
        )
    ]


def _medians(table: Any, column: str, user: Ints) -> Floats:
    """Return the median of a positive number for each road user (U,), NaN where all cells are empty."""
    import pandas as pd

    values = _numbers(table, column, empty=True)
    _require(table, column, ~(values <= 0), "should be positive; leave the cell empty if the value is unknown")
    if column == "reflectivity":
        _require(table, column, ~(values > 1), "should be at most 1")
    medians: Floats = pd.Series(values).groupby(user).median().to_numpy()
    return medians


def _kinds(
    table: Any, user: Ints, count: int, types: Mapping[str, ReplayType]
) -> list[tuple[Kind, tuple[float, float, float]]]:
    """Return kind and default size of each road user."""
    import pandas as pd

    if "kind" not in table:
        return [kind_and_size(DEFAULT_KIND, types)] * count
    word, words = pd.factorize(_require_scalars(table, "kind").fillna(DEFAULT_KIND))
    _, first = np.unique(user, return_index=True)
    _require(table, "kind", word == word[first][user], "differs from an earlier row of the same id; an id has one kind")
    meaning = []
    for number, text in enumerate(words):
        try:
            meaning.append(kind_and_size(str(text), types))
        except TrafficInputError as error:
            raise TrafficInputError(f"column kind, row {np.argmax(word == number) + 1}: {error}") from error
    return [meaning[number] for number in word[first]]
