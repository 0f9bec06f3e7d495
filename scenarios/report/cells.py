"""Tables and formatted values of printed reports."""

from rich import box
from rich.table import Table
from rich.text import Text

from scenarios.result import Metric

NONE = "n/a"
"""Shown for a metric without a value."""


def table_of(title: str, first_column: str, *number_columns: str) -> Table:
    """Return an empty table with a column of names and columns of numbers."""
    # The title is a Text, because rich would parse [deg] in a plain string as a style.
    table = Table(
        title=Text(title, style="bold"), title_justify="left", box=box.SIMPLE_HEAD, show_edge=False, pad_edge=False
    )
    table.add_column(first_column, no_wrap=True)
    for column in number_columns:
        table.add_column(column, justify="right", no_wrap=True)
    return table


def value_of(metric: Metric, digits: int = 3) -> str:
    """Format the value: counts without decimals, others with `digits`."""
    if metric.value is None:
        return NONE
    return f"{metric.value:.0f}" if metric.unit == "count" else f"{metric.value:.{digits}f}"


def unit_of(metric: Metric) -> str:
    """Return the unit with a leading space, or nothing for shares and counts."""
    return "" if metric.unit in ("1", "count") else f" {metric.unit}"


def percent_of(metric: Metric) -> str:
    """Format a share in percent."""
    return NONE if metric.value is None else f"{metric.value:.1%}"


def interval_of(metric: Metric, *, percent: bool = False) -> str:
    """Format the 95 % interval; empty without one."""
    if metric.interval is None:
        return ""
    low, high = metric.interval
    return f"{100 * low:.0f}-{100 * high:.0f}" if percent else f"{low:.3f}{'-' if low >= 0.0 else ' to '}{high:.3f}"
