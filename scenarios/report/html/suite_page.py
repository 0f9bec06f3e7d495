"""HTML report of many runs: a table of all, and a section for each."""

import os
from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass, replace
from pathlib import Path

from luxloop.scenarios.errors import OutputError
from luxloop.scenarios.files.expect import RunVerdict
from luxloop.scenarios.report.html.birdseye import anchors, birdseye
from luxloop.scenarios.report.html.frame_points import frame_points
from luxloop.scenarios.report.html.pages import render
from luxloop.scenarios.report.html.reported_run import SUITE_METRICS, ReportedRun
from luxloop.scenarios.report.html.shown_frames import shown_frames
from luxloop.scenarios.report.html.svg_figure import Figure
from luxloop.scenarios.run import run_folder

PICTURES: dict[RunVerdict, int] = {"failed": 2, "incomplete": 2, "passed": 1, "no limits": 1}
"""Number of pictures of a run by its verdict."""
ORDER: tuple[RunVerdict, ...] = ("failed", "incomplete", "no limits", "passed")


@dataclass(frozen=True, slots=True)
class Broken:
    """A scenario without a run: its file is invalid, or the run failed with an error."""

    name: str
    message: str


@dataclass(frozen=True, slots=True)
class Section:
    """Section of a run. The run's tables are dropped to save memory."""

    name: str
    """Folder of the run, relative to the common parent of all runs."""
    run: ReportedRun
    pictures: list[Figure]
    anchors: dict[int, str]
    """Anchors of the pictures by frame."""

    @classmethod
    def read(cls, folder: Path, name: str) -> "Section":
        """Read a run and draw its pictures."""
        run = ReportedRun.read(folder)
        count = PICTURES[run.verdict]
        shown = shown_frames(run.result, run.worst, count, count)
        pictures = birdseye([run.result], name, shown.values(), frame_points(folder, run.result, shown))
        drawn = [replace(picture, paint=None) for picture in pictures]  # paint refers to the tables
        return cls(name, replace(run, result=replace(run.result, tables={})), drawn, anchors(drawn))


def find_runs(folder: Path) -> list[Path]:
    """Return the run folders under a folder.

    Raises
    ------
    OutputError
        There are no runs.
    """
    runs = run_folder.found_in(folder)
    if not runs:
        raise OutputError(f"{folder}: no run in it; give the folder of a run, or a folder with runs")
    return runs


def suite_page(folders: Iterable[Path], broken: Iterable[Broken] = ()) -> str:
    """Return the page of the runs in these folders, the failed ones first.

    Raises
    ------
    OutputError
        A folder has no run.
    """
    paths = {folder: folder.resolve() for folder in folders}
    above = os.path.commonpath([path.parent for path in paths.values()]) if paths else ""
    sections = [Section.read(folder, path.relative_to(above).as_posix()) for folder, path in paths.items()]
    sections.sort(
        key=lambda section: (
            ORDER.index(section.run.verdict),
            -section.run.known_failures,
            section.run.family,
            section.name,
        )
    )
    return render(
        "suite.html.j2",
        sections=sections,
        broken=list(broken),
        count=Counter(section.run.verdict for section in sections),
        known_failures=[
            (section, check) for section in sections for check in section.run.checks if check.outcome == "known failure"
        ],
        headlines=list(SUITE_METRICS.values()),
    )
