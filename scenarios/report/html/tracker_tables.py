"""Tables with a column for each of several trackers."""

from collections.abc import Iterable, Mapping

from luxloop.scenarios.metrics.definition import filtered
from luxloop.scenarios.metrics.definitions import REPORTED_BANDS
from luxloop.scenarios.report.html.page_tables import Cell, PageTable, Row
from luxloop.scenarios.report.html.reported_run import SUITE_METRICS, ReportedRun, interval, with_unit
from luxloop.scenarios.report.track_tables import BANDED_TABLES, TABLES, band_label
from luxloop.scenarios.result import Metric

LIMITED = "Expectations, with the outcome"
NO_METRIC = Metric(None, "", 0, "the run does not have this metric")


def tables(runs: Mapping[str, ReportedRun]) -> list[PageTable]:
    """Return the main metrics, the expectations, and the metrics of the tracks over the whole run."""
    return [
        _metrics("Main metrics", runs, dict(SUITE_METRICS)),
        _expectations(runs),
        *(
            _metrics(title, runs, {f"track.{name}": f"track.{name}" for name in names})
            for title, names in TABLES.items()
        ),
    ]


def band_tables(runs: Mapping[str, ReportedRun]) -> list[PageTable]:
    """Return a table by range, class and view for each metric that has these."""
    names = [name for columns in BANDED_TABLES.values() for name in columns]
    found = []
    for name in names:
        rows = {filtered(name, **band): band_label(band) for band in REPORTED_BANDS}
        found.append(_metrics(name, runs, rows))
    return found


def _metrics(title: str, runs: Mapping[str, ReportedRun], rows: Mapping[str, str]) -> PageTable:
    """Return values with 95 % intervals; `rows` are the labels by metric."""
    lines = [
        [label, *(_value(run.result.metrics.get(name, NO_METRIC)) for run in runs.values())]
        for name, label in rows.items()
    ]
    return _table(title, ["metric", *runs], lines)


def _expectations(runs: Mapping[str, ReportedRun]) -> PageTable:
    names = list(dict.fromkeys(check.name for run in runs.values() for check in run.ranked))
    lines = []
    for name in names:
        checks = [{check.name: check for check in run.checks}.get(name) for run in runs.values()]
        limit = next(str(check.limit) for check in checks if check)
        cells = [f"{with_unit(check.metric)}: {check.outcome}" if check else "not expected" for check in checks]
        lines.append([f"{name} {limit}", *cells])
    return _table(LIMITED, ["expectation", *runs], lines)


def _value(metric: Metric) -> str:
    spread = interval(metric)
    return f"{with_unit(metric)} ({spread})" if spread else with_unit(metric)


def _table(title: str, head: Iterable[str], lines: Iterable[Iterable[str]]) -> PageTable:
    def cells(texts: Iterable[str]) -> list[Cell]:
        return [Cell(text, right=place > 0) for place, text in enumerate(texts)]

    return PageTable(title, cells(head), [Row(cells(line), "") for line in lines])
