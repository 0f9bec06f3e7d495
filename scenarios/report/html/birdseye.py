"""Bird's-eye pictures of single frames, the ego heading up."""

from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd

from scenarios.arrays import Floats
from scenarios.grading.articulated import parts
from scenarios.grading.plane_geometry import CORNER_SIGNS, corner, into_frame
from scenarios.grading.worst_frames import IDENTITIES
from scenarios.report.html.palette import BLUE, FAINT, INK, MUTED, ORANGE, PAGE, RED, SKY
from scenarios.report.html.svg_figure import Figure, draw
from scenarios.result import Result
from sensor_model.truth import NO_ACTOR

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure as Canvas
    from matplotlib.patches import Polygon

NAMES = {
    "detection": "Missed or false",
    "identity": "Changed identity",
    "track_heading": "Heading of a track",
    "fit_heading": "Heading of a fit",
}
"""Titles by kind of snapshot, the most serious kind first."""

MARGIN_M = 8.0
"""Margin around the ego and the error [m]."""
REACH_M = (17.0, 45.0)
"""Least and largest half width of a picture [m]."""
GRID_M = 0.1
"""Grid on which points are merged for drawing [m]."""
POSE_WORLD = ["x_world_m", "y_world_m", "yaw_world_rad"]
EGO_WORLD = ["ego_x_world_m", "ego_y_world_m", "ego_yaw_world_rad"]
SIZE = ["length_m", "width_m"]


def birdseye(result: Result, name: str, failed: list[str], most: int = 8) -> list[Figure]:
    """Draw the worst frames of a run: first those that explain failed metrics, then the others by rank within a kind.

    Parameters
    ----------
    name
        Prefix of the figures' anchors.
    failed
        Names of failed metrics.
    most
        Maximum number of figures.
    """
    if "snapshots" not in result.tables:  # an older run, graded again
        return []
    snapshots = result.tables["snapshots"]
    wanted = snapshots["kind"].isin([kind_of(metric) for metric in failed])
    rank = snapshots.groupby("kind", observed=True).cumcount() - len(snapshots) * wanted
    ordered = snapshots.loc[rank.sort_values(kind="stable").index]
    return [_picture(result, name, row) for _, row in ordered.head(most).iterrows()]


def kind_of(metric: str) -> str:
    """Return the kind of snapshot that best explains a bad metric."""
    if metric.startswith("fit."):
        return "fit_heading"
    if metric.startswith("track.heading"):
        return "track_heading"
    return "identity" if metric.removeprefix("track.") in IDENTITIES else "detection"


def _picture(result: Result, name: str, snapshot: pd.Series) -> Figure:
    at_frame = {name: table[table["frame"] == snapshot["frame"]] for name, table in result.tables.items()}
    ego = snapshot[EGO_WORLD].to_numpy(np.float64)

    def on(canvas: "Canvas") -> None:
        canvas.set_layout_engine("none")
        axes = canvas.add_axes((0.004, 0.004, 0.992, 0.992))
        _set_view(axes, snapshot)
        _points(axes, at_frame["snapshot_points"])
        _truth(axes, at_frame["truth"], ego)
        _fits(axes, at_frame["fits"])
        _tracks(axes, at_frame["tracks"], ego)
        _ego(axes, snapshot)

    anchor = f"{name}-{snapshot['kind']}-{snapshot['frame']}"
    caption = f"Frame {snapshot['frame']}, {snapshot['time_s']:.2f} s: {snapshot['what']}."
    return draw(anchor, NAMES[snapshot["kind"]], caption, (4.5, 4.5), on)


def _to_canvas(ego_frame: Floats) -> Floats:
    """Rotate (..., 2) from forward and left to right and up."""
    return np.stack([-ego_frame[..., 1], ego_frame[..., 0]], axis=-1)


def _set_view(axes: "Axes", snapshot: pd.Series) -> None:
    """Set the limits to show the ego and the error, and draw a scale bar and a ring around the error."""
    place = _to_canvas(snapshot[["x_ego_m", "y_ego_m"]].to_numpy(np.float64))
    middle = 0.5 * place
    reach = float(np.clip(np.abs(middle).max() + MARGIN_M, *REACH_M))
    axes.set(xlim=(middle[0] - reach, middle[0] + reach), ylim=(middle[1] - reach, middle[1] + reach), aspect="equal")
    axes.set(xticks=[], yticks=[])
    axes.spines[:].set(visible=True, color=FAINT, linewidth=0.6)
    axes.plot(*place, "o", ms=46, mfc="none", mec=RED, mew=1.0, alpha=0.75)
    left, low = middle - 0.94 * reach
    axes.plot([left, left + 10.0], [low, low], color=INK, lw=2.0, solid_capstyle="butt")
    axes.text(left, low + 0.03 * reach, "10 m", fontsize=8, color=INK)


def _points(axes: "Axes", points: pd.DataFrame) -> None:
    """Draw points: grey on the background, blue on actors, red for noise."""
    from matplotlib.patches import PathPatch
    from matplotlib.path import Path as Line

    noise = points["cause"] != "clean"
    on_actor = points["actor_id"] != NO_ACTOR
    for rows, color, width in (
        (points[~noise & ~on_actor], FAINT, 1.1),
        (points[~noise & on_actor], SKY, 1.7),
        (points[noise], RED, 2.0),
    ):
        at = _to_canvas(rows[["x_ego_m", "y_ego_m"]].to_numpy(np.float64))
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
    return _to_canvas(corner(boxes[:, None, :], np.broadcast_to(CORNER_SIGNS, (len(boxes), 4, 2))))


def _truth(axes: "Axes", truth: pd.DataFrame, ego: Floats) -> None:
    """Draw true boxes in thin lines with the actor's id, dashed if not graded."""
    pose = into_frame(truth[POSE_WORLD].to_numpy(np.float64), ego)
    row, poses, sizes = parts(pose, truth[SIZE].to_numpy(np.float64), truth["articulation_rad"].to_numpy())
    graded = truth["graded"].to_numpy()
    for k, outline in zip(row, _outlines(np.hstack([poses, sizes])), strict=True):
        color, line = (INK, "-") if graded[k] else (MUTED, (0, (3, 2)))
        axes.add_patch(_polygon(outline, fill=False, edgecolor=color, linestyle=line, linewidth=1.0))
    for at, actor, counts in zip(_to_canvas(pose[:, :2]), truth["actor_id"], graded, strict=True):
        if counts:
            axes.text(at[0], at[1], str(actor), color=INK, fontsize=7.5, ha="center", va="center", clip_on=True)


def _fits(axes: "Axes", fits: pd.DataFrame) -> None:
    """Draw the selected rectangles of graded vehicles."""
    best = fits[fits["best"] & fits["heading_error_deg"].notna()]
    boxes = best[["x_ego_m", "y_ego_m", "heading_ego_rad", *SIZE]].to_numpy(np.float64)
    for outline in _outlines(boxes):
        axes.add_patch(_polygon(outline, fill=False, edgecolor=ORANGE, linewidth=1.5))


def _tracks(axes: "Axes", tracks: pd.DataFrame, ego: Floats) -> None:
    """Draw confirmed tracks in thick lines with front and id, false ones in red; coasting tracks dashed."""
    boxes = np.hstack([into_frame(tracks[POSE_WORLD].to_numpy(np.float64), ego), tracks[SIZE].to_numpy(np.float64)])
    rows = zip(_outlines(boxes), tracks["track_id"], tracks["status"], tracks["verdict"], strict=True)
    for outline, track, status, verdict in rows:
        if status not in ("confirmed", "coasting"):
            continue
        color = RED if verdict == "false" else BLUE
        solid = status == "confirmed"
        line = "-" if solid else (0, (2, 2))
        axes.add_patch(_polygon(outline, fill=False, edgecolor=color, linestyle=line, linewidth=2.2 if solid else 1.2))
        if solid:
            front, middle = outline[[0, 3]].mean(axis=0), outline.mean(axis=0)
            ahead = front + (front - middle) / np.linalg.norm(front - middle) * 2.0
            axes.plot(*np.column_stack([front, ahead]), color=color, lw=2.2)
            axes.annotate(
                f"t{track}", ahead, color=color, fontsize=8, ha="center", va="center", weight="bold",
                xytext=6.0 * (ahead - front) / 2.0, textcoords="offset points", clip_on=True,
            )  # fmt: skip


def _ego(axes: "Axes", snapshot: pd.Series) -> None:
    box = np.array([[0.0, 0.0, 0.0, snapshot["ego_length_m"], snapshot["ego_width_m"]]])
    axes.add_patch(_polygon(_outlines(box)[0], facecolor=INK, edgecolor=INK))
    axes.text(0.0, 0.0, "ego", color=PAGE, fontsize=7, ha="center", va="center", clip_on=True)


def _polygon(outline: Floats, **style: Any) -> "Polygon":
    """Return a box with corners (4, 2)."""
    from matplotlib.patches import Polygon

    return Polygon(outline, **style)
