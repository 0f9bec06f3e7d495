"""What the tables of a report are made of."""

from rich import box
from rich.table import Table
from rich.text import Text

from scenarios.result import Metric

NONE = "n/a"
"""Stands where a metric does not apply."""


def table_of(title: str, first_column: str, *number_columns: str) -> Table:
    """Return an empty table: one column of names, others of numbers."""
    # A title goes in as Text: in plain strings rich would take [deg] for a style.
    table = Table(
        title=Text(title, style="bold"), title_justify="left", box=box.SIMPLE_HEAD, show_edge=False, pad_edge=False
    )
    table.add_column(first_column, no_wrap=True)
    for column in number_columns:
        table.add_column(column, justify="right", no_wrap=True)
    return table


def value_of(metric: Metric, digits: int = 3) -> str:
    """The value, with as many decimals as make sense."""
    if metric.value is None:
        return NONE
    return f"{metric.value:.0f}" if metric.unit == "count" else f"{metric.value:.{digits}f}"


def unit_of(metric: Metric) -> str:
    """The unit behind a value, with the space between; nothing for shares and counts."""
    return "" if metric.unit in ("1", "count") else f" {metric.unit}"


def percent_of(metric: Metric) -> str:
    """A share."""
    return NONE if metric.value is None else f"{metric.value:.1%}"


def interval_of(metric: Metric, *, percent: bool = False) -> str:
    """The 95 % interval, nothing where there is none."""
    if metric.interval is None:
        return ""
    low, high = metric.interval
    return f"{100 * low:.0f}-{100 * high:.0f}" if percent else f"{low:.3f}-{high:.3f}"
