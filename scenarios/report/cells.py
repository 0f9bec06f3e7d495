"""Tables and formatted values of reports."""

from luxloop.scenarios.document.document import Table
from luxloop.scenarios.files.expect import Check
from luxloop.scenarios.result import Metric

NONE = "n/a"
"""Shown for a metric without a value."""
MOST_DIGITS = 9
"""Most decimals that show the difference between a value and its limit."""


def table_of(title: str, first_column: str, *number_columns: str) -> Table:
    """Return an empty table with a column of names and columns of numbers."""
    found = Table(title)
    found.add_column(first_column, no_wrap=True)
    for column in number_columns:
        found.add_column(column, justify="right", no_wrap=True)
    return found


def value_of(metric: Metric, digits: int = 3) -> str:
    """Format the value: counts without decimals, others with `digits`."""
    if metric.value is None:
        return NONE
    return f"{metric.value:.0f}" if metric.unit == "count" else f"{metric.value:.{digits}f}"


def exceeded(check: Check) -> str:
    """Return the value beside the limit that it is beyond, e.g. `0.610 < 0.7`, with digits that show the difference."""
    value, limit = check.metric.value, check.limit
    if value is None:
        return f"{NONE}, not {limit}"
    below = limit.min is not None and value < limit.min
    end = limit.min if below else limit.max
    digits = 3
    while digits < MOST_DIGITS and float(value_of(check.metric, digits)) == end:
        digits += 1
    return f"{value_of(check.metric, digits)} {'<' if below else '>'} {end:g}"


def unit_of(metric: Metric) -> str:
    """Return the unit with a leading space, or nothing for shares and counts."""
    return "" if metric.unit in ("1", "count") else f" {metric.unit}"


def with_unit(metric: Metric) -> str:
    """Format the value with its unit."""
    return value_of(metric) + ("" if metric.value is None else unit_of(metric))


def percent_of(metric: Metric) -> str:
    """Format a share in percent."""
    return NONE if metric.value is None else f"{metric.value:.1%}"


def interval_of(metric: Metric, *, percent: bool = False) -> str:
    """Format the 95 % interval; without one the reason, empty for figures that never have any."""
    if metric.interval is None:
        return metric.why_no_interval
    low, high = metric.interval
    return f"{100 * low:.0f}-{100 * high:.0f}" if percent else f"{low:.3f}{'-' if low >= 0.0 else ' to '}{high:.3f}"


def counted(number: int, one: str, many: str | None = None) -> str:
    """Return a number and its noun; by default the plural of `one` has an s."""
    return f"{number} {one if number == 1 else many or one + 's'}"
