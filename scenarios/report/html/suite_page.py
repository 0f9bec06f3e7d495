"""HTML report of many runs: a table of all, and a section for each."""

import math
import os
from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

from luxloop.scenarios.document.document import (
    Answer,
    Block,
    Document,
    Folded,
    Paragraph,
    Preformatted,
    Section,
    Span,
    Table,
    code,
)
from luxloop.scenarios.document.figure import Figure, note
from luxloop.scenarios.document.palette import BAD, GOOD, LINE, MUTED, WARN
from luxloop.scenarios.errors import OutputError
from luxloop.scenarios.files.expect import RunVerdict
from luxloop.scenarios.metrics.main_figures import OF_RUNS
from luxloop.scenarios.report.cells import counted, with_unit
from luxloop.scenarios.report.html.birdseye import birdseye
from luxloop.scenarios.report.html.reported_run import ReportedRun, run_badge
from luxloop.scenarios.report.html.shown_frames import frame_points, shown_frames
from luxloop.scenarios.report.run_document import PICTURE_LEGEND, expectations
from luxloop.scenarios.run import run_folder

if TYPE_CHECKING:
    from matplotlib.figure import Figure as Canvas


COLORS = {"passed": (GOOD, "o"), "failed": (BAD, "X"), "incomplete": (WARN, "s"), "no limits": (MUTED, "D")}
"""Colour and mark of each verdict."""


def suite_figure(runs: Sequence[ReportedRun]) -> Figure:
    """Draw HOTA of each run, in a row per family."""
    measured = [(run, run.result.metrics["track.hota"].value) for run in runs]
    shown = [(run, value) for run, value in measured if value is not None and math.isfinite(value)]
    families = sorted({run.family or "others" for run, _ in shown})
    found = list(dict.fromkeys(run.verdict for run, _ in shown))

    def on(canvas: "Canvas") -> None:
        axes = canvas.subplots()
        if not shown:
            note(axes, "no run has a value")
        for verdict in found:
            color, mark = COLORS[verdict]
            of = [(value, families.index(run.family or "others")) for run, value in shown if run.verdict == verdict]
            axes.plot(*zip(*of, strict=True), mark, color=color, ms=6, alpha=0.8, mew=0.0, label=verdict, clip_on=False)
        for row in range(len(families)):
            axes.axhline(row, color=LINE, lw=0.4, zorder=0)
        axes.set_yticks(range(len(families)), families)
        axes.set(xlim=(0.0, 1.0), ylim=(max(len(families), 1) - 0.5, -0.5), xlabel="HOTA (1 is best)")
        axes.grid(visible=False, axis="y")
        if found:
            canvas.legend(loc="outside upper left", ncols=len(found))

    caption = "A mark is a run: how well it tracks as a whole, and the verdict on its expectations."
    return Figure("hota", "HOTA of each run", caption, (5.2, 1.0 + 0.24 * max(len(families), 2)), on)


PICTURES: dict[RunVerdict, int] = {"failed": 2, "incomplete": 2, "passed": 1, "no limits": 1}
"""Number of pictures of a run by its verdict."""
ORDER: tuple[RunVerdict, ...] = ("failed", "incomplete", "no limits", "passed")


@dataclass(frozen=True, slots=True)
class Broken:
    """A scenario without a run: its file is invalid, or the run failed with an error."""

    name: str
    message: str


@dataclass(frozen=True, slots=True)
class RunSection:
    """Section of a run. The run's tables are dropped to save memory."""

    name: str
    """Folder of the run, relative to the common parent of all runs."""
    run: ReportedRun
    pictures: list[Figure]

    @classmethod
    def read(cls, folder: Path, name: str) -> "RunSection":
        """Read a run and draw its pictures."""
        run = ReportedRun.read(folder)
        count = PICTURES[run.verdict]
        shown = shown_frames(run.result, run.worst, count, count)
        pictures = birdseye([run.result], name, shown.values(), frame_points(folder, run.result, shown))
        drawn = [picture.drawn() for picture in pictures]
        return cls(name, replace(run, result=replace(run.result, tables={})), drawn)

    @property
    def anchors(self) -> dict[int, str]:
        """Anchors of the pictures by frame."""
        return {figure.frame: figure.name for figure in self.pictures if figure.frame is not None}

    def order(self) -> tuple[int, int, str, str]:
        """Return the key for an order with the failed runs first."""
        return ORDER.index(self.run.verdict), -self.run.known_failures, self.run.family, self.name


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


def suite_page(folders: Iterable[Path], broken: Iterable[Broken] = ()) -> Document:
    """Return the page of the runs in these folders, the failed ones first.

    Raises
    ------
    OutputError
        A folder has no run.
    """
    paths = {folder: folder.resolve() for folder in folders}
    above = os.path.commonpath([path.parent for path in paths.values()]) if paths else ""
    read = [RunSection.read(folder, path.relative_to(above).as_posix()) for folder, path in paths.items()]
    runs, torn = sorted(read, key=RunSection.order), list(broken)
    sections = [
        Section("broken", "Could not be run", [block for one in torn for block in _torn(one)]),
        Section("all", "All runs", [_all(runs)] if runs else []),
        Section("known", "Known failures", [_known(runs)] if any(one.run.known_failures for one in runs) else []),
        Section("runs", "Each run", [PICTURE_LEGEND, *map(_folded, runs)] if runs else [], page_only=True),
    ]
    said = _answer(runs, torn)
    return Document(
        title="Suite",
        answer=said,
        lead=[suite_figure([one.run for one in runs])] if runs else [],
        sections=sections,
        name=f"{said.verdict}: {len(runs) + len(torn)} runs",
    )


def _answer(runs: Sequence[RunSection], broken: Sequence[Broken]) -> Answer:
    count = Counter(one.run.verdict for one in runs)
    said = f"{count['passed']} of {counted(len(runs) + len(broken), 'run')} passed"
    said += f", {count['failed']} failed" if count["failed"] else ""
    said += f", {count['incomplete']} ended early" if count["incomplete"] else ""
    said += f", {count['no limits']} without limits" if count["no limits"] else ""
    said += f", {len(broken)} could not be run" if broken else ""
    known = sum(one.run.known_failures for one in runs)
    said += f"; known failures: {known}" if known else ""
    bad = count["failed"] + count["incomplete"] + len(broken)
    return Answer(said, "failed", "bad") if bad else Answer(said, "passed", "good")


def _torn(broken: Broken) -> list[Block]:
    return [
        Paragraph((Span(broken.name, "bold"), " ", Span("failed", "bad", badge=True))),
        Preformatted(broken.message),
    ]


def _badges(run: ReportedRun) -> tuple[Span, ...]:
    known = run.known_failures
    return (run_badge(run.verdict), *([Span(" "), Span(f"{known} known", "warn", badge=True)] if known else []))


def _all(runs: Sequence[RunSection]) -> Table:
    """Return a row per run, with its main metrics."""
    table = Table("")
    for name in ("run", "family", "verdict"):
        table.add_column(name)
    for name in ("hold", *OF_RUNS.values(), "simulated"):
        table.add_column(name, justify="right")
    for one in runs:
        run, checks = one.run, one.run.checks
        held = f"{sum(check.holds for check in checks)}/{len(checks)}"
        link, config = Span(one.name, link=f"#{one.name}"), run.result.config
        # Gradings of files have no duration.
        duration = f"{config['duration_s']:.1f} s" if "duration_s" in config else f"{run.result.frames} frames"
        table.add_row(link, run.family, _badges(run), held, *run.headlines.values(), duration)
    return table


def _known(runs: Sequence[RunSection]) -> Table:
    table = Table("", stacked=True)
    table.add_column("run")
    table.add_column("metric")
    table.add_column("value", justify="right")
    table.add_column("limit")
    table.add_column("reason of the known failure")
    for one in runs:
        for check in one.run.checks:
            if check.outcome == "known failure":
                linked, reason = Span(one.name, link=f"#{one.name}"), str(check.limit.known_failure)
                table.add_row(linked, check.name, with_unit(check.metric), str(check.limit), reason)
    return table


def _folded(one: RunSection) -> Folded:
    """Return a run with its expectations and pictures; it is open if it failed."""
    run, config = one.run, one.run.result.config
    title = (Span(one.name), Span(" "), *_badges(run), Span(f" {run.answer.sentence}", "dim"))
    blocks: list[Block] = [
        Paragraph(config["description"]),
        *([Paragraph(str(config["reason"]), "dim")] if config.get("reason") else []),
        *([expectations(run.ranked, run.worst, one.anchors)] if run.checks else []),
        *one.pictures,
        Preformatted("\n".join(run.commands)),
        Paragraph(("Trace hash ", code(run.result.trace_hash)), "dim"),
    ]
    return Folded(title, blocks, one.name, opened=run.verdict in ("failed", "incomplete"))
