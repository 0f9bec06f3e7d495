"""HTML report of several trackers on the same drive."""

from collections.abc import Mapping

import pandas as pd

from luxloop.scenarios.report.html import tracker_tables
from luxloop.scenarios.report.html.birdseye import birdseye
from luxloop.scenarios.report.html.frame_player import near, player
from luxloop.scenarios.report.html.frame_points import frame_points
from luxloop.scenarios.report.html.pages import render
from luxloop.scenarios.report.html.reported_run import ReportedRun
from luxloop.scenarios.report.html.shown_frames import ShownFrame, ego_poses, shown_frames
from luxloop.scenarios.report.html.svg_figure import Figure
from luxloop.scenarios.report.html.timelines import timelines
from luxloop.scenarios.report.html.tracker_figures import heading_distributions
from luxloop.scenarios.run import run_folder

LEAST, MOST = 2, 4
"""Frames of each tracker: at least so many snapshots, at most so many frames."""


def trackers_page(runs: Mapping[str, ReportedRun]) -> str:
    """Return the page of runs of the same drive, by the names of their trackers."""
    results = {name: run.result for name, run in runs.items()}
    longest = max(results.values(), key=lambda result: result.frames)
    ego, marked = ego_poses(longest), _marked(runs)
    points = _points(runs, near((shown.frame for shown in marked), ego))
    return render(
        "trackers.html.j2",
        runs=runs,
        first=next(iter(runs.values())),
        tables=tracker_tables.tables(runs),
        band_tables=tracker_tables.band_tables(runs),
        pictures=birdseye(list(results.values()), "drive", marked, points),
        player=player(results, ego, marked, points),
        figures=heading_distributions(results),
        lines=[_timeline(row, name, run) for row, (name, run) in enumerate(runs.items())],
    )


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
