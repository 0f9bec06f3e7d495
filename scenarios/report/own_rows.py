"""Table of the metrics of a scenario file."""

from luxloop.scenarios.document.table import Table
from luxloop.scenarios.metrics.own_metric import OwnMetric
from luxloop.scenarios.report.cells import interval_of, table_of, unit_of, value_of
from luxloop.scenarios.result import Result


def own_metrics(result: Result) -> list[Table]:
    """Return a table with a row for each `[[metric]]`: value with unit, 95 % interval and meaning; none without any."""
    defined = [OwnMetric.model_validate(metric) for metric in result.config.get("metric", [])]
    if not defined:
        return []
    table = table_of("Metrics of the scenario", "metric", "value", "95 %", "n")
    table.add_column("", style="dim")
    for one in defined:
        metric = result.metrics[one.name]
        unit = "" if metric.value is None else unit_of(metric)
        meaning = metric.reason or one.definition.meaning
        table.add_row(one.name, f"{value_of(metric)}{unit}", interval_of(metric), str(metric.n), meaning)
    return [table]
