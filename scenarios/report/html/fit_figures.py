"""Figures of fit errors: heading errors by method, and errors against range, aspect and visible fraction."""

from collections.abc import Sequence
from itertools import pairwise
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
import pandas as pd

from scenarios.grading.metric_names import FIT_METHODS
from scenarios.grading.plane_geometry import wrap
from scenarios.report import paper_figures
from scenarios.report.html.palette import BLUE, FAINT, GREEN, INK, ORANGE, PURPLE, RED, SKY
from scenarios.report.html.svg_figure import Figure, draw, note
from scenarios.statistics.jackknife import POSITIVE, ratio_interval
from tracker.records import BASELINES

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
            axes.plot(range(1, 6), paper_figures.WITHIN[method], marker, color=color, mfc="none", ms=5, label=label)
        axes.set(xlim=(0, SHOWN_DEG), ylim=(0, 1.01), xlabel="|heading error| [deg]", ylabel="share at or below")
        canvas.legend(loc="outside lower center", ncols=2)

    caption = "Further left and higher is better. Oracle is the best possible selection."
    return draw("heading-cdf", "Heading error of single fits, by method", caption, (5.2, 4.9), on)


def observations(fits: pd.DataFrame, truth: pd.DataFrame) -> pd.DataFrame:
    """Return the selected rectangles with the covariates `range_m`, `aspect_deg` and `visible_fraction`.

    The aspect is the angle at the vehicle between its heading and the line to the ego, 0 to 180 degrees.
    """
    best = fits[fits["best"] & fits["heading_error_deg"].notna()]
    to_ego = np.arctan2(-best["true_y_ego_m"].to_numpy(), -best["true_x_ego_m"].to_numpy())
    aspect = np.degrees(np.abs(wrap(to_ego - best["true_yaw_ego_rad"].to_numpy())))
    seen = truth[["frame", "actor_id", "visible_fraction"]]
    return best.assign(aspect_deg=aspect).merge(seen, on=["frame", "actor_id"], validate="one_to_one")


def errors_against(observed: pd.DataFrame, covariate: Covariate) -> Figure:
    """Draw mean absolute errors of heading and corner by bins of a covariate, with 95 % intervals."""

    def on(canvas: "Canvas") -> None:
        heading, position = canvas.subplots(2, 1, sharex=True)
        counts = _means(heading, observed, covariate, observed["heading_error_deg"].abs(), BLUE)
        _means(position, observed, covariate, observed["position_error_m"], GREEN)
        heading.set_ylabel("heading [deg]")
        position.set_ylabel("nearest corner [m]")
        scale = 100 if covariate.percent else 1
        names = [f"{scale * low:g}-{scale * high:g}" for low, high in pairwise(covariate.edges)]
        labels = [f"{name}\nn={count}" for name, count in zip(names, counts, strict=True)]
        position.set_xticks(range(len(labels)), labels, fontsize=7.5)
        position.set_xlabel(covariate.label)

    caption = "Mean absolute error of the selected fits; whiskers are 95 % over vehicles, n counts fits."
    anchor = f"error-{covariate.name.split()[0]}"
    return draw(anchor, f"Error of fits against {covariate.name}", caption, (5.2, 3.9), on)


def _means(axes: "Axes", observed: pd.DataFrame, covariate: Covariate, error: pd.Series, color: str) -> list[int]:
    """Draw the mean of each bin, and return the number of observations in each bin."""
    # The last bin includes its upper edge; graded observations are never beyond it.
    place = np.searchsorted(covariate.edges[1:-1], observed[covariate.column].to_numpy(), side="right")
    counts = np.bincount(place, minlength=len(covariate.edges) - 1)
    for k in np.flatnonzero(counts).tolist():
        inside = place == k
        value, vehicle = error.to_numpy()[inside], observed["actor_id"].to_numpy()[inside]
        interval = ratio_interval(vehicle, value, np.ones_like(value), POSITIVE)
        axes.plot(k, value.mean(), "o", color=color, ms=5)
        if interval:
            axes.plot([k, k], interval, "-", color=color, lw=1.2)
    if not counts.any():
        note(axes, "no fits")
    axes.set(xlim=(-0.5, len(counts) - 0.5))
    axes.set_ylim(bottom=0.0)
    return [int(count) for count in counts]
