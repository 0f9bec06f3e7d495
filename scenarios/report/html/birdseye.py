"""Bird's-eye pictures of single frames, the ego heading up."""

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from luxloop.scenarios.arrays import Floats
from luxloop.scenarios.document.figure import Figure
from luxloop.scenarios.document.palette import BAD, FAINT, INK, RED, TEXT_SERIES
from luxloop.scenarios.report.html import birdseye_layers as layers
from luxloop.scenarios.report.html.shown_frames import ShownFrame, ego_poses
from luxloop.scenarios.result import Result

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure as Canvas

MARGIN_M = 8.0
"""Margin around the ego and the error [m]."""
REACH_M = (17.0, 45.0)
"""Least and largest half width of a picture [m]."""
TITLES = 2
"""Largest number of metrics in a title."""


def birdseye(results: Sequence[Result], name: str, frames: Iterable[ShownFrame], points: pd.DataFrame) -> list[Figure]:
    """Draw frames of one run, or of several trackers on the same drive.

    Parameters
    ----------
    results
        The runs; the tracks of several ones have the colours of their trackers, and no fits are drawn.
    name
        Prefix of the figures' anchors, see `anchor`.
    points
        Points of the frames, see `frame_points`.
    """
    poses = ego_poses(max(results, key=lambda result: result.frames))
    return [_picture(results, name, shown, poses[shown.frame], points) for shown in frames if shown.frame in poses]


def anchor(name: str, frame: int) -> str:
    """Return the anchor of the picture of a frame."""
    return f"{name}-frame-{frame}"


def _picture(results: Sequence[Result], name: str, shown: ShownFrame, ego: Floats, points: pd.DataFrame) -> Figure:
    rows = [
        {key: result.tables[key][result.tables[key]["frame"] == shown.frame] for key in ("truth", "fits", "tracks")}
        for result in results
    ]
    of_frame = points[points["frame"] == shown.frame]

    def on(canvas: "Canvas") -> None:
        canvas.set_layout_engine("none")
        axes = canvas.add_axes((0.004, 0.004, 0.992, 0.992))
        _set_view(axes, shown.places_ego)
        layers.draw_points(axes, of_frame)
        layers.draw_truth(axes, rows[0]["truth"], ego[:3])
        if len(rows) == 1:
            layers.draw_fits(axes, rows[0]["fits"])
        for number, of_tracker in enumerate(rows):
            color = TEXT_SERIES[number % len(TEXT_SERIES)]
            wrong, width = (BAD, 2.2) if len(rows) == 1 else (color, 2.0 + 1.4 * (len(rows) - 1 - number))
            layers.draw_tracks(axes, of_tracker["tracks"], ego[:3], (color, wrong), width)
        layers.draw_ego(axes, ego[3:])

    without = "" if len(of_frame) else " The run did not keep the points of this frame."
    caption = f"Frame {shown.frame}, {shown.time_s:.2f} s: {'; '.join(shown.errors)}.{without}"
    more = f" and {len(shown.titles) - TITLES} more" if len(shown.titles) > TITLES else ""
    title = ", ".join(shown.titles[:TITLES]) + more
    return Figure(anchor(name, shown.frame), title, caption, (4.5, 4.5), on, frame=shown.frame)


def _set_view(axes: "Axes", places_ego: list[Floats]) -> None:
    """Set the limits to show the ego and the nearest error, and draw a scale bar and rings around the errors."""
    places = layers.to_canvas(np.reshape(places_ego, (-1, 2)))
    middle = 0.5 * places[np.hypot(*places.T).argmin()] if len(places) else np.zeros(2)
    reach = float(np.clip(np.abs(middle).max() + MARGIN_M, *REACH_M))
    axes.set(xlim=(middle[0] - reach, middle[0] + reach), ylim=(middle[1] - reach, middle[1] + reach), aspect="equal")
    axes.set(xticks=[], yticks=[])
    axes.spines[:].set(visible=True, color=FAINT, linewidth=0.6)
    axes.plot(*places.T, "o", ms=46, mfc="none", mec=RED, mew=1.0)
    left, low = middle - 0.94 * reach
    axes.plot([left, left + 10.0], [low, low], color=INK, lw=2.0, solid_capstyle="butt")
    axes.text(left, low + 0.03 * reach, "10 m", fontsize=8, color=INK)
