"""Documents and other reports on standard output, in files, logs and notebooks."""

import shutil
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from luxloop.printable import is_terminal
from luxloop.scenarios.document import terminal
from luxloop.scenarios.document.document import Document, Section, Table
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


def show(shown: Document | Table) -> None:
    """Print on standard output: in colour and as wide as the terminal, else as `as_text`."""
    width = shutil.get_terminal_size().columns if is_terminal(sys.stdout) else _width(shown)
    terminal.print_lines(terminal.lines(shown, width))


def as_text(shown: Document | Table) -> str:
    """Return the report as text without colours, for a file."""
    return "".join(f"{line.plain}\n" for line in terminal.lines(shown, _width(shown)))


def _width(shown: Document | Table) -> int:
    """Return the line width of a log or a file, in which no cell of a table is broken."""
    return max(WIDTH, terminal.narrowest(shown))


def result_html(result: Result) -> str:
    """Return the verdict, the expectations that do not hold, and the main metrics as HTML."""
    from luxloop.scenarios.document import html  # slow, and most runs are not shown in a notebook

    unmet = [check for check in ranked(result.checks) if not check.holds]
    named = {check.name for check in unmet}
    main = table_of("Main metrics", "metric", "value", "95 %")
    for name in OF_RUNS:
        if name in result.metrics and name not in named:
            main.add_row(name, with_unit(result.metrics[name]), interval_of(result.metrics[name]))
    title = f"{result.scenario}, seed {result.seed}, {result.frames} frames"
    tables = [*([expectations(unmet)] if unmet else []), main]
    return html.fragment(Document(title, answer(result, result.checks), [], [Section("metrics", "Metrics", tables)]))
