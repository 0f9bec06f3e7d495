"""Figure of the distributions of fit and track headings of several trackers."""

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from luxloop.scenarios.arrays import Floats
from luxloop.scenarios.document.figure import Figure, note
from luxloop.scenarios.document.palette import TEXT_SERIES
from luxloop.scenarios.result import Result
from luxloop.tracker.records import MODELS

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure as Canvas

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
