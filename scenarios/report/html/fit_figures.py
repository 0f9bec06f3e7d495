"""Figure of the distributions of the fit heading error, by method."""

from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from luxloop.scenarios.document.figure import Figure
from luxloop.scenarios.document.palette import BLUE, FAINT, GREEN, INK, ORANGE, PURPLE, RED, SKY
from luxloop.scenarios.metrics.definitions import FIT_METHODS
from luxloop.scenarios.report import paper_figures
from luxloop.tracker.records import BASELINES

if TYPE_CHECKING:
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
            axes.plot(range(1, 6), paper_figures.WITHIN[method], marker, color=color, mfc="none", ms=5, label=label)
        axes.set(
            xlim=(0, SHOWN_DEG),
            ylim=(0, 1.01),
            xlabel="|fit heading error| [deg], modulo 90",
            ylabel="share at or below",
        )
        canvas.legend(loc="outside lower center", ncols=2)

    caption = "Further left and higher is better. Oracle is the best possible selection."
    return Figure("heading-cdf", "Fit heading error, by method", caption, (5.2, 4.9), on)
