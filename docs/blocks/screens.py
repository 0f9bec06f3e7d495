"""Output of `luxloop run sumo-crossing`, and of two trackers on one short scenario."""

from pathlib import Path

from blocks import commands
from blocks.markdown import markdown

import luxloop
from luxloop.scenarios.report import first_screen
from luxloop.scenarios.report.html.reported_run import ReportedRun
from luxloop.scenarios.run import run_folder

REPORTED = "sumo-crossing"
COLUMNS = 80
"""Width of the screen."""
FIGURES = "Main figures"
EXAMPLES = Path(__file__).parents[1] / "examples"
PATCHES = f"{EXAMPLES / 'my_tracker.py'}:PatchTracker"
COMPARED = ("hota", "mota", "idf1", "id_switches", "missed", "false", "heading_abs_mean_deg")


def report(_name: str) -> str:
    """Return the first screen."""
    lines = screen(ReportedRun.read(commands.run(REPORTED)))
    return "\n".join(["```text", *lines, "```"])


def figures(_name: str) -> str:
    """Return the verdict and the main figures of the first screen."""
    lines = screen(ReportedRun.read(commands.run(REPORTED)))
    first = next(k for k, line in enumerate(lines) if line.startswith(FIGURES))
    last = lines.index("", first)
    return "\n".join(["```text", *lines[:2], *lines[first:last], "```"])


def screen(run: ReportedRun) -> list[str]:
    """Return the lines that `luxloop run` printed for a run in its default folder."""
    folder = Path("runs") / f"{run.result.scenario}-seed{run.result.seed}"
    known = first_screen.commands_of(folder, recorded=True)
    lines = first_screen.screen(run.result, run.checks, known, str(folder / run_folder.REPORT), COLUMNS)
    return [line.plain for line in lines]


def trackers(_name: str) -> str:
    """Return figures of the shipped tracker and of docs/examples/my_tracker.py on the same scenario."""
    found = [luxloop.run(EXAMPLES / "my-first.toml", tracker=tracker).metrics for tracker in (None, PATCHES)]
    rows = [(f"`track.{name}`", *(shown(one[f"track.{name}"].value) for one in found)) for name in COMPARED]
    return markdown(("metric", "shipped", "nearest patch"), rows)


def shown(value: float | None) -> str:
    """Return a figure, counts without decimals."""
    return "n/a" if value is None else f"{value:.3f}".removesuffix(".000")
