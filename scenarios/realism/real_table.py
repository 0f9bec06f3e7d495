"""Tables of real vehicles: figures per vehicle, and the bow by height."""

from pathlib import Path

import numpy as np
import pandas as pd

from luxloop.scenarios.errors import InputError
from luxloop.scenarios.realism.realism_comparison import FIGURES
from luxloop.sim import input_files

VIEW = ("range_m", "aspect_deg", "front_seen")
"""Columns by which vehicles are matched."""
BANDS = ("face", "from_m", "to_m", "lower_quartile_m", "median_m", "upper_quartile_m", "vehicles")
"""Columns of the table of the bow by height."""
TRUTHS = {"true": True, "false": False, "1": True, "0": False}


def read(path: Path) -> pd.DataFrame:
    """Read a table of real vehicles, a row each: the columns of the view, and any of the figures; empty cells are NaN.

    Raises
    ------
    InputError
        The file cannot be read, a column is missing, or a cell is invalid.
    """
    table = _csv(path)
    figures = [figure.name for figure in FIGURES if figure.name in table]
    _require(path, table, VIEW)
    if not figures:
        raise InputError(f"{path}: has no figure to compare; give at least one, e.g. the column {FIGURES[0].name}")
    numbers = [*VIEW[:2], *figures]
    real = pd.DataFrame({name: _numbers(path, table, name) for name in numbers})
    real["front_seen"] = _truths(path, table["front_seen"])
    for name in VIEW[:2]:
        _refuse(path, table, name, real[name].isna().to_numpy(), "give a number")
    _refuse(path, table, "range_m", (real["range_m"] <= 0.0).to_numpy(), "give a positive distance in metres")
    return real


def read_bands(path: Path | None) -> pd.DataFrame:
    """Read a table of the bow of real vehicles by height, a row per face and band; no rows without a file.

    Raises
    ------
    InputError
        As for `read`.
    """
    if path is None:
        return pd.DataFrame(columns=pd.Index(BANDS))
    table = _csv(path)
    _require(path, table, BANDS)
    bands = pd.DataFrame({name: _numbers(path, table, name) for name in BANDS[1:]})
    bands.insert(0, "face", table["face"].str.strip())
    _refuse(path, table, "face", ~bands["face"].isin(["end", "flank"]).to_numpy(), "give end or flank")
    for name in BANDS[1:]:
        _refuse(path, table, name, bands[name].isna().to_numpy(), "give a number")
    _refuse(path, table, "to_m", (bands["to_m"] <= bands["from_m"]).to_numpy(), "give more than from_m")
    return bands


def _csv(path: Path) -> pd.DataFrame:
    """Return the cells as text."""
    try:
        table = pd.read_csv(path, dtype=str, keep_default_na=False)
    except FileNotFoundError as error:
        raise InputError(f"{path}: does not exist; name a table of real vehicles as CSV") from error
    except (OSError, ValueError) as error:
        reason = str(error).splitlines()[0] if str(error) else type(error).__name__
        raise InputError(f"{path}: is not a CSV file ({reason}); see docs/realism.md for its columns") from error
    if fault := input_files.surplus(table):
        raise InputError(f"{path}: {fault}")
    if table.empty:
        raise InputError(f"{path}: has no rows; give a row per vehicle or band")
    return table


def _require(path: Path, table: pd.DataFrame, columns: tuple[str, ...]) -> None:
    missing = [name for name in columns if name not in table]
    if missing:
        raise InputError(f"{path}: column {missing[0]} is missing; see docs/realism.md for the columns")


def _numbers(path: Path, table: pd.DataFrame, name: str) -> pd.Series:
    """Return a column as finite numbers, NaN for empty cells."""
    cells = table[name].str.strip()
    values = pd.to_numeric(cells.where(cells != ""), errors="coerce").astype(np.float64)
    _refuse(path, table, name, ((cells != "") & ~np.isfinite(values)).to_numpy(), "give a number, or leave it empty")
    return values


def _truths(path: Path, cells: pd.Series) -> pd.Series:
    values = cells.str.strip().str.lower().map(TRUTHS)
    _refuse(path, cells.to_frame(), "front_seen", values.isna().to_numpy(), "give True or False")
    return values.astype(np.bool_)


def _refuse(path: Path, table: pd.DataFrame, name: str, wrong: np.ndarray, remedy: str) -> None:
    """Raise for the first wrong cell of a column; row 1 is the first below the header."""
    if wrong.any():
        row = int(np.argmax(wrong))
        raise InputError(f"{path}: column {name}, row {row + 1}: {table[name].iloc[row]!r}; {remedy}")
