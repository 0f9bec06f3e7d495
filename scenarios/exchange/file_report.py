"""Printed report of a grading of files: the tables of a run's report that apply to them."""

from collections.abc import Iterable, Mapping
from dataclasses import asdict

from rich.console import Group, RenderableType
from rich.padding import Padding
from rich.table import Table
from rich.text import Text

from luxloop.scenarios.exchange.graded_boxes import BANDED, GradedBoxes, bands
from luxloop.scenarios.exchange.paired_frames import BoxLimits
from luxloop.scenarios.metrics.definitions import find_metric
from luxloop.scenarios.report.cells import counted, interval_of, table_of, value_of
from luxloop.scenarios.report.track_tables import band_label
from luxloop.scenarios.result import Metric, Result

TABLES = {
    "Tracking": ("score",),
    "Found and missed objects": ("vehicle", "confirmation"),
    "GOSPA": ("gospa",),
    "Averages over recalls, as nuScenes": ("recall",),
    "Errors of pairs": ("track",),
    "Boxes": ("dataset",),
}
"""Titles of the tables, and the kinds of their metrics."""
COLUMNS = ("HOTA", "MOTA", "missed", "false", "GOSPA [m]", "position [m]", "heading [deg]", "velocity [m/s]")
"""Titles of the columns of `BANDED`."""


def report(graded: GradedBoxes) -> Group:
    """Return the printed grading."""
    sections: list[RenderableType] = [
        _header(graded),
        *(Text(f"Warning: {warning}", style="yellow") for warning in graded.result.warnings),
        *tables(graded.result),
        _limits(graded.limits),
    ]
    return Group(*(Padding(section, (0, 0, 1, 0), expand=False) for section in sections))


def tables(result: Result) -> list[Table]:
    """Return a table for each group of metrics, and those by class and range."""
    known = [name for name, metric in result.metrics.items() if metric.value is not None]
    names = {title: [name for name in known if _kind(name) in kinds] for title, kinds in TABLES.items()}
    found = [figure_rows(title, result.metrics, rows) for title, rows in names.items() if rows]
    return [*found, *by_band(result), *_without(result)]


def figure_rows(title: str, metrics: Mapping[str, Metric], names: Iterable[str]) -> Table:
    """Return a table with a row for each metric: value, 95 % interval, observations and meaning."""
    table = table_of(title, "metric", "value", "95 %", "n")
    table.add_column("", style="dim")
    for name in names:
        metric = metrics[name]
        meaning = metric.reason or find_metric(name).meaning
        table.add_row(name, value_of(metric), interval_of(metric), str(metric.n), meaning)
    return table


def _without(result: Result) -> list[Table]:
    """Return the table of the metrics without a value, by the reason."""
    reasons: dict[str, list[str]] = {}
    for name, metric in result.metrics.items():
        if metric.value is None:
            reasons.setdefault(metric.reason, []).append(name)
    table = table_of("Metrics without a value", "reason")
    table.add_column("metrics", style="dim")
    for reason, names in reasons.items():
        table.add_row(reason, ", ".join(names))
    return [table] if reasons else []


def by_band(result: Result) -> list[Table]:
    """Return the table by class and by range; none if the files have neither."""
    filters = bands(result)
    if not filters:
        return []
    table = table_of("By class and range", "", *COLUMNS, "n")
    for band in filters:
        metrics = [result.metrics.where(name, **band) for name in BANDED]
        table.add_row(band_label(band), *map(value_of, metrics), str(metrics[0].n))
    return [table]


def _kind(name: str) -> str:
    return find_metric(name).definition.kind


def _header(graded: GradedBoxes) -> Text:
    pairs = graded.pairs
    of = f", classes {', '.join(graded.classes)}" if graded.classes else ""
    return Text(
        f"{pairs.tracks.source} against {pairs.truth.source}\n"
        f"{counted(graded.result.frames, 'frame')}, {counted(graded.true_boxes, 'true box', 'true boxes')}, "
        f"{counted(graded.track_boxes, 'box', 'boxes')} of tracks{of}"
    )


def _limits(limits: BoxLimits) -> Text:
    given = {name: value for name, value in asdict(limits).items() if value is not None}
    return Text("Graded with " + ", ".join(f"{name} = {value:g}" for name, value in given.items()), style="dim")
