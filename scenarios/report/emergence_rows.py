"""Printed table of the target's emergence."""

from rich.table import Table

from luxloop.scenarios.grading.emergence_names import MEASURES, STAGES, TARGET
from luxloop.scenarios.report.cells import table_of, value_of
from luxloop.scenarios.result import Result

HEADS = {
    "s": "time [s]",
    "delay_s": "since beam [s]",
    "range_m": "range [m]",
    "ttc_s": "collision in [s]",
    "meeting_m": "meeting in [m]",
    "meeting_s": "[s]",
}
"""Title of the column of each measure."""


def emergence(result: Result) -> list[Table]:
    """Return a table with the moments of the target's emergence; none without `grading.target`."""
    target = result.config["grading"].get("target", "")
    if not target:
        return []
    table = table_of(f"Emergence of {target}", "", *(HEADS[name] for name in MEASURES))
    for stage in STAGES:
        metrics = [result.metrics[f"emergence.{TARGET}.{stage}_{name}"] for name in MEASURES]
        table.add_row(stage.replace("_", " "), *(value_of(metric, 2) for metric in metrics))
    return [table]
