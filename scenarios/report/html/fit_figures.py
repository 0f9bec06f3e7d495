"""How far fitted headings and corners are off: by method, and by how a vehicle is seen."""

from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure as Canvas

from scenarios.grading.bootstrap import Bootstrap
from scenarios.grading.metric_names import FIT_METHODS
from scenarios.grading.plane_geometry import wrap
from scenarios.report import paper_figures
from scenarios.report.html.palette import BLUE, FAINT, GREEN, INK, ORANGE, PURPLE, RED, SKY
from scenarios.report.html.svg_figure import Figure, draw, note
from tracker.records import BASELINES

SHOWN_DEG = 10.0
"""Where the axis of heading errors ends: few are larger, and the legend tells how many."""

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
"""Colour and line of each; baselines share a colour."""

WIDTHS = {"best": 2.4}
"""Of lines that are not as thin as the others [points]."""


class Against(NamedTuple):
    """Something that the error may depend on."""

    name: str
    label: str
    """Of the axis."""
    column: str
    edges: Sequence[float]
    percent: bool = False


AGAINST = (
    Against("range", "range [m]", "range_m", (0, 10, 20, 30, 40, 50)),
    Against("aspect", "aspect [deg]: 0 seen from ahead, 180 from behind", "aspect_deg", (0, 30, 60, 90, 120, 150, 180)),
    Against("visible fraction", "visible fraction [%]", "visible_fraction", (0, 0.2, 0.4, 0.6, 0.8, 1), percent=True),
)


def heading_distribution(fits: pd.DataFrame) -> Figure:
    """Cumulative distribution of the absolute heading error of each method."""

    def on(canvas: Canvas) -> None:
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

    caption = "Further left and higher is better. Oracle is the best choice that the selection could have made."
    return draw("heading-cdf", "Heading error of single fits, by method", caption, (5.2, 4.9), on)


def observations(fits: pd.DataFrame, truth: pd.DataFrame) -> pd.DataFrame:
    """Selected rectangles with what their errors may depend on: `range_m`, `aspect_deg` and `visible_fraction`.

    The aspect is the angle at the vehicle between its heading and the line to the ego, 0 to 180 degrees.
    """
    best = fits[fits["best"] & fits["heading_error_deg"].notna()]
    to_ego = np.arctan2(-best["true_y_ego_m"].to_numpy(), -best["true_x_ego_m"].to_numpy())
    aspect = np.degrees(np.abs(wrap(to_ego - best["true_yaw_ego_rad"].to_numpy())))
    seen = truth[["frame", "actor_id", "visible_fraction"]]
    return best.assign(aspect_deg=aspect).merge(seen, on=["frame", "actor_id"], validate="one_to_one")


def errors_against(observed: pd.DataFrame, what: Against) -> Figure:
    """Mean absolute errors of heading and corner by bins of `what`, with their intervals."""

    def on(canvas: Canvas) -> None:
        heading, position = canvas.subplots(2, 1, sharex=True)
        counts = _bars(heading, observed, what, observed["heading_error_deg"].abs(), BLUE)
        _bars(position, observed, what, observed["position_error_m"], GREEN)
        heading.set_ylabel("heading [deg]")
        position.set_ylabel("nearest corner [m]")
        scale = 100 if what.percent else 1
        names = [f"{scale * low:g}-{scale * high:g}" for low, high in pairwise(what.edges)]
        labels = [f"{name}\nn={count}" for name, count in zip(names, counts, strict=True)]
        position.set_xticks(range(len(labels)), labels, fontsize=7.5)
        position.set_xlabel(what.label)

    caption = "Mean absolute error of the selected fits; whiskers are 95 % by a bootstrap over vehicles, n counts fits."
    return draw(f"error-{what.name.split()[0]}", f"Error of fits against {what.name}", caption, (5.2, 3.9), on)


def _bars(axes: Axes, observed: pd.DataFrame, what: Against, error: pd.Series, color: str) -> list[int]:
    """Draw the mean of each bin, and return how many observations are in it."""
    # The last bin holds its upper edge; nothing graded is beyond it.
    place = np.searchsorted(what.edges[1:-1], observed[what.column].to_numpy(), side="right")
    bootstrap = Bootstrap(observed["actor_id"].to_numpy())
    counts = np.bincount(place, minlength=len(what.edges) - 1)
    for k in np.flatnonzero(counts).tolist():
        inside = place == k
        value, vehicle = error.to_numpy()[inside], observed["actor_id"].to_numpy()[inside]
        interval = bootstrap.of_ratio(vehicle, value, np.ones_like(value))
        axes.plot(k, value.mean(), "o", color=color, ms=5)
        if interval:
            axes.plot([k, k], interval, "-", color=color, lw=1.2)
    if not counts.any():
        note(axes, "no fits")
    axes.set(xlim=(-0.5, len(counts) - 0.5))
    axes.set_ylim(bottom=0.0)
    return [int(count) for count in counts]
