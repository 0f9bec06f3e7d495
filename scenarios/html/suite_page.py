"""The report of many runs: a table of all, and the essentials of each."""

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

from scenarios import run_folder
from scenarios.errors import OutputError
from scenarios.grading.metrics import REGISTRY
from scenarios.html.birdseye import birdseye
from scenarios.html.figure import Figure
from scenarios.html.pages import render
from scenarios.html.run_page import HEADLINES, Run, interval, with_unit

PICTURES = {"failed": 2, "incomplete": 2, "passed": 1}
"""Of a run, by its verdict."""
ORDER = ("failed", "incomplete", "passed")


@dataclass(frozen=True, slots=True)
class Broken:
    """A scenario that left no run: its file is wrong, or something failed."""

    name: str
    message: str


@dataclass(frozen=True, slots=True)
class Section:
    """What the page keeps of a run, whose tables are let go."""

    run: Run
    pictures: list[Figure]


def find_runs(folder: Path) -> list[Path]:
    """Return the runs under a folder.

    Raises
    ------
    OutputError
        There is none.
    """
    runs = sorted(path.parent for path in folder.rglob(run_folder.RESULT))
    if not runs:
        raise OutputError(f"{folder}: no run in it; give the folder of a run, or one of runs")
    return runs


def suite_page(folders: Iterable[Path], broken: Iterable[Broken] = ()) -> str:
    """Return the page of the runs in these folders, the failed ones first.

    Raises
    ------
    OutputError
        One holds no run.
    """
    sections = [_section(folder) for folder in folders]
    sections.sort(key=lambda section: (ORDER.index(section.run.verdict), section.run.family, section.run.anchor))
    runs = [section.run for section in sections]
    verdicts = [run.verdict for run in runs]
    return render(
        "suite.html.j2",
        sections=sections,
        broken=list(broken),
        count={verdict: verdicts.count(verdict) for verdict in ORDER},
        known=[(run, check) for run in runs for check in run.checks if check.outcome == "known failure"],
        headlines=list(HEADLINES.values()),
        with_unit=with_unit,
        interval=interval,
        registry=REGISTRY,
    )


def _section(folder: Path) -> Section:
    run = Run.read(folder)
    return Section(run, birdseye(run.result, most=PICTURES[run.verdict]))
