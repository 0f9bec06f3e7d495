"""Worst fits of a run with recorded scans, by view: of all, and of those with many points."""

import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pandas as pd
from fits.case import Case, case_of

from luxloop.scenarios.metrics.definitions import VIEWS
from luxloop.scenarios.offline.recorded_scans import RecordedRun
from luxloop.tracker.tracker import Tracker

MANY = 100
"""Points of a segment whose fit has no lack of them."""
AGREES_DEG = 1e-6
"""Largest difference of an error from that of the run [deg]."""


def worst_cases(folder: Path) -> list[Case]:
    """Return the fit with the largest error of each view, then the same of those with many points.

    The tracker runs again over the recorded scans.
    """
    run = RecordedRun.open(folder)
    wanted = chosen(run.result.tables["fits"])
    found = dict(_replayed(run, wanted))
    return [found[row.Index] for row in wanted.itertuples()]


def chosen(fits: pd.DataFrame) -> pd.DataFrame:
    """Return the rows of the selected rectangles of the worst fits, each of another vehicle."""
    best = fits[fits["best"] & fits["heading_error_deg"].notna()]
    rows: list[int] = []
    for least in (0, MANY):
        for view in VIEWS.values():
            seen = best[(best["view"] == view) & (best["points"] >= least)]
            new = seen[~seen["actor_id"].isin(best.loc[rows, "actor_id"])]
            if len(new):
                rows.append(int(new["heading_error_deg"].abs().idxmax()))
    return best.loc[rows]


def _replayed(run: RecordedRun, wanted: pd.DataFrame) -> Iterator[tuple[int, Case]]:
    """Yield row and fit of the wanted observations, in the order of time."""
    tracker, last = Tracker(run.scenario.tracker), int(wanted["frame"].max())
    for frame, scan, _ in run.scans():
        _, trace = tracker.step(scan)
        for row in wanted[wanted["frame"] == frame.index].itertuples():
            own = np.flatnonzero(trace.segments.label == row.segment)
            box = np.array(
                [row.true_x_ego_m, row.true_y_ego_m, row.true_yaw_ego_rad, row.true_length_m, row.true_width_m]
            )
            name = f"{run.result.scenario}, {row.time_s:.1f} s\n{str(row.view).replace('_', '-')}, {row.range_m:.0f} m"
            points = np.asarray(scan.points_ego[own, :2], dtype=np.float64)
            case = case_of(name, points, trace.linkage.line[own], trace.candidates, int(row.segment), box)
            if abs(case.worst - abs(row.heading_error_deg)) > AGREES_DEG:
                sys.exit(f"{run.folder}: its fits are of another version of the tracker; run the scenario again")
            yield int(row.Index), case
        if frame.index == last:
            return
