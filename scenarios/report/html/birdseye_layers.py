"""Layers of a bird's-eye picture: points, true boxes, fitted boxes, tracks and the ego, the ego heading up."""

from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd

from luxloop.scenarios.arrays import Floats
from luxloop.scenarios.document.palette import FAINT, INK, MUTED, ORANGE, PAGE, RED, SKY
from luxloop.scenarios.grading.articulated import angles_of, kinds_of, parts
from luxloop.scenarios.grading.plane_geometry import CORNER_SIGNS, corner, into_frame
from luxloop.scenarios.report.html.shown_frames import POSE_WORLD

if TYPE_CHECKING:
    from matplotlib.axes import Axes
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
    """Draw true boxes in thin lines with the vehicle's name, dashed if not graded."""
    pose = into_frame(truth[POSE_WORLD].to_numpy(np.float64), ego)
    bend, kind = angles_of(truth), kinds_of(truth["kind"])
    row, poses, sizes = parts(pose, truth[SIZE].to_numpy(np.float64), bend, kind)
    graded = truth["graded"].to_numpy()
    for k, outline in zip(row, _outlines(np.hstack([poses, sizes])), strict=True):
        color, line = (INK, "-") if graded[k] else (MUTED, (0, (3, 2)))
        axes.add_patch(_polygon(outline, fill=False, edgecolor=color, linestyle=line, linewidth=1.0))
    for at, name, counts in zip(to_canvas(pose[:, :2]), truth["name"], graded, strict=True):
        if counts:
            axes.text(at[0], at[1], name, color=INK, fontsize=7.0, ha="center", va="center", clip_on=True)


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
