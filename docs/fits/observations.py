"""Heading errors of every candidate, of the selection and of the oracle, one row per observation of finished runs."""

from collections.abc import Iterable
from pathlib import Path

import numpy as np
import pandas as pd

from luxloop.scenarios.metrics.definition import band
from luxloop.scenarios.metrics.definitions import POINT_BANDS, RANGE_BANDS, VIEWS
from luxloop.scenarios.run import run_folder
from luxloop.tracker.records import METHODS

SELECTED = ("best", "oracle")
KEY = ["frame", "actor_id"]
BANDS = {"range": ("range_m", RANGE_BANDS, "m"), "points": ("points", POINT_BANDS, "points")}
"""Column and bands of each grouping, and the unit in its names."""


def observations(folders: Iterable[Path]) -> pd.DataFrame:
    """Return the observations of all runs in folders."""
    return of_runs(run for folder in folders for run in run_folder.found_in(folder))


def of_runs(folders: Iterable[Path]) -> pd.DataFrame:
    """Return the observations of runs, one row each, with a selected rectangle.

    Columns: `run`, `scenario`, `frame`, `actor_id`, `vehicle` (number over all runs), `view`, `range`, `points`, the
    absolute error of each of `METHODS`, `best` and `oracle` [deg], NaN without a rectangle, and `deviation`, the
    error of the box over its standard deviation. Views are the kinds of `VIEWS`, or "none".
    """
    parts = [of_run(folder) for folder in folders]
    if not parts:
        return pd.DataFrame(columns=[*METHODS, *SELECTED])
    joined = pd.concat(parts, ignore_index=True)
    return joined.assign(vehicle=joined.groupby(["run", "actor_id"]).ngroup())


def of_run(folder: Path) -> pd.DataFrame:
    """Return the observations of one run, without `vehicle`."""
    result = run_folder.read(folder)
    fits = result.tables["fits"]
    errors = fits.assign(error=fits["heading_error_deg"].abs(), method=fits["method"].astype(str))
    wide = errors.pivot(index=KEY, columns="method", values="error").reindex(columns=[*METHODS])
    for name in SELECTED:
        wide[name] = errors[errors[name]].set_index(KEY)["error"]
    first = errors.drop_duplicates(KEY).set_index(KEY)
    for name, (column, bands, unit) in BANDS.items():
        wide[name] = in_band(first[column], bands, unit)
    wide["deviation"] = deviation(first)
    wide["view"] = first["view"].astype(str).str.replace("_", "-")
    wide["run"], wide["scenario"] = str(folder), result.scenario
    return wide[wide["best"].notna()].reset_index()


def deviation(fits: pd.DataFrame) -> pd.Series:
    """Return the absolute heading error of each observation's box in standard deviations; NaN without a box."""
    if "box_heading_std_deg" not in fits:  # a run of an earlier version
        return pd.Series(np.nan, fits.index)
    return fits["box_heading_error_deg"].abs() / fits["box_heading_std_deg"]


def in_band(values: pd.Series, bands: Iterable[str], unit: str) -> pd.Series:
    """Return the name of each value's band; empty outside all."""
    found = pd.Series("", values.index, dtype=object)
    for name in bands:
        low, high = band(name)
        found[(values >= low) & (values < high)] = label(name, unit)
    return found


def label(name: str, unit: str) -> str:
    """Return the name of a band in the tables: `0-15 m`, `100-up points`."""
    return f"{name}{'up' * name.endswith('-')} {unit}"


def groups(observed: pd.DataFrame) -> Iterable[tuple[str, pd.DataFrame]]:
    """Yield all observations, and those of each view and band, with their names."""
    yield "all", observed
    for view in VIEWS.values():
        name = view.replace("_", "-")
        yield name, observed[observed["view"] == name]
    for column, (_, bands, unit) in BANDS.items():
        for name in bands:
            yield label(name, unit), observed[observed[column] == label(name, unit)]
