"""HTML report and printed report of the tracks of a recording: rows, figures and page."""

import json
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt
import pandas as pd

from luxloop.arrays import Floats
from luxloop.scenarios.document.document import (
    Answer,
    Document,
    Facts,
    Folded,
    Paragraph,
    Preformatted,
    Section,
    Span,
    Table,
)
from luxloop.scenarios.document.figure import Figure, note
from luxloop.scenarios.document.palette import FAINT, INK, MUTED, TEXT_SERIES
from luxloop.scenarios.files.expect import Check
from luxloop.scenarios.grading.plane_geometry import CORNER_SIGNS, corner, turned
from luxloop.scenarios.recordings.recording import Recording
from luxloop.scenarios.report import run_tables
from luxloop.scenarios.report.cells import NONE, counted, table_of
from luxloop.scenarios.report.html.reported_run import answer
from luxloop.scenarios.report.run_document import expectations
from luxloop.scenarios.result import Result
from luxloop.sim.world import WorldFrame
from luxloop.tracker.records import Status, Tracks
from luxloop.tracker.scan import Scan

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure as Canvas


NAMES = np.array([status.name.lower() for status in Status])
COLUMNS = (
    "frame", "time_s", "track_id", "x_odom_m", "y_odom_m", "heading_odom_rad", "length_m", "width_m", "status",
    "vx_odom_mps", "vy_odom_mps", "speed_mps",
)  # fmt: skip


class TrackRows:
    """Collects the tracks of all scans."""

    def __init__(self) -> None:
        self._rows: list[dict[str, npt.NDArray[Any]]] = []

    def add(self, frame: int, time: float, tracks: Tracks) -> None:
        """Add the tracks of one scan; terminated ones are left out."""
        kept = tracks.status != Status.DEAD
        center, velocity = tracks.center_odom[kept], tracks.mean[kept, 2:4]
        values = (
            np.full(len(center), frame), np.full(len(center), time), tracks.id[kept], *center.T, tracks.mean[kept, 6],
            *tracks.size[kept].T, NAMES[tracks.status[kept]], *velocity.T, np.hypot(*velocity.T),
        )  # fmt: skip
        self._rows.append(dict(zip(COLUMNS, values, strict=True)))

    def table(self) -> pd.DataFrame:
        """Return a row per track and scan."""
        return pd.DataFrame({name: np.concatenate([rows[name] for rows in self._rows]) for name in COLUMNS})


def write(path: Path, table: pd.DataFrame) -> None:
    """Write the file; the first columns are those that `luxloop grade --tracks` reads."""
    table.to_parquet(path, index=False)


def lives(table: pd.DataFrame) -> pd.DataFrame:
    """Return a row per track that was confirmed, in the order of appearance.

    `first_s` and `life_s` are the time of confirmation and the time until its last scan [s]; `scans` counts its
    confirmed scans; length, width and speed are medians, `speed_max_mps` is the 95th percentile, over these.
    """
    confirmed = table[table["status"] == "confirmed"]
    by_track = confirmed.groupby("track_id")
    found = by_track.agg(
        first_s=("time_s", "min"), last_s=("time_s", "max"), scans=("frame", "size"), length_m=("length_m", "median"),
        width_m=("width_m", "median"), speed_mps=("speed_mps", "median"),
    )  # fmt: skip
    found["speed_max_mps"] = by_track["speed_mps"].quantile(0.95)
    found["life_s"] = found["last_s"] - found["first_s"]
    return found.sort_values("first_s", kind="stable").reset_index()


GRID_M = 0.25
"""[m] Points of the whole drive are merged on this grid, those of a scan on `SCAN_GRID_M`."""
SCAN_GRID_M = 0.1
REACH_M = 70.0
"""[m] Farther points are not drawn; the tracker uses nearer ones."""
MOST_DOTS = 12_000
"""Dots of a picture; more are thinned evenly."""
SCANS_SHOWN = 3
NOT_GRADED = "The recording has no true poses, so its tracks are not graded."
WIDTH_IN = 6.0
"""[inch] Width of the picture of the whole drive."""
BOX = ["x_odom_m", "y_odom_m", "heading_odom_rad", "length_m", "width_m"]


@dataclass(slots=True)
class Drive:
    """Contents of the figures, collected scan by scan."""

    ego: list[Floats] = field(default_factory=list)
    """(3,) pose of the ego in each scan."""
    points: list[Floats] = field(default_factory=list)
    """(K, 2) points of each scan in the odometry frame, merged on a grid [m]."""
    truth: list[Floats] = field(default_factory=list)
    """(A, 5) labelled boxes of each scan: x, y, heading, length, width."""

    def add(self, frame: WorldFrame, scan: Scan) -> None:
        """Add one scan."""
        near = scan.points_ego[np.hypot(scan.points_ego[:, 0], scan.points_ego[:, 1]) <= REACH_M, :2]
        placed = turned(near.astype(np.float64), scan.ego_pose_odom[2]) + scan.ego_pose_odom[:2]
        self.points.append(SCAN_GRID_M * np.unique(np.round(placed / SCAN_GRID_M), axis=0))
        self.ego.append(scan.ego_pose_odom)
        self.truth.append(np.column_stack([frame.actors.pose_world, frame.actors.size[:, :2]]))


def whole_drive(drive: Drive, tracks: pd.DataFrame) -> Figure:
    """Draw all points, the path of the ego, and the path of each confirmed track with its last box."""
    confirmed = tracks[tracks["status"] == "confirmed"]

    def on(canvas: "Canvas") -> None:
        axes = _map(canvas)
        _dots(axes, GRID_M * np.unique(np.round(np.vstack(drive.points) / GRID_M), axis=0), FAINT, 0.8)
        axes.plot(*np.array(drive.ego)[:, :2].T, color=INK, lw=1.6)
        for track, rows in confirmed.groupby("track_id"):
            color = TEXT_SERIES[int(track) % len(TEXT_SERIES)]
            axes.plot(rows["x_odom_m"], rows["y_odom_m"], color=color, lw=1.2)
            _box(axes, rows[BOX].to_numpy(np.float64)[-1], color, 1.4, str(track))
        _true_paths(axes, drive)

    caption = (
        "All points of the recording in the odometry frame (grey), the path of the ego (black), and of each confirmed "
        "track (coloured, with its last box and id)"
        + ("; true paths are dashed." if any(map(len, drive.truth)) else ".")
    )
    span = np.ptp(np.vstack([*drive.points, np.array(drive.ego)[:, :2]]), axis=0)
    height = float(np.clip(WIDTH_IN * span[1] / max(span[0], 1.0), 0.3 * WIDTH_IN, 1.2 * WIDTH_IN))
    return Figure("drive", "Whole recording", caption, (WIDTH_IN, height), on)


def single_scans(drive: Drive, tracks: pd.DataFrame) -> list[Figure]:
    """Draw the scans with the most confirmed tracks, one of each third of the recording."""
    confirmed = tracks[tracks["status"] == "confirmed"]
    count = np.bincount(confirmed["frame"], minlength=len(drive.ego))
    parts = [part for part in np.array_split(np.arange(len(drive.ego)), SCANS_SHOWN) if len(part)]
    return [_scan(drive, confirmed, int(part[count[part].argmax()])) for part in parts]


def _scan(drive: Drive, confirmed: pd.DataFrame, frame: int) -> Figure:
    shown = confirmed[confirmed["frame"] == frame]
    ego = drive.ego[frame]

    def on(canvas: "Canvas") -> None:
        axes = _map(canvas)
        _dots(axes, drive.points[frame], FAINT, 1.4)
        for box in drive.truth[frame]:
            _box(axes, box, INK, 1.0, "")
        for track, *box in shown[["track_id", *BOX]].to_numpy(np.float64):
            _box(axes, np.array(box), TEXT_SERIES[int(track) % len(TEXT_SERIES)], 2.0, f"{track:.0f}")
        axes.plot(ego[0], ego[1], "o", color=INK, ms=5)
        ahead = ego[:2] + 4.0 * np.array([np.cos(ego[2]), np.sin(ego[2])])
        axes.plot(*np.column_stack([ego[:2], ahead]), color=INK, lw=2.0)
        reach = 45.0
        axes.set(xlim=(ego[0] - reach, ego[0] + reach), ylim=(ego[1] - reach, ego[1] + reach))

    caption = f"Scan {frame}: points, the ego (black, with its heading), and confirmed tracks with their ids."
    return Figure(f"scan-{frame}", f"Scan {frame}", caption, (4.5, 4.5), on)


def track_lives(tracks: pd.DataFrame) -> Figure:
    """Draw the time of each confirmed track, and its speed."""
    confirmed = tracks[tracks["status"] == "confirmed"]
    order = confirmed.groupby("track_id")["time_s"].min().sort_values(kind="stable").index.tolist()

    def on(canvas: "Canvas") -> None:
        above, below = canvas.subplots(2, 1, sharex=True)
        for row, track in enumerate(order):
            rows = confirmed[confirmed["track_id"] == track]
            color = TEXT_SERIES[int(track) % len(TEXT_SERIES)]
            above.plot(rows["time_s"], np.full(len(rows), row), ".", color=color, ms=4)
            below.plot(rows["time_s"], rows["speed_mps"], color=color)
        if not order:
            note(above, "no track was confirmed")
        above.set(ylabel="track", ylim=(len(order) - 0.4, -0.6))
        above.set_yticks(range(len(order)), [str(track) for track in order], fontsize=7.0)
        below.set(xlabel="time [s]", ylabel="speed [m/s]")

    caption = "Above, the scans in which each track is confirmed; below, the speeds of the same tracks."
    return Figure("lives", "Lives and speeds", caption, (12.0, 4.0 + 0.16 * len(order)), on, wide=True)


def _map(canvas: "Canvas") -> "Axes":
    axes = canvas.subplots()
    axes.set(aspect="equal", xlabel="x, odometry frame [m]", ylabel="y [m]")
    return axes


def _dots(axes: "Axes", at: Floats, color: str, width: float) -> None:
    """Draw points as strokes of length zero with round ends, the shortest SVG for a dot."""
    from matplotlib.patches import PathPatch
    from matplotlib.path import Path as Line

    at = at[:: max(1, -(-len(at) // MOST_DOTS))]
    if len(at):
        path = Line(np.repeat(at, 2, axis=0), np.tile([Line.MOVETO, Line.LINETO], len(at)))
        path.should_simplify = False
        axes.add_patch(PathPatch(path, fill=False, edgecolor=color, linewidth=width, capstyle="round"))


def _box(axes: "Axes", box: Floats, color: str, width: float, label: str) -> None:
    """Draw a box (5,) with a stroke at its front."""
    outline = corner(box[None, None, :], CORNER_SIGNS[None])[0]
    front = outline[[0, 3]].mean(axis=0)
    axes.plot(*np.vstack([outline, outline[:1]]).T, color=color, lw=width)
    axes.plot(*np.column_stack([box[:2], front]), color=color, lw=width)
    if label:
        axes.annotate(
            label, (box[0], box[1]), color=color, fontsize=8, weight="bold", xytext=(6, 6), textcoords="offset points"
        )


def _true_paths(axes: "Axes", drive: Drive) -> None:
    boxes = [truth for truth in drive.truth if len(truth)]
    for row in range(max((len(truth) for truth in boxes), default=0)):
        path = np.array([truth[row, :2] for truth in boxes if len(truth) > row])
        axes.plot(*path.T, color=MUTED, lw=1.0, ls=(0, (4, 3)))


def recording_document(
    recording: Recording, result: Result, checks: Sequence[Check], tracks: pd.DataFrame, out: Path, drive: Drive | None
) -> Document:
    """Return a tracked recording as a document.

    Parameters
    ----------
    checks
        Expectations; the document judges nothing without any.
    out
        Folder of the results.
    drive
        Contents of the figures; None for the printed report.
    """
    grades = run_tables.tracking(result) if recording.has_truth else [Paragraph(NOT_GRADED, "dim")]
    drawn = [*single_scans(drive, tracks), track_lives(tracks)] if drive else []
    commands = Preformatted(f"luxloop track {recording.folder} --out {out}\nluxloop view {out}")
    settings = Folded("Settings", [Preformatted(json.dumps(result.config, indent=2, ensure_ascii=False))])
    sections = [
        Section("expectations", "Expectations", [expectations(checks)] if checks else []),
        Section("scans", "Single scans", drawn[:-1], page_only=True),
        Section("tracks", "Tracks", [*drawn[-1:], track_table(tracks)]),
        Section("grades", "Grades", grades),
        Section("again", "Reproduce", [commands, settings], page_only=True),
    ]
    judged = answer(result, checks)
    said = Answer(sentence(result, tracks))
    if checks:
        said = Answer(f"{judged.sentence}; {said.sentence}", judged.verdict, judged.style)
    about = Paragraph((Span(recording.name, "bold"), f": {result.config['description']}"))
    return Document(
        title=recording.name,
        answer=said,
        lead=[*([whole_drive(drive, tracks)] if drive else []), about, Facts(headlines(result, tracks), large=True)],
        sections=sections,
        name=f"{recording.name}: tracks",
    )


def sentence(result: Result, tracks: pd.DataFrame) -> str:
    """Return what was tracked."""
    return f"{', '.join(facts(result, tracks))} in {counted(result.frames, 'scan')}"


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
    columns = ("from [s]", "life [s]", "scans", "length [m]", "width [m]", "speed [m/s]", "fastest [m/s]")
    table = table_of("Confirmed tracks", "track", *columns)
    for row in lives(tracks).itertuples():
        times = (f"{row.first_s:.1f}", f"{row.life_s:.1f}", f"{row.scans:.0f}")
        others = (row.length_m, row.width_m, row.speed_mps, row.speed_max_mps)
        table.add_row(str(row.track_id), *times, *(f"{value:.1f}" for value in others))
    return table
