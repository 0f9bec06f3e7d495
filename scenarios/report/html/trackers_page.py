"""HTML report of several trackers on the same drive."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from luxloop.arrays import Floats
from luxloop.scenarios.document.document import (
    Answer,
    Block,
    Document,
    Legend,
    Paragraph,
    Player,
    Preformatted,
    Section,
    Span,
    Table,
    Words,
    code,
)
from luxloop.scenarios.document.figure import Figure, note
from luxloop.scenarios.document.palette import TEXT_SERIES
from luxloop.scenarios.errors import InputError
from luxloop.scenarios.files.expect import Check
from luxloop.scenarios.metrics.definition import filtered
from luxloop.scenarios.metrics.definitions import REPORTED_BANDS
from luxloop.scenarios.metrics.main_figures import OF_RUNS
from luxloop.scenarios.report.cells import interval_of, table_of, with_unit
from luxloop.scenarios.report.html.birdseye import birdseye
from luxloop.scenarios.report.html.frame_player import near, player
from luxloop.scenarios.report.html.reported_run import OUTCOMES, ReportedRun, run_badge
from luxloop.scenarios.report.html.shown_frames import ShownFrame, ego_poses, frame_points, shown_frames
from luxloop.scenarios.report.html.timelines import timelines
from luxloop.scenarios.report.run_tables import BANDED_TABLES, TRACK_TABLES, band_label
from luxloop.scenarios.result import Metric, Result
from luxloop.scenarios.run import run_folder
from luxloop.scenarios.run.device import short_name
from luxloop.tracker.records import MODELS

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure as Canvas


SAME_M = 1e-6
"""Tolerance of positions in the truth of two runs [m]: traffic differs by less on two types of CPU."""
POSITION = ["frame", "actor_id", "x_world_m", "y_world_m"]


def same_drive(folders: Sequence[Path]) -> bool:
    """Return True for several runs of one scenario and seed.

    Raises
    ------
    OutputError
        A folder has a damaged run.
    """
    drives = {(result.scenario, result.seed) for result in map(run_folder.read, folders)}
    return len(folders) > 1 and len(drives) == 1


def read_trackers(folders: Sequence[Path]) -> dict[str, ReportedRun]:
    """Read runs of one drive, by the names of their trackers.

    Raises
    ------
    InputError
        The traffic of two runs differs.
    OutputError
        A folder has no run.
    """
    runs = [ReportedRun.read(folder) for folder in folders]
    for run in runs[1:]:
        if not _same_traffic(runs[0].result, run.result):
            raise InputError(
                f"{run.folder}: its traffic differs from that of {runs[0].folder}; give runs of the same drive, "
                "or report each of them alone"
            )
    return dict(zip(_names(runs), runs, strict=True))


def _names(runs: Sequence[ReportedRun]) -> list[str]:
    """Return the names of the trackers with their settings, or of the folders if these are equal."""
    names = [" ".join([short_name(run.result.config["device"]), *run.result.config.get("set", [])]) for run in runs]
    if len(set(names)) == len(names):
        return names
    folders = [run.folder.resolve() for run in runs]
    short = [folder.name for folder in folders]
    return short if len(set(short)) == len(short) else [str(folder) for folder in folders]


def _same_traffic(one: Result, other: Result) -> bool:
    """Compare the truth of the frames that both runs have."""
    frames = min(one.frames, other.frames)
    truths = (result.tables["truth"] for result in (one, other))
    first, second = (truth[truth["frame"] < frames][POSITION].to_numpy() for truth in truths)
    return first.shape == second.shape and np.allclose(first, second, rtol=0.0, atol=SAME_M)


SHOWN_DEG = 10.0
"""End of the axes; the legends give the share of larger errors."""
LINES = ("-", "--", "-.", ":")
"""Line styles of trackers, besides their colours."""


def heading_distributions(results: Mapping[str, Result]) -> list[Figure]:
    """Return the cumulative distributions of the absolute errors of the fit heading and of the track heading."""
    fits = {name: _of_fits(result) for name, result in results.items()}
    tracks = {name: _of_tracks(result) for name, result in results.items()}
    return [
        _distribution("fit-heading", "Fit heading error", "Selected rectangles, modulo 90 degrees.", fits),
        _distribution("track-heading", "Track heading error", "Confirmed tracks on moving vehicles.", tracks),
    ]


def _of_fits(result: Result) -> Floats:
    fits = result.tables["fits"]
    return np.sort(np.abs(fits.loc[fits["best"], "heading_error_deg"].dropna().to_numpy()))


def _of_tracks(result: Result) -> Floats:
    tracks = result.tables["tracks"]
    moving = tracks["judged"] & (tracks["true_mode"] != MODELS[0])
    return np.sort(np.abs(tracks.loc[moving, "heading_error_deg"].dropna().to_numpy()))


def _distribution(name: str, title: str, caption: str, errors: Mapping[str, Floats]) -> Figure:
    def on(canvas: "Canvas") -> None:
        axes = canvas.subplots()
        for row, (tracker, error) in enumerate(errors.items()):
            _draw(axes, row, tracker, error)
        if not any(map(len, errors.values())):
            note(axes, "no tracker has any")
        else:
            canvas.legend(loc="outside lower center", ncols=1)
        axes.set(xlim=(0, SHOWN_DEG), ylim=(0, 1.01), xlabel=f"|{title.lower()}| [deg]", ylabel="share at or below")

    return Figure(name, title, f"{caption} Further left and higher is better.", (5.2, 4.2), on)


def _draw(axes: "Axes", row: int, tracker: str, error: Floats) -> None:
    if not len(error):
        return
    color, line = TEXT_SERIES[row % len(TEXT_SERIES)], LINES[row % len(LINES)]
    label = f"{tracker} ({np.mean(error > SHOWN_DEG):.1%} beyond, n = {len(error)})"
    axes.step(error, np.arange(1, len(error) + 1) / len(error), where="post", color=color, linestyle=line, label=label)


LIMITED = "Expectations, with the outcome"
NO_METRIC = Metric(None, "", 0, "the run does not have this metric")


def tables(runs: Mapping[str, ReportedRun]) -> list[Table]:
    """Return the main metrics, the expectations, and the metrics of the tracks over the whole run."""
    return [
        _metrics("Main metrics", runs, OF_RUNS),
        _expectations(runs),
        *(
            _metrics(title, runs, {f"track.{name}": f"track.{name}" for name in names})
            for title, names in TRACK_TABLES.items()
        ),
    ]


def band_tables(runs: Mapping[str, ReportedRun]) -> list[Table]:
    """Return a table by range, class and view for each metric that has these."""
    names = [name for columns in BANDED_TABLES.values() for name in columns]
    found = []
    for name in names:
        rows = {filtered(name, **band): band_label(band) for band in REPORTED_BANDS}
        found.append(_metrics(name, runs, rows))
    return found


def _metrics(title: str, runs: Mapping[str, ReportedRun], rows: Mapping[str, str]) -> Table:
    """Return values with 95 % intervals; `rows` are the labels by metric."""
    table = table_of(title, "metric", *runs)
    for name, label in rows.items():
        table.add_row(label, *(_value(run.result.metrics.get(name, NO_METRIC)) for run in runs.values()))
    return table


def _expectations(runs: Mapping[str, ReportedRun]) -> Table:
    table = table_of(LIMITED, "expectation", *runs)
    for name in dict.fromkeys(check.name for run in runs.values() for check in run.ranked):
        checks = [{check.name: check for check in run.checks}.get(name) for run in runs.values()]
        limit = next(str(check.limit) for check in checks if check)
        table.add_row(f"{name} {limit}", *map(_outcome, checks))
    return table


def _outcome(check: Check | None) -> Words:
    if check is None:
        return "not expected"
    return f"{with_unit(check.metric)}: ", Span(check.outcome, OUTCOMES[check.outcome])


def _value(metric: Metric) -> str:
    spread = interval_of(metric)
    return f"{with_unit(metric)} ({spread})" if spread else with_unit(metric)


SAME_SCANS = (
    "Values with 95 % intervals. All trackers had the same scans; compare two of them over many drives by "
    "luxloop compare."
)
MARKS = (
    "True boxes are thin, with a wedge at their front and the names of the vehicles. Tracks have the colour of their "
    "tracker, a line at their front for the track heading, and their id; they are dashed if coasting."
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
        Section("metrics", "Metrics", [Paragraph(SAME_SCANS), *tables(runs)]),
        Section("worst", "Worst frames of each tracker", [Paragraph(MARKS), *pictures], page_only=True),
        Section("frames", "Frame by frame", [frames] if ego else [], page_only=True),
        Section("headings", "Headings", [figure for figure in more if figure.frame is None], page_only=True),
        Section("tracks", "Tracks", [_timeline(row, *one) for row, one in enumerate(runs.items())], page_only=True),
        Section("bands", "Tracks by range, class and view", band_tables(runs), page_only=True),
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
