"""HTML report of several trackers on the same drive."""

from collections.abc import Mapping

import pandas as pd

from luxloop.scenarios.document.document import (
    Answer,
    Block,
    Document,
    Legend,
    Paragraph,
    Player,
    Preformatted,
    Section,
)
from luxloop.scenarios.document.figure import Figure
from luxloop.scenarios.document.words import Span, code
from luxloop.scenarios.report.html import tracker_tables
from luxloop.scenarios.report.html.birdseye import birdseye
from luxloop.scenarios.report.html.frame_player import near, player
from luxloop.scenarios.report.html.frame_points import frame_points
from luxloop.scenarios.report.html.reported_run import ReportedRun
from luxloop.scenarios.report.html.shown_frames import ShownFrame, ego_poses, shown_frames
from luxloop.scenarios.report.html.timelines import timelines
from luxloop.scenarios.report.html.tracker_figures import heading_distributions
from luxloop.scenarios.report.run_answer import run_badge
from luxloop.scenarios.result import Result
from luxloop.scenarios.run import run_folder

SAME_SCANS = (
    "Values with 95 % intervals. All trackers had the same scans; compare two of them over many drives by "
    "luxloop compare."
)
MARKS = (
    "True boxes are thin, with the names of the vehicles. Tracks have the colour of their tracker, a line at their "
    "front for the track heading, and their id; they are dashed if coasting."
)
LEAST, MOST = 2, 4
"""Frames of each tracker: at least so many snapshots, at most so many frames."""


def trackers_page(runs: Mapping[str, ReportedRun]) -> Document:
    """Return the page of runs of the same drive, by the names of their trackers."""
    results = {name: run.result for name, run in runs.items()}
    longest = max(results.values(), key=lambda result: result.frames)
    ego, marked = ego_poses(longest), _marked(runs)
    points = _points(runs, near((shown.frame for shown in marked), ego))
    frames = player(results, ego, marked, points)
    first, *more = [*birdseye(list(results.values()), "drive", marked, points), *heading_distributions(results)]
    pictures = [figure for figure in more if figure.frame is not None]
    sections = [
        Section("metrics", "Metrics", [Paragraph(SAME_SCANS), *tracker_tables.tables(runs)]),
        Section("worst", "Worst frames of each tracker", [Paragraph(MARKS), *pictures], page_only=True),
        Section("frames", "Frame by frame", [frames] if ego else [], page_only=True),
        Section("headings", "Headings", [figure for figure in more if figure.frame is None], page_only=True),
        Section("tracks", "Tracks", [_timeline(row, *one) for row, one in enumerate(runs.items())], page_only=True),
        Section("bands", "Tracks by range, class and view", tracker_tables.band_tables(runs), page_only=True),
        Section("again", "Reproduce", [block for one in runs.items() for block in _again(*one)], page_only=True),
    ]
    name = f"{longest.scenario}: {len(runs)} trackers"
    return Document(
        title=f"{longest.scenario}, seed {longest.seed}: {len(runs)} trackers",
        answer=Answer(best(results)),
        lead=[first, _legend(runs, frames), Paragraph(longest.config["description"])],
        sections=sections,
        name=name,
    )


def best(results: Mapping[str, Result]) -> str:
    """Return the tracker with the highest HOTA, beside the others."""
    values = {name: result.metrics["track.hota"].value for name, result in results.items()}
    known = sorted(((value, name) for name, value in values.items() if value is not None), reverse=True)
    if not known:
        return "No tracker has a HOTA: nothing was graded"
    (value, name), *others = known
    said = f"{name} tracks best in this drive, with HOTA {value:.3f}"
    return f"{said}; {', '.join(f'{other} has {value:.3f}' for value, other in others)}" if others else said


def _legend(runs: Mapping[str, ReportedRun], frames: Player) -> Legend:
    """Return the colour, the verdict and the answer of each tracker."""
    return Legend(
        [
            (
                f"line-{frames.trackers[name]}",
                (Span(name, "bold"), " ", run_badge(run.verdict), f" {run.answer.sentence}"),
            )
            for name, run in runs.items()
        ]
    )


def _again(name: str, run: ReportedRun) -> list[Block]:
    trace = Paragraph(("Trace hash ", code(run.result.trace_hash)), "dim")
    return [Paragraph(Span(name, "bold")), Preformatted("\n".join(run.commands)), trace]


def _marked(runs: Mapping[str, ReportedRun]) -> list[ShownFrame]:
    """Return the worst frames of all trackers in the order of time; each error begins with the tracker's name."""
    merged: dict[int, ShownFrame] = {}
    for name, run in runs.items():
        for shown in shown_frames(run.result, run.worst, LEAST, MOST).values():
            into = merged.setdefault(shown.frame, ShownFrame(shown.frame, shown.time_s))
            into.titles.append(name)
            into.errors.extend(f"{name}: {error}" for error in shown.errors)
            into.places_ego.extend(shown.places_ego)
    return [merged[frame] for frame in sorted(merged)]


def _points(runs: Mapping[str, ReportedRun], frames: set[int]) -> pd.DataFrame:
    """Return the points of these frames from all runs, which have the same scans; recordings are read once."""
    parts, missing = [], set(frames)
    ordered = sorted(runs.values(), key=lambda run: not (run.folder / run_folder.RECORDING).is_file())
    for run in ordered:
        found = frame_points(run.folder, run.result, missing)
        parts.append(found)
        missing -= set(found["frame"])
    return pd.concat(parts, ignore_index=True)


def _timeline(row: int, name: str, run: ReportedRun) -> Figure:
    hidden_max = run.result.config["grading"]["hidden_fraction_max"]
    return timelines(run.result.tables["truth"], hidden_max, f"timelines-{row}", f"{name}: tracks of each vehicle")
