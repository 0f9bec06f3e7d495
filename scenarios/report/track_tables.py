"""Tables of the tracks: scores, missed vehicles, false tracks and estimates, overall and by range, class and view."""

from collections.abc import Iterable, Mapping

from rich.table import Table

from luxloop.scenarios.grading import track_metric_names as names
from luxloop.scenarios.grading.metric_definition import Definition
from luxloop.scenarios.report.cells import table_of, value_of
from luxloop.scenarios.report.tables import metric_rows
from luxloop.scenarios.result import Result

TABLES: dict[str, tuple[Iterable[Definition], ...]] = {
    "Tracking": (names.SCORES, names.OCCLUSION),
    "Found and missed vehicles, false tracks": (names.CONFIRMATION, names.MISSED, names.FALSE, names.GOSPA),
    "Motion, track heading and size": (names.MOTION, names.HEADING, names.SIZE),
}
"""Groups of metrics by the titles of their tables."""

BANDED_TABLES = {
    "Missed vehicles and sizes by range, class and view": {
        "track.missed_share": "missed",
        "track.time_to_confirm_s": "confirm [s]",
        "track.gospa_m": "GOSPA [m]",
        "track.length_mean_m": "length [m]",
        "track.length_abs_mean_m": "|e|",
        "track.width_mean_m": "width [m]",
        "track.width_abs_mean_m": "|e|",
    },
    "Motion and track heading by range, class and view [m/s, m/s^2, deg]": {
        "track.moving_velocity_abs_mean_mps": "velocity",
        "track.standing_speed_mean_mps": "standing",
        "track.acceleration_abs_mean_mps2": "acceleration",
        "track.heading_abs_mean_deg": "track heading",
        "track.heading_flip_rate": "flips",
    },
}
"""Titles of the columns by banded metric, for each table by its title."""


def tracking(result: Result) -> list[Table]:
    """Return a table for each group of track metrics of the whole run."""
    return [
        metric_rows(title, result, [definition.name for group in groups for definition in group])
        for title, groups in TABLES.items()
    ]


def by_band(result: Result) -> list[Table]:
    """Return tables of the banded metrics by range, class and view, with the observations of the first of them."""
    return [_by_band(title, columns, result) for title, columns in BANDED_TABLES.items()]


def _by_band(title: str, columns: Mapping[str, str], result: Result) -> Table:
    table = table_of(title, "", *columns.values(), "n")
    for band in names.BANDS:
        metrics = [result.metrics[f"{name}.{band}"] for name in columns]
        kind, _, part = band.removeprefix("by_").partition(".")
        name = f"{part.replace('_', '-')} m" if kind == "range" else part.replace("_", " ")
        table.add_row(f"{kind} {name}", *map(value_of, metrics), str(metrics[0].n))
    return table
