"""Printed report of a run: the paper's four tables, stages, tracking, speed, and the verdict."""

import io
import sys
from typing import Any

from rich.console import Console, Group, RenderableType
from rich.measure import Measurement
from rich.padding import Padding
from rich.text import Text

from luxloop.scenarios.files.expect import Check, RunVerdict, verdict
from luxloop.scenarios.report import (
    emergence_rows,
    fit_tables,
    own_rows,
    paper_tables,
    tables,
    track_tables,
    truth_event_line,
    vulnerable_table,
)
from luxloop.scenarios.result import Result
from luxloop.scenarios.run.device import SHIPPED

WIDTH = 100
"""Smallest line width without a terminal [characters]."""

STAGES = (
    "segmentation.",
    "mma.gain",
    "mma.mode",
    "mma.stationary_acc",
    "mma.switch",
)
"""Prefixes of the metrics of the tracker's stages that no other table shows."""

COLORS: dict[RunVerdict, str] = {"passed": "green", "failed": "red", "incomplete": "yellow", "no limits": "cyan"}
NOTHING_EXPECTED = "nothing in [expect] to pass or fail"


def report(result: Result, checks: list[Check]) -> Group:
    """Return the printed report of a run, the verdict last."""
    sections: list[RenderableType] = [
        header(result),
        paper_tables.dataset(result),
        paper_tables.heading_error(result),
        paper_tables.heading_distribution(result),
        paper_tables.heading_by_view(result),
        fit_tables.heading_by_band(result),
        fit_tables.selection(result),
        fit_tables.corner_and_extents(result),
        paper_tables.position_error(result),
        tables.modes(result),
        tables.predictions(result),
        tables.consistency(result),
        tables.outliers(result),
        tables.metric_list("Stages of the tracker", result, STAGES),
        *track_tables.tracking(result),
        *vulnerable_table.vulnerable(result),
        *emergence_rows.emergence(result),
        *own_rows.own_metrics(result),
        *([tables.control(result)] if result.config["control"] else []),
        tables.speed(result),
        limits(result.config["grading"]),
        *truth_event_line.truth_events(result),
        *([tables.expectations(checks)] if checks else []),
        conclusion(result, checks),
    ]
    return Group(*(Padding(section, (0, 0, 1, 0), expand=False) for section in sections))


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


def header(result: Result) -> Text:
    """Return scenario, seed and trace hash, a chosen ego, and the device unless it is the shipped tracker."""
    device, ego = result.config["device"], result.config.get("ego", "")
    selector = result.config.get("traffic", {}).get("ego")  # recordings have no traffic
    chosen = isinstance(selector, str) and selector not in (ego, f"vehicle:{ego}")
    return Text.assemble(
        (result.scenario, "bold"),
        f": {result.config['description']}\n",
        (f"seed {result.seed}, {result.frames} frames, trace {result.trace_hash}", "dim"),
        *([(f'\nego "{ego}", chosen by ego = "{selector}"', "dim")] if ego and chosen else []),
        *([] if device == SHIPPED else [("\ndevice ", "dim"), (device, "bold")]),
    )


def limits(grading: dict[str, Any]) -> Text:
    """Return the limits of grading, which the metrics depend on."""
    numbers = {name: value for name, value in grading.items() if not isinstance(value, str)}
    return Text("Graded with " + ", ".join(f"{name} = {value:g}" for name, value in numbers.items()), style="dim")


def conclusion(result: Result, checks: list[Check]) -> Text:
    """Return the verdict, and the reason if the run ended early."""
    outcome = verdict(checks, result.complete)
    text = Text(outcome.upper(), style=f"bold {COLORS[outcome]}")
    held = sum(check.holds for check in checks)
    said = f"{held} of {len(checks)} expectations hold" if checks else NOTHING_EXPECTED
    text.append(f": {said}", style="not bold default")
    known = sum(check.outcome == "known failure" for check in checks)
    if known:
        text.append(f", {known} are known to fail", style="not bold yellow")
    unreported = sum(check.outcome == "not applicable" for check in checks)
    if unreported:
        text.append(f", {unreported} are not applicable", style="not bold dim")
    if not result.complete:
        text.append(f" so far; it ended early: {result.ended_early}", style="not bold yellow")
    return text
