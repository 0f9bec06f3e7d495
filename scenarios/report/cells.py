"""Tables and formatted values of printed reports."""

from rich import box
from rich.console import Console, ConsoleOptions, RenderableType, RenderResult
from rich.measure import Measurement
from rich.table import Table
from rich.text import Text

from luxloop.scenarios.files.expect import Check
from luxloop.scenarios.result import Metric

NONE = "n/a"
"""Shown for a metric without a value."""
MOST_DIGITS = 9
"""Most decimals that show the difference between a value and its limit."""


class ReportTable(Table):
    """Table that wraps and folds its cells on narrow lines; rich would end them in ellipses."""

    def __rich_measure__(self, console: Console, options: ConsoleOptions) -> Measurement:
        """Return the width in which no cell is folded, as the minimum."""
        needed = self._needed_width(console, options)
        return Measurement(needed, max(needed, super().__rich_measure__(console, options).maximum))

    def __rich_console__(self, console: Console, options: ConsoleOptions) -> RenderResult:
        """Allow breaks in all columns if the line is too short for those that should stay on one line."""
        if self._needed_width(console, options) > options.max_width:
            for column in self.columns:
                column.no_wrap = False
        for column in self.columns:
            column.overflow = "fold"
        yield from super().__rich_console__(console, options)

    def _needed_width(self, console: Console, options: ConsoleOptions) -> int:
        """Return the width of lines on which columns without breaks are whole, and words of the others, too."""
        unlimited = options.update(max_width=10_000)

        def width(cell: RenderableType, no_wrap: bool) -> int:
            measured = Measurement.get(console, unlimited, cell)
            return measured.maximum if no_wrap else measured.minimum

        widest = [
            max(width(cell, column.no_wrap) for cell in (column.header, *column.cells)) for column in self.columns
        ]
        _, right, _, left = self.padding
        return sum(widest) + (len(widest) - 1) * (right + left + (1 if self.box else 0))


def table_of(title: str, first_column: str, *number_columns: str) -> Table:
    """Return an empty table with a column of names and columns of numbers."""
    # The title is a Text, because rich would parse [deg] in a plain string as a style.
    table = ReportTable(
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
