"""Fits to labelled vehicles: the errors of each source side by side, as a document."""

from collections.abc import Iterator, Mapping
from statistics import NormalDist
from typing import Any

import numpy as np
import pandas as pd

from luxloop.arrays import Floats, Ints
from luxloop.scenarios.document.document import Answer, Document, Section, Table
from luxloop.scenarios.realism.fit_observations import VIEWS, range_bands
from luxloop.scenarios.realism.labelled_fits import COMPARED
from luxloop.scenarios.report.cells import NONE, table_of
from luxloop.scenarios.statistics.intervals import Interval
from luxloop.scenarios.statistics.jackknife import ANY, POSITIVE, SHARE, ratio_interval

METHODS = (*COMPARED, "best", "oracle")
BY_GROUP = ("best", "alignment", "tlinkage", "oracle")
"""Methods that are reported by view and range."""
PERCENTS = (50, 90, 99)
"""Central intervals of the stated deviation."""

Groups = Mapping[str, pd.DataFrame]
"""Observations by the name of their source, of `fit_observations.observations`."""
Figure = tuple[float, Interval | None]
"""Value with its 95 % interval over vehicles, None for too few."""


def document(groups: Groups) -> Document:
    """Return the errors of each source side by side."""
    tables = [
        _table("Mean absolute heading error [deg], and per vehicle", groups, _means(groups)),
        _table("Error of best minus error of the method [deg]", groups, _differences(groups)),
        _table(f"By view and range: {' | '.join(BY_GROUP)} [deg]", groups, _parts(groups)),
        _table("Share of true headings in the stated intervals [%]", groups, _coverage(groups)),
    ]
    errors = "; ".join(_sentence(name, rows) for name, rows in groups.items())
    answer = Answer(f"Mean heading error of the selected fits, beside that of T-linkage: {errors}")
    data = {"sources": {name: _entry(rows) for name, rows in groups.items()}}
    return Document("Fits to labelled vehicles", answer, [], [Section("errors", "Errors", tables)], data)


def _sentence(name: str, rows: pd.DataFrame) -> str:
    best, tlinkage = (rows[method].mean() for method in ("best", "tlinkage"))
    return f"{best:.2f} and {tlinkage:.2f} deg on {name}"


def _entry(rows: pd.DataFrame) -> dict[str, Any]:
    return {
        "clusters": len(rows),
        "vehicles": int(rows["vehicle"].nunique()),
        "error_deg": {method: mean(rows, rows[method]) for method in METHODS},
        "error_by_vehicle_deg": {method: mean_by_vehicle(rows, rows[method]) for method in METHODS},
        "best_minus_deg": {method: mean(rows, rows["best"] - rows[method]) for method in METHODS if method != "best"},
        "by_view_or_range_deg": {
            name: {"clusters": len(part), **{method: float(part[method].mean()) for method in BY_GROUP}}
            for name, part in parts(rows)
            if len(part)
        },
        "coverage_percent": {str(percent): covered(rows, percent) for percent in PERCENTS},
    }


def mean(rows: pd.DataFrame, values: pd.Series) -> Figure:
    """Return the mean per cluster."""
    number = values.to_numpy(np.float64)
    within = POSITIVE if (number >= 0.0).all() else ANY
    return float(number.mean()), _interval(rows["vehicle"].to_numpy(), number, within)


def mean_by_vehicle(rows: pd.DataFrame, values: pd.Series) -> Figure:
    """Return the mean of the means of each vehicle."""
    means = values.groupby(rows["vehicle"]).mean().to_numpy()
    return float(means.mean()), _interval(np.arange(len(means)), means, POSITIVE)


def covered(rows: pd.DataFrame, percent: int) -> Figure:
    """Return the percentage of true headings inside the central interval that the fits state."""
    stated = rows[rows["deviation"].notna()]
    inside = (stated["deviation"] <= NormalDist().inv_cdf(0.5 + 0.005 * percent)).to_numpy(np.float64)
    if not len(inside):
        return float("nan"), None
    limits = _interval(stated["vehicle"].to_numpy(), inside, SHARE)
    return 100.0 * float(inside.mean()), limits and (100.0 * limits[0], 100.0 * limits[1])


def parts(rows: pd.DataFrame) -> Iterator[tuple[str, pd.DataFrame]]:
    """Yield the observations of each view and range band."""
    for column, names in (("view", VIEWS), ("range", range_bands())):
        for name in names:
            yield name, rows[rows[column] == name]


def _interval(vehicle: Ints, values: Floats, within: Interval) -> Interval | None:
    return ratio_interval(vehicle, values, np.ones_like(values), within)


Rows = Iterator[tuple[str, list[str]]]
"""Name and cells of each row."""


def _means(groups: Groups) -> Rows:
    yield "clusters / vehicles", [f"{len(rows)} / {rows['vehicle'].nunique()}" for rows in groups.values()]
    for method in METHODS:
        yield method, [_both_means(rows, rows[method]) for rows in groups.values()]


def _both_means(rows: pd.DataFrame, values: pd.Series) -> str:
    return f"{_cell(mean(rows, values))}, {_cell(mean_by_vehicle(rows, values))}"


def _differences(groups: Groups) -> Rows:
    for method in METHODS:
        if method != "best":
            yield method, [_cell(mean(rows, rows["best"] - rows[method]), sign="+") for rows in groups.values()]


def _parts(groups: Groups) -> Rows:
    columns = [dict(parts(rows)) for rows in groups.values()]
    for name in columns[0]:
        yield name, [_errors(column[name]) for column in columns]


def _errors(rows: pd.DataFrame) -> str:
    errors = " | ".join(f"{rows[method].mean():.2f}" for method in BY_GROUP)
    return f"{errors} (n = {len(rows)})" if len(rows) else NONE


def _coverage(groups: Groups) -> Rows:
    for percent in PERCENTS:
        yield f"{percent} %", [_cell(covered(rows, percent), digits=0) for rows in groups.values()]


def _cell(figure: Figure, digits: int = 2, sign: str = "") -> str:
    value, limits = figure
    if np.isnan(value):
        return NONE
    shown = f"{value:{sign}.{digits}f}"
    return f"{shown} [{limits[0]:{sign}.{digits}f}, {limits[1]:{sign}.{digits}f}]" if limits else shown


def _table(title: str, groups: Groups, rows: Rows) -> Table:
    table = table_of(title, "", *groups)
    for name, cells in rows:
        table.add_row(name, *cells)
    return table
