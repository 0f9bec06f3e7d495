"""Tables of the tracks: scores, missed vehicles, false tracks and estimates, overall and by range, class and view."""

from collections.abc import Iterable

from rich.table import Table

from scenarios.grading import track_metric_names as names
from scenarios.grading.metric_definition import Definition
from scenarios.report.cells import table_of, value_of
from scenarios.report.tables import metric_rows
from scenarios.result import Result

TABLES: dict[str, tuple[Iterable[Definition], ...]] = {
    "Tracking": (names.SCORES, names.OCCLUSION),
    "Found and missed vehicles, false tracks": (names.CONFIRMATION, names.MISSED, names.FALSE, names.GOSPA),
    "Motion, heading and size of tracks": (names.MOTION, names.HEADING, names.SIZE),
}
"""Groups of metrics by the titles of their tables."""

COLUMNS = {
    "track.missed_share": "missed",
    "track.time_to_confirm_s": "confirm [s]",
    "track.gospa_m": "GOSPA [m]",
    "track.heading_abs_mean_deg": "heading [deg]",
    "track.heading_flip_rate": "flips",
    "track.moving_velocity_abs_mean_mps": "velocity [m/s]",
    "track.standing_speed_mean_mps": "standing [m/s]",
    "track.acceleration_abs_mean_mps2": "acceleration [m/s^2]",
    "track.length_mean_m": "length [m]",
    "track.length_abs_mean_m": "|length| [m]",
    "track.width_mean_m": "width [m]",
    "track.width_abs_mean_m": "|width| [m]",
}
"""Titles of the columns of banded metrics."""


def tracking(result: Result) -> list[Table]:
    """Return a table for each group of track metrics of the whole run."""
    return [
        metric_rows(title, result, [definition.name for group in groups for definition in group])
        for title, groups in TABLES.items()
    ]


def by_band(result: Result) -> Table:
    """Return the banded metrics by range, class and view, with the number of graded vehicles, summed over frames."""
    table = table_of("Tracks by range, class and view", "", *COLUMNS.values(), "n")
    for band in names.BANDS:
        metrics = [result.metrics[f"{name}.{band}"] for name in COLUMNS]
        kind, _, part = band.removeprefix("by_").partition(".")
        unit = " m" if kind == "range" else ""
        name = part.replace("_", "-" if kind == "range" else " ")
        table.add_row(f"{kind} {name}{unit}", *map(value_of, metrics), str(metrics[0].n))
    return table
