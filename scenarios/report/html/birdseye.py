"""Bird's-eye pictures of single frames, the ego heading up."""

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd

from luxloop.arrays import Floats
from luxloop.scenarios.document.figure import Figure
from luxloop.scenarios.document.palette import BAD, FAINT, INK, MUTED, ORANGE, PAGE, RED, SKY, TEXT_SERIES
from luxloop.scenarios.grading.articulated import angles_of, kinds_of, parts
from luxloop.scenarios.grading.plane_geometry import CORNER_SIGNS, corner, into_frame
from luxloop.scenarios.report.html.shown_frames import POSE_WORLD, ShownFrame, ego_poses
from luxloop.scenarios.result import Result

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure as Canvas
    from matplotlib.patches import Polygon


GRID_M = 0.1
"""Grid on which points are merged for drawing [m]."""
SIZE = ["length_m", "width_m"]


def to_canvas(ego_frame: Floats) -> Floats:
    """Rotate (..., 2) from forward and left to right and up."""
    return np.stack([-ego_frame[..., 1], ego_frame[..., 0]], axis=-1)


def draw_points(axes: "Axes", points: pd.DataFrame) -> None:
    """Draw points: grey on the background, blue on actors, red for noise."""
    from matplotlib.patches import PathPatch
    from matplotlib.path import Path as Line

    noise, on_actor = points["noise"].to_numpy(bool), points["on_actor"].to_numpy(bool)
    for rows, color, width in (
        (points[~noise & ~on_actor], FAINT, 1.1),
        (points[~noise & on_actor], SKY, 1.7),
        (points[noise], RED, 2.0),
    ):
        at = to_canvas(rows[["x_ego_m", "y_ego_m"]].to_numpy(np.float64))
        (left, right), (low, high) = axes.get_xlim(), axes.get_ylim()
        inside = (left < at[:, 0]) & (at[:, 0] < right) & (low < at[:, 1]) & (at[:, 1] < high)
        dots = GRID_M * np.unique(np.round(at[inside] / GRID_M), axis=0)
        if len(dots):
            # A stroke of length zero with round ends is the shortest SVG for a dot.
            codes = np.tile([Line.MOVETO, Line.LINETO], len(dots))
            path = Line(np.repeat(dots, 2, axis=0), codes)
            path.should_simplify = False
            axes.add_patch(PathPatch(path, fill=False, edgecolor=color, linewidth=width, capstyle="round"))


def _outlines(boxes: Floats) -> Floats:
    """(N, 4, 2) corners of boxes (N, 5) in the ego frame, in drawing coordinates."""
    return to_canvas(corner(boxes[:, None, :], np.broadcast_to(CORNER_SIGNS, (len(boxes), 4, 2))))


def draw_truth(axes: "Axes", truth: pd.DataFrame, ego: Floats) -> None:
    """Draw true boxes in thin lines with a wedge at their front and the vehicle's name, dashed if not graded."""
    pose = into_frame(truth[POSE_WORLD].to_numpy(np.float64), ego)
    bend, kind = angles_of(truth), kinds_of(truth["kind"])
    row, poses, sizes = parts(pose, truth[SIZE].to_numpy(np.float64), bend, kind)
    graded = truth["graded"].to_numpy()
    for k, outline in zip(row, _outlines(np.hstack([poses, sizes])), strict=True):
        color, line = (INK, "-") if graded[k] else (MUTED, (0, (3, 2)))
        axes.add_patch(_polygon(outline, fill=False, edgecolor=color, linestyle=line, linewidth=1.0))
        axes.plot(*wedge(outline).T, color=color, lw=1.0)
    for at, name, counts in zip(to_canvas(pose[:, :2]), truth["name"], graded, strict=True):
        if counts:
            axes.text(at[0], at[1], name, color=INK, fontsize=7.0, ha="center", va="center", clip_on=True)


def wedge(outline: Floats) -> Floats:
    """Return the mark (3, 2) at the front of a box with corners (4, 2): from one front corner inwards to the other."""
    left, rear_left, rear_right, right = outline
    inwards = 0.25 * np.linalg.norm(right - left) / np.linalg.norm(rear_left - left)
    inner = 0.5 * (left + right) + inwards * (0.5 * (rear_left + rear_right) - 0.5 * (left + right))
    return np.array([left, inner, right])


def draw_fits(axes: "Axes", fits: pd.DataFrame) -> None:
    """Draw the selected rectangles of graded vehicles."""
    best = fits[fits["best"] & fits["heading_error_deg"].notna()]
    boxes = best[["x_ego_m", "y_ego_m", "heading_ego_rad", *SIZE]].to_numpy(np.float64)
    for outline in _outlines(boxes):
        axes.add_patch(_polygon(outline, fill=False, edgecolor=ORANGE, linewidth=1.5))


def draw_tracks(axes: "Axes", tracks: pd.DataFrame, ego: Floats, colors: tuple[str, str], width: float) -> None:
    """Draw confirmed tracks with front and id, coasting ones dashed, false ones in the second of the colours."""
    boxes = np.hstack([into_frame(tracks[POSE_WORLD].to_numpy(np.float64), ego), tracks[SIZE].to_numpy(np.float64)])
    rows = zip(_outlines(boxes), tracks["track_id"], tracks["status"], tracks["verdict"], strict=True)
    for outline, track, status, verdict in rows:
        if status not in ("confirmed", "coasting"):
            continue
        color = colors[verdict == "false"]
        solid = status == "confirmed"
        line = "-" if solid else (0, (2, 2))
        axes.add_patch(
            _polygon(outline, fill=False, edgecolor=color, linestyle=line, linewidth=width if solid else 1.2)
        )
        if solid:
            front, middle = outline[[0, 3]].mean(axis=0), outline.mean(axis=0)
            ahead = front + (front - middle) / np.linalg.norm(front - middle) * 2.0
            axes.plot(*np.column_stack([front, ahead]), color=color, lw=2.2)
            axes.annotate(
                f"t{track}", ahead, color=color, fontsize=8, ha="center", va="center", weight="bold",
                xytext=6.0 * (ahead - front) / 2.0, textcoords="offset points", clip_on=True,
            )  # fmt: skip


def draw_ego(axes: "Axes", size: Floats) -> None:
    """Draw the ego with `size` (2,), length and width [m], at the origin."""
    box = np.array([[0.0, 0.0, 0.0, *size]])
    axes.add_patch(_polygon(_outlines(box)[0], facecolor=INK, edgecolor=INK))
    axes.text(0.0, 0.0, "ego", color=PAGE, fontsize=7, ha="center", va="center", clip_on=True)


def _polygon(outline: Floats, **style: Any) -> "Polygon":
    """Return a box with corners (4, 2)."""
    from matplotlib.patches import Polygon

    return Polygon(outline, **style)


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
        draw_points(axes, of_frame)
        draw_truth(axes, rows[0]["truth"], ego[:3])
        if len(rows) == 1:
            draw_fits(axes, rows[0]["fits"])
        for number, of_tracker in enumerate(rows):
            color = TEXT_SERIES[number % len(TEXT_SERIES)]
            wrong, width = (BAD, 2.2) if len(rows) == 1 else (color, 2.0 + 1.4 * (len(rows) - 1 - number))
            draw_tracks(axes, of_tracker["tracks"], ego[:3], (color, wrong), width)
        draw_ego(axes, ego[3:])

    without = "" if len(of_frame) else " The run did not keep the points of this frame."
    caption = f"Frame {shown.frame}, {shown.time_s:.2f} s: {'; '.join(shown.errors)}.{without}"
    more = f" and {len(shown.titles) - TITLES} more" if len(shown.titles) > TITLES else ""
    title = ", ".join(shown.titles[:TITLES]) + more
    return Figure(anchor(name, shown.frame), title, caption, (4.5, 4.5), on, frame=shown.frame)


def _set_view(axes: "Axes", places_ego: list[Floats]) -> None:
    """Set the limits to show the ego and the nearest error, and draw a scale bar and rings around the errors."""
    places = to_canvas(np.reshape(places_ego, (-1, 2)))
    middle = 0.5 * places[np.hypot(*places.T).argmin()] if len(places) else np.zeros(2)
    reach = float(np.clip(np.abs(middle).max() + MARGIN_M, *REACH_M))
    axes.set(xlim=(middle[0] - reach, middle[0] + reach), ylim=(middle[1] - reach, middle[1] + reach), aspect="equal")
    axes.set(xticks=[], yticks=[])
    axes.spines[:].set(visible=True, color=FAINT, linewidth=0.6)
    axes.plot(*places.T, "o", ms=46, mfc="none", mec=RED, mew=1.0)
    left, low = middle - 0.94 * reach
    axes.plot([left, left + 10.0], [low, low], color=INK, lw=2.0, solid_capstyle="butt")
    axes.text(left, low + 0.03 * reach, "10 m", fontsize=8, color=INK)
