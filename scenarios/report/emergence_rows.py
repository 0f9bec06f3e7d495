"""Printed table of the target's emergence."""

from luxloop.scenarios.document.table import Table
from luxloop.scenarios.metrics.definitions import STAGES
from luxloop.scenarios.report.cells import table_of, value_of
from luxloop.scenarios.result import Result

HEADS = {
    "time_s": "time [s]",
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
    table = table_of(f"Emergence of {target}", "", *HEADS.values())
    for stage in STAGES:
        metrics = [result.metrics[f"emergence.{name}{{stage={stage}}}"] for name in HEADS]
        table.add_row(stage.replace("_", " "), *(value_of(metric, 2) for metric in metrics))
    return [table]
