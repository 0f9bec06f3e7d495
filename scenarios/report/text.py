"""Documents and other reports on standard output, in files and in logs; the printed report of a run."""

import io
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from rich.console import Console, RenderableType
from rich.measure import Measurement

from luxloop.scenarios.report.html.reported_run import ReportedRun
from luxloop.scenarios.report.run_document import run_document
from luxloop.scenarios.result import Result

if TYPE_CHECKING:
    from collections.abc import Sequence

    from luxloop.scenarios.document.document import Document
    from luxloop.scenarios.files.expect import Check

WIDTH = 100
"""Smallest line width without a terminal [characters]."""


def report(result: Result, checks: "Sequence[Check]") -> "Document":
    """Return the printed report of a run, the verdict first."""
    return run_document(ReportedRun(result.out or Path(), result, list(checks), {}))


def show(report: RenderableType, text: str | None = None) -> None:
    """Print on standard output, in colour on a terminal, else the text of `as_text` if it is known already."""
    console = Console(markup=False, emoji=False)
    if text is not None and not console.is_terminal and console.encoding == "utf-8":
        console.out(text, end="", highlight=False)
    else:
        Console(width=None if sys.stdout.isatty() else _width(report), markup=False, emoji=False).print(report)


def as_text(report: RenderableType) -> str:
    """Return the report as text without colours, for a file."""
    text = io.StringIO()
    Console(file=text, width=_width(report), color_system=None, markup=False, emoji=False).print(report)
    return text.getvalue()


def _width(report: RenderableType) -> int:
    """Return the line width of a log or a file, in which no cell of a table is broken."""
    console = Console(markup=False, emoji=False)
    return max(WIDTH, Measurement.get(console, console.options.update(max_width=10_000), report).minimum)
