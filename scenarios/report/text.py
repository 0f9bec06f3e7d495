"""Documents and other reports on standard output, in files, logs and notebooks."""

import io
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from rich.console import RenderableType
from rich.measure import Measurement

from luxloop.console import PrintableConsole
from luxloop.scenarios.document import html
from luxloop.scenarios.document.document import Document, Section
from luxloop.scenarios.files.expect import ranked
from luxloop.scenarios.metrics.main_figures import OF_RUNS
from luxloop.scenarios.report.cells import interval_of, table_of, with_unit
from luxloop.scenarios.report.html.reported_run import ReportedRun, answer
from luxloop.scenarios.report.run_document import expectations, run_document
from luxloop.scenarios.result import Result

if TYPE_CHECKING:
    from collections.abc import Sequence

    from luxloop.scenarios.files.expect import Check


WIDTH = 100
"""Smallest line width without a terminal [characters]."""


def report(result: Result, checks: "Sequence[Check]") -> "Document":
    """Return the printed report of a run, the verdict first."""
    return run_document(ReportedRun(result.out or Path(), result, list(checks), {}))


def show(report: RenderableType, text: str | None = None) -> None:
    """Print on standard output, in colour on a terminal, else the text of `as_text` if it is known already."""
    console = PrintableConsole(markup=False, emoji=False)
    if text is not None and not console.is_terminal and console.encoding == "utf-8":
        console.out(text, end="", highlight=False)
    else:
        PrintableConsole(width=None if sys.stdout.isatty() else _width(report), markup=False, emoji=False).print(report)


def as_text(report: RenderableType) -> str:
    """Return the report as text without colours, for a file."""
    text = io.StringIO()
    PrintableConsole(file=text, width=_width(report), color_system=None, markup=False, emoji=False).print(report)
    return text.getvalue()


def _width(report: RenderableType) -> int:
    """Return the line width of a log or a file, in which no cell of a table is broken."""
    console = PrintableConsole(markup=False, emoji=False)
    return max(WIDTH, Measurement.get(console, console.options.update(max_width=10_000), report).minimum)


def result_html(result: Result) -> str:
    """Return the verdict, the expectations that do not hold, and the main metrics as HTML."""
    unmet = [check for check in ranked(result.checks) if not check.holds]
    named = {check.name for check in unmet}
    main = table_of("Main metrics", "metric", "value", "95 %")
    for name in OF_RUNS:
        if name in result.metrics and name not in named:
            main.add_row(name, with_unit(result.metrics[name]), interval_of(result.metrics[name]))
    title = f"{result.scenario}, seed {result.seed}, {result.frames} frames"
    tables = [*([expectations(unmet)] if unmet else []), main]
    return html.fragment(Document(title, answer(result, result.checks), [], [Section("metrics", "Metrics", tables)]))
