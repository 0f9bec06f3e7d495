"""HTML report and printed report of the tracks of a recording."""

import json
from pathlib import Path

import numpy as np
import pandas as pd
from rich.console import Group, RenderableType
from rich.table import Table
from rich.text import Text

from luxloop.scenarios.files.expect import Check
from luxloop.scenarios.recordings.recording import Recording
from luxloop.scenarios.recordings.track_figures import Drive, single_scans, track_lives, whole_drive
from luxloop.scenarios.recordings.track_rows import lives
from luxloop.scenarios.report import tables, text, track_tables
from luxloop.scenarios.report.cells import NONE, counted
from luxloop.scenarios.report.html.page_tables import page_table
from luxloop.scenarios.report.html.pages import render
from luxloop.scenarios.result import Result


def page(recording: Recording, result: Result, drive: Drive, tracks: pd.DataFrame, out: Path) -> str:
    """Return the HTML page of a tracked recording, whose results are in `out`."""
    return render(
        "recording.html.j2",
        name=recording.name,
        description=result.config["description"],
        headlines=headlines(result, tracks),
        whole=whole_drive(drive, tracks),
        scans=single_scans(drive, tracks),
        lives=track_lives(tracks),
        track_tables=[page_table(track_table(tracks))],
        graded=recording.has_truth,
        grade_tables=[page_table(table) for table in track_tables.tracking(result)],
        commands=[f"luxloop track {recording.folder} --out {out}", f"luxloop view {out}"],
        config=json.dumps(result.config, indent=2, ensure_ascii=False),
    )


def printed(recording: Recording, result: Result, checks: list[Check], tracks: pd.DataFrame) -> RenderableType:
    """Return the report as text, with the verdict last if there are expectations."""
    head = Text.assemble((recording.name, "bold"), f": {result.config['description']}\n")
    for title, value in headlines(result, tracks).items():
        head.append(f"{title} {value}; ")
    graded = track_tables.tracking(result) if recording.has_truth else []
    judged: list[RenderableType] = [tables.expectations(checks), text.conclusion(result, checks)] if checks else []
    return Group(head, track_table(tracks), *graded, *judged)


def headlines(result: Result, tracks: pd.DataFrame) -> dict[str, str]:
    """Return the main numbers, as text by name."""
    confirmed, life, per_scan = _track_numbers(result, tracks)
    shown = {
        "scans": str(result.frames),
        "confirmed tracks": str(confirmed),
        "median life": life,
        "tracks per scan": per_scan,
    }
    hota, speed = (result.metrics[name].value for name in ("track.hota", "track.speed_abs_mean_mps"))
    if hota is not None:
        shown["HOTA"] = f"{hota:.3f}"
    if speed is not None:
        shown["speed error"] = f"{speed:.2f} m/s"
    return shown


def facts(result: Result, tracks: pd.DataFrame) -> list[str]:
    """Return the numbers about all tracks, which need no truth."""
    confirmed, life, per_scan = _track_numbers(result, tracks)
    return [counted(confirmed, "confirmed track"), f"median life {life}", f"{per_scan} tracks per scan"]


def _track_numbers(result: Result, tracks: pd.DataFrame) -> tuple[int, str, str]:
    """Return the number of confirmed tracks, their median life, and their mean number per scan."""
    found = lives(tracks)
    life = f"{found['life_s'].median():.1f} s" if len(found) else NONE
    per_scan = np.bincount(tracks.loc[tracks["status"] == "confirmed", "frame"], minlength=result.frames).mean()
    return len(found), life, f"{per_scan:.1f}"


def track_table(tracks: pd.DataFrame) -> Table:
    """Return a table with a row per confirmed track: life, size and speed."""
    table = Table(title="Confirmed tracks")
    for name in ("track", "from [s]", "life [s]", "scans", "length [m]", "width [m]", "speed [m/s]", "fastest [m/s]"):
        table.add_column(name, justify="right")
    for row in lives(tracks).itertuples():
        values = (row.first_s, row.life_s, row.scans, row.length_m, row.width_m, row.speed_mps, row.speed_max_mps)
        texts = [f"{value:.0f}" if name == "scans" else f"{value:.1f}" for name, value in zip(
            ("first", "life", "scans", "length", "width", "speed", "fastest"), values, strict=True)]  # fmt: skip
        table.add_row(str(row.track_id), *texts)
    return table
