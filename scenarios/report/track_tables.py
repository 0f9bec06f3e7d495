"""Tables of the tracks: scores, missed vehicles, false tracks and estimates, overall and by range, class and view."""

from collections.abc import Mapping

from luxloop.scenarios.document.table import Table
from luxloop.scenarios.metrics.definition import filtered
from luxloop.scenarios.metrics.definitions import REPORTED_BANDS
from luxloop.scenarios.report.cells import table_of, value_of
from luxloop.scenarios.report.tables import metric_rows
from luxloop.scenarios.result import Result

TABLES: dict[str, tuple[str, ...]] = {
    "Tracking": (
        *("hota", "deta", "assa", "loca", "mota", "motp", "idf1"),
        *("id_switches", "id_switch_rate", "id_switches_in_view", "fragments", "missed", "false"),
        *("occlusion_survival", "hidden_2s_survival", "reacquire_s", "reappearance_error_m"),
    ),
    "Found and missed vehicles, false tracks": (
        *("time_to_confirm_s", "time_to_confirm_p90_s", "never_confirmed"),
        *("missed_share", "missed_share_standing", "missed_share_long"),
        *("false_on_nothing", "false_ill_fitting", "false_duplicate", "false_share"),
        *("gospa_m", "gospa_localisation_m2", "gospa_missed_m2", "gospa_false_m2"),
    ),
    "Motion, track heading and size": (
        *("position_abs_mean_m", "iou_mean", "orientation_abs_mean_deg"),
        *("velocity_abs_mean_mps", "moving_velocity_abs_mean_mps", "standing_speed_mean_mps", "speed_abs_mean_mps"),
        *("speed_mean_mps", "acceleration_abs_mean_mps2"),
        *("heading_abs_mean_deg", "heading_abs_p90_deg", "heading_flip_rate", "heading_unflipped_mean_deg"),
        *("standing_heading_abs_mean_deg", "standing_flip_rate"),
        *("length_mean_m", "length_abs_mean_m", "width_mean_m", "width_abs_mean_m"),
    ),
}
"""Metrics of tracks by the titles of their tables."""

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
    """Return a table for each group of track metrics of the whole run, and one of those that no group has."""
    groups = {title: [f"track.{name}" for name in names] for title, names in TABLES.items()}
    listed = {name for names in groups.values() for name in names}
    others = [name for name in result.metrics if name.startswith("track.") and "{" not in name and name not in listed]
    return [metric_rows(title, result, names) for title, names in [*groups.items(), ("Others", others)] if names]


def by_band(result: Result) -> list[Table]:
    """Return tables of the banded metrics by range, class and view, with the observations of the first of them."""
    return [_by_band(title, columns, result) for title, columns in BANDED_TABLES.items()]


def _by_band(title: str, columns: Mapping[str, str], result: Result) -> Table:
    table = table_of(title, "", *columns.values(), "n")
    for band in REPORTED_BANDS:
        metrics = [result.metrics[filtered(name, **band)] for name in columns]
        table.add_row(band_label(band), *map(value_of, metrics), str(metrics[0].n))
    return table


def band_label(band: Mapping[str, str]) -> str:
    """Return the text of a filter: `range 0-15 m`, `class bus`, `view l shape`."""
    ((key, value),) = band.items()
    return f"{key} {value} m" if key == "range" else f"{key} {value.replace('_', ' ')}"
