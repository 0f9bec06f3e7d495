"""Tables with a column for each of several trackers."""

from collections.abc import Mapping

from luxloop.scenarios.document.table import Table
from luxloop.scenarios.document.words import Span, Words
from luxloop.scenarios.files.expect import Check
from luxloop.scenarios.metrics.definition import filtered
from luxloop.scenarios.metrics.definitions import REPORTED_BANDS
from luxloop.scenarios.report.cells import interval_of, table_of, with_unit
from luxloop.scenarios.report.html.reported_run import SUITE_METRICS, ReportedRun
from luxloop.scenarios.report.run_answer import OUTCOMES
from luxloop.scenarios.report.track_tables import BANDED_TABLES, TABLES, band_label
from luxloop.scenarios.result import Metric

LIMITED = "Expectations, with the outcome"
NO_METRIC = Metric(None, "", 0, "the run does not have this metric")


def tables(runs: Mapping[str, ReportedRun]) -> list[Table]:
    """Return the main metrics, the expectations, and the metrics of the tracks over the whole run."""
    return [
        _metrics("Main metrics", runs, dict(SUITE_METRICS)),
        _expectations(runs),
        *(
            _metrics(title, runs, {f"track.{name}": f"track.{name}" for name in names})
            for title, names in TABLES.items()
        ),
    ]


def band_tables(runs: Mapping[str, ReportedRun]) -> list[Table]:
    """Return a table by range, class and view for each metric that has these."""
    names = [name for columns in BANDED_TABLES.values() for name in columns]
    found = []
    for name in names:
        rows = {filtered(name, **band): band_label(band) for band in REPORTED_BANDS}
        found.append(_metrics(name, runs, rows))
    return found


def _metrics(title: str, runs: Mapping[str, ReportedRun], rows: Mapping[str, str]) -> Table:
    """Return values with 95 % intervals; `rows` are the labels by metric."""
    table = table_of(title, "metric", *runs)
    for name, label in rows.items():
        table.add_row(label, *(_value(run.result.metrics.get(name, NO_METRIC)) for run in runs.values()))
    return table


def _expectations(runs: Mapping[str, ReportedRun]) -> Table:
    table = table_of(LIMITED, "expectation", *runs)
    for name in dict.fromkeys(check.name for run in runs.values() for check in run.ranked):
        checks = [{check.name: check for check in run.checks}.get(name) for run in runs.values()]
        limit = next(str(check.limit) for check in checks if check)
        table.add_row(f"{name} {limit}", *map(_outcome, checks))
    return table


def _outcome(check: Check | None) -> Words:
    if check is None:
        return "not expected"
    return f"{with_unit(check.metric)}: ", Span(check.outcome, OUTCOMES[check.outcome])


def _value(metric: Metric) -> str:
    spread = interval_of(metric)
    return f"{with_unit(metric)} ({spread})" if spread else with_unit(metric)
