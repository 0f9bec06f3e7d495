"""Printed table of people and riders."""

from luxloop.scenarios.document.table import Table
from luxloop.scenarios.metrics.definitions import GROUPS, VULNERABLE_COUNTS, VULNERABLE_SCORES
from luxloop.scenarios.report.cells import table_of, value_of
from luxloop.scenarios.result import Result

ERRORS = {
    "missed_share": "missed, share",
    "called_vehicle_share": "called a vehicle, share",
    "position_abs_mean_m": "position |e| [m]",
    "velocity_abs_mean_mps": "velocity |e| [m/s]",
    "speed_abs_mean_mps": "speed |e| [m/s]",
    "time_to_confirm_s": "time to confirm, median [s]",
    "never_confirmed": "never confirmed, share",
}
"""Titles of the rows of errors by the names of metrics."""


def vulnerable(result: Result) -> list[Table]:
    """Return a table of people and riders; none for a run without them."""
    if not any(_observations(result, group) for group in GROUPS):
        return []
    table = table_of("People and riders", "metric", *GROUPS)
    scores = {name: name.replace("_", " ") for name in (*VULNERABLE_SCORES, *VULNERABLE_COUNTS)}
    rows = {"observations": "observations"} | scores | ERRORS
    for name, title in rows.items():
        metrics = [result.metrics[f"{group}.{name}"] for group in GROUPS]
        table.add_row(title, *map(value_of, metrics))
    return [table]


def _observations(result: Result, group: str) -> float:
    metric = result.metrics.get(f"{group}.observations")
    return (metric.value if metric else None) or 0.0
