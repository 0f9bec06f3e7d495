"""Figures and page of one run."""

from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
import pandas as pd

from luxloop.arrays import Ints
from luxloop.scenarios.document.document import Document
from luxloop.scenarios.document.figure import Figure, note
from luxloop.scenarios.document.palette import BLUE, FAINT, GREEN, INK, ORANGE, PURPLE, RED, SKY
from luxloop.scenarios.grading.frame_tables import models_of
from luxloop.scenarios.grading.plane_geometry import wrap
from luxloop.scenarios.grading.worst_frames import vehicle_names
from luxloop.scenarios.metrics.definitions import DEFINITIONS, FIT_METHODS
from luxloop.scenarios.report import paper_comparison
from luxloop.scenarios.report.html.birdseye import birdseye
from luxloop.scenarios.report.html.frame_player import near, player
from luxloop.scenarios.report.html.reported_run import ReportedRun
from luxloop.scenarios.report.html.shown_frames import ego_poses, frame_points, shown_frames
from luxloop.scenarios.report.html.timelines import file_figures, timelines
from luxloop.scenarios.report.run_document import RunFigures, run_document
from luxloop.scenarios.result import Result
from luxloop.scenarios.statistics.jackknife import ratio_interval
from luxloop.tracker.records import BASELINES, MODEL_NAMES, MODELS

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure as Canvas


SHOWN_DEG = 10.0
"""End of the axis of heading errors; the legend gives the share of larger errors."""

LINES = ("-", "--", "-.", ":", (0, (5, 1, 1, 1, 1, 1)))

METHOD_LOOKS = {
    **{method: (RED, line) for method, line in zip(BASELINES, LINES, strict=True)},
    "area": (FAINT, ":"),
    "closeness": (ORANGE, "--"),
    "variance": (GREEN, "-."),
    "tlinkage": (PURPLE, "--"),
    "refined": (SKY, "-"),
    "best": (BLUE, "-"),
    "oracle": (INK, ":"),
}
"""Colour and line style of each method; baselines share a colour."""

WIDTHS = {"best": 2.4}
"""Line widths other than the default [points]."""


def heading_distribution(fits: pd.DataFrame) -> Figure:
    """Draw the cumulative distribution of the absolute heading error of each method."""

    def on(canvas: "Canvas") -> None:
        axes = canvas.subplots()
        for method in FIT_METHODS:
            rows = fits[fits[method]] if method in ("best", "oracle") else fits[fits["method"] == method]
            error = np.sort(np.abs(rows["heading_error_deg"].dropna().to_numpy()))
            if len(error):
                color, line = METHOD_LOOKS[method]
                share = np.arange(1, len(error) + 1) / len(error)
                label, width = f"{method} ({np.mean(error > SHOWN_DEG):.1%} beyond)", WIDTHS.get(method, 1.4)
                axes.step(error, share, where="post", color=color, linestyle=line, label=label, lw=width)
        for method, marker in (("best", "s"), ("variance", "o")):
            color, label = METHOD_LOOKS[method][0], f"the paper's {method}"
            axes.plot(range(1, 6), paper_comparison.WITHIN[method], marker, color=color, mfc="none", ms=5, label=label)
        axes.set(
            xlim=(0, SHOWN_DEG),
            ylim=(0, 1.01),
            xlabel="|fit heading error| [deg], modulo 90",
            ylabel="share at or below",
        )
        canvas.legend(loc="outside lower center", ncols=2)

    caption = "Further left and higher is better. Oracle is the best possible selection."
    return Figure("heading-cdf", "Fit heading error, by method", caption, (5.2, 4.9), on)


WHISKER = 4.0
"""End of an axis, in multiples of the largest mean: the interval of few vehicles may be much longer."""
HEADING_DEG = DEFINITIONS["fit.heading_abs_mean_deg"].range
POSITION_M = DEFINITIONS["fit.position_abs_mean_m"].range


class Covariate(NamedTuple):
    """A quantity that the errors are shown against."""

    name: str
    label: str
    """Label of the axis."""
    column: str
    edges: Sequence[float]
    """Edges of the bins."""
    percent: bool = False


COVARIATES = (
    Covariate("range", "range [m]", "range_m", (0, 10, 20, 30, 40, 50)),
    Covariate("aspect", "aspect [deg]: 0 from ahead, 180 from behind", "aspect_deg", (0, 30, 60, 90, 120, 150, 180)),
    Covariate("visible fraction", "visible fraction [%]", "visible_fraction", (0, 0.2, 0.4, 0.6, 0.8, 1), percent=True),
)


def observations(fits: pd.DataFrame, truth: pd.DataFrame) -> pd.DataFrame:
    """Return the selected rectangles with `range_m`, `aspect_deg`, `visible_fraction` and the `kind` of the vehicle.

    The aspect is the angle at the vehicle between its heading and the line to the ego, 0 to 180 degrees.
    """
    best = fits[fits["best"] & fits["heading_error_deg"].notna()]
    to_ego = np.arctan2(-best["true_y_ego_m"].to_numpy(), -best["true_x_ego_m"].to_numpy())
    aspect = np.degrees(np.abs(wrap(to_ego - best["true_yaw_ego_rad"].to_numpy())))
    seen = truth[["frame", "actor_id", "visible_fraction", "kind"]]
    return best.assign(aspect_deg=aspect).merge(seen, on=["frame", "actor_id"], validate="many_to_one")


def errors_against(observed: pd.DataFrame, covariate: Covariate) -> Figure:
    """Draw mean absolute errors of fit heading and corner by bins of a covariate, with 95 % intervals."""
    scale = 100 if covariate.percent else 1
    names = [f"{scale * low:g}-{scale * high:g}" for low, high in pairwise(covariate.edges)]
    # The last bin includes its upper edge; graded observations are never beyond it.
    place = np.searchsorted(covariate.edges[1:-1], observed[covariate.column].to_numpy(), side="right")
    return _errors(observed, covariate.name, covariate.label, names, place)


def errors_by_class(observed: pd.DataFrame) -> Figure:
    """Draw the same errors by class of the vehicle, for the classes with fits."""
    kinds = observed["kind"].astype(str)
    names = sorted(kinds.unique())
    place = kinds.map({name: row for row, name in enumerate(names)}).to_numpy(np.int64)
    return _errors(observed, "class", "class of the vehicle", [name.replace("_", " ") for name in names], place)


def _errors(observed: pd.DataFrame, name: str, label: str, bins: list[str], place: Ints) -> Figure:
    """Draw the errors of fits by the bins that they are in."""

    def on(canvas: "Canvas") -> None:
        heading, position = canvas.subplots(2, 1, sharex=True)
        counts = np.bincount(place, minlength=len(bins))
        _means(heading, observed, place, observed["heading_error_deg"].abs(), HEADING_DEG, BLUE)
        _means(position, observed, place, observed["position_error_m"], POSITION_M, GREEN)
        heading.set_ylabel("fit heading [deg]")
        position.set_ylabel("nearest corner [m]")
        labels = [f"{one}\nn={count}" for one, count in zip(bins, counts, strict=True)]
        position.set_xticks(range(len(labels)), labels, fontsize=7.5)
        position.set(xlabel=label, xlim=(-0.5, max(len(bins), 1) - 0.5))

    caption = "Mean absolute error of the selected fits; whiskers are 95 % over vehicles, n counts fits."
    return Figure(f"error-{name.split()[0]}", f"Error of fits against {name}", caption, (5.2, 3.9), on)


def _means(
    axes: "Axes", observed: pd.DataFrame, place: Ints, error: pd.Series, within: tuple[float, float], color: str
) -> None:
    """Draw the mean of each bin with its interval."""
    top = 0.0
    for k in np.unique(place).tolist():
        inside = place == k
        value, vehicle = error.to_numpy()[inside], observed["actor_id"].to_numpy()[inside]
        interval = ratio_interval(vehicle, value, np.ones_like(value), within)
        axes.plot(k, value.mean(), "o", color=color, ms=5)
        top = max(top, value.mean())
        if interval:
            axes.plot([k, k], interval, "-", color=color, lw=1.2)
    if not len(place):
        note(axes, "no fits")
    axes.set_ylim(0.0, min(axes.get_ylim()[1], WHISKER * top) if top else None)


VEHICLES = 4
"""Number of vehicles shown."""
COLORS = dict(zip(MODEL_NAMES, (ORANGE, BLUE, GREEN, PURPLE, RED, SKY), strict=True))
STRIP = (-0.2, -0.06)
"""Lower and upper edge of the strip with the true mode, below the probabilities."""
FRAMES_MIN = 12
"""Least number of frames in which a shown vehicle is followed."""


def model_probabilities(tracks: pd.DataFrame, truth: pd.DataFrame) -> Figure:
    """Draw the model probabilities over time, for the vehicles with most changes of the true mode."""
    judged = tracks[tracks["judged"]].sort_values(["actor_id", "frame"], kind="stable")
    chosen = most_mode_changes(judged)
    names = vehicle_names(truth)
    colors = {model: COLORS[model] for model in models_of(tracks)}

    def on(canvas: "Canvas") -> None:
        from matplotlib.lines import Line2D
        from matplotlib.patches import Patch

        rows = canvas.subplots(max(len(chosen), 1), 1, sharex=True, sharey=True, squeeze=False)[:, 0]
        for axes, actor in zip(rows, chosen, strict=False):
            _draw(axes, judged[judged["actor_id"] == actor])
            axes.set_title(f"vehicle {names[actor]}", fontsize=8)
        if not chosen:
            note(rows[0], "no confirmed track followed a graded vehicle for long")
        rows[-1].set(xlabel="time [s]", ylim=(STRIP[0] - 0.02, 1.02))
        lines = [Line2D([], [], color=color, label=f"probability of {model}") for model, color in colors.items()]
        patches = [Patch(facecolor=COLORS[mode], label=f"truly {mode}") for mode in MODELS]
        canvas.legend(handles=[*lines, *patches], loc="outside upper left", ncols=4)

    caption = (
        "Equation (12), for the vehicles with most changes of the true mode; strip and background show the true mode."
    )
    size = (10.0, 0.9 + 1.25 * max(len(chosen), 1))
    return Figure("probabilities", "Probability of each motion model", caption, size, on, wide=True)


def most_mode_changes(judged: pd.DataFrame) -> list[int]:
    """Return the vehicles with most changes of the true mode; of equal numbers, those followed longer come first."""
    mode = judged["true_mode"].cat.codes
    same = judged["actor_id"].eq(judged["actor_id"].shift())
    events = judged.assign(change=same & mode.ne(mode.shift())).groupby("actor_id")["change"].agg(["sum", "size"])
    ranked = events[events["size"] >= FRAMES_MIN].sort_values(["sum", "size"], ascending=False, kind="stable")
    return [int(actor) for actor in ranked.index[:VEHICLES]]


def _draw(axes: "Axes", rows: pd.DataFrame) -> None:
    time, mode = rows["time_s"].to_numpy(), rows["true_mode"].to_numpy()
    step = float(np.median(np.diff(time)))
    gaps = np.flatnonzero(np.diff(time) > 1.5 * step) + 1
    for part in np.split(np.arange(len(time)), gaps):
        for model, color in COLORS.items():
            if f"probability_{model}" not in rows:
                continue
            axes.plot(time[part], rows[f"probability_{model}"].to_numpy()[part], color=color, lw=1.3)
    changes = np.union1d(np.flatnonzero(mode[1:] != mode[:-1]) + 1, gaps)
    for part in np.split(np.arange(len(time)), changes):
        begin, end, color = time[part[0]], time[part[-1]] + step, COLORS[mode[part[0]]]
        axes.axvspan(begin, end, color=color, alpha=0.22, lw=0)
        axes.fill_between([begin, end], *STRIP, color=color, lw=0)


PICTURES, PICTURES_MOST = 8, 14
"""Number of bird's-eye pictures, and the largest one if many metrics failed."""


def run_page(folder: Path) -> Document:
    """Return the page of a run folder.

    Raises
    ------
    OutputError
        The folder has no run.
    """
    run = ReportedRun.read(folder)
    return run_document(run, run_figures(run))


def run_figures(run: ReportedRun) -> RunFigures:
    """Return the figures of a run."""
    result = run.result
    if "files" in result.config:
        return RunFigures(tracks=file_figures(result))
    shown, ego = shown_frames(result, run.worst, PICTURES, PICTURES_MOST), ego_poses(result)
    points = frame_points(run.folder, result, near(shown, ego))
    marked = list(shown.values())
    return RunFigures(
        pictures=birdseye([result], result.scenario, marked, points),
        player=player({"tracks": result}, ego, marked, points) if ego else None,
        fits=fit_figures(result),
        tracks=[timelines(result.tables["truth"], result.config["grading"]["hidden_fraction_max"])],
        models=[model_probabilities(result.tables["tracks"], result.tables["truth"])],
    )


def fit_figures(result: Result) -> list[Figure]:
    """Return the figures of fit errors."""
    observed = observations(result.tables["fits"], result.tables["truth"])
    against = [errors_against(observed, covariate) for covariate in COVARIATES]
    return [heading_distribution(result.tables["fits"]), *against, errors_by_class(observed)]
