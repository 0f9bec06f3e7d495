"""Picture of the animation: the map at the left, legend and close-up at the right."""

import io

import matplotlib.pyplot as plt
import numpy as np
from crossing_picture.layers import (
    CLOSE_UP,
    EGO,
    FAINT,
    FIT,
    HIDDEN,
    MAP,
    NIGHT,
    POINT,
    TEXT,
    TRACKS,
    TRUTH,
    draw_step,
    draw_town,
)  # fmt: skip
from crossing_picture.scene import SCENARIO, Step, heading_errors
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from PIL import Image

from luxloop.sim.world import Obstacles

MAP_M = (-26.0, 38.0, -39.0, 25.0)
"""West, east, south and north edge of the map, world frame [m]."""
CLOSE_UP_M = 3.4
"""Half the width of the close-up [m]."""
CLOSE_UP_OF = "s_n.17"
"""The actor in the close-up, by its name in SUMO."""


def picture(step: Step, obstacles: Obstacles) -> Image.Image:
    """Draw one frame."""
    figure = plt.figure(figsize=(9.6, 6.72), dpi=100, facecolor=NIGHT)
    town = add_axes(figure, (0.0, 0.0, 0.70, 1.0), framed=False)
    near = add_axes(figure, (0.715, 0.025, 0.27, 0.27 * 9.6 / 6.72), framed=True)
    draw_town(town, obstacles)
    draw_step(town, step, MAP)
    draw_step(near, step, CLOSE_UP)
    town.set(xlim=MAP_M[:2], ylim=MAP_M[2:])
    draw_scale(town)
    row = int(np.flatnonzero(step.frame.actors.name == CLOSE_UP_OF)[0])
    x, y, _ = step.frame.actors.pose_world[row]
    near.set(xlim=(x - CLOSE_UP_M, x + CLOSE_UP_M), ylim=(y - CLOSE_UP_M, y + CLOSE_UP_M))
    corner, side = (x - CLOSE_UP_M, y - CLOSE_UP_M), 2 * CLOSE_UP_M
    town.add_patch(plt.Rectangle(corner, side, side, fill=False, edgecolor=FAINT, linewidth=0.8, zorder=8))
    write_texts(figure, step.frame.time, heading_errors(step, row))
    draw_legend(figure)
    buffer = io.BytesIO()
    figure.savefig(buffer, facecolor=NIGHT)
    plt.close(figure)
    return Image.open(buffer).convert("RGB")


def add_axes(figure: Figure, place: tuple[float, float, float, float], *, framed: bool) -> Axes:
    """Add empty axes at a place (left, bottom, width, height) in fractions of the figure."""
    axes = figure.add_axes(place)
    axes.set(facecolor=NIGHT, xticks=[], yticks=[], aspect="equal")
    for spine in axes.spines.values():
        spine.set(color=FAINT, visible=framed)
    return axes


def write_texts(figure: Figure, time_s: float, errors_deg: dict[str, float]) -> None:
    """Write the title, the time and the heading errors."""
    left, right = 0.715, 0.985
    figure.text(left, 0.945, "luxloop", color=TEXT, fontsize=17, fontweight="bold")
    figure.text(left, 0.905, f"{SCENARIO} from above", color=TEXT, fontsize=10.5)
    figure.text(left, 0.875, f"{time_s:4.1f} s", color=FAINT, fontsize=10.5)
    figure.text(left, 0.495, "close-up", color=TEXT, fontsize=10.5)
    for y, (name, error_deg) in zip((0.46, 0.43), errors_deg.items(), strict=True):
        figure.text(left, y, f"heading error of the {name}", color=FAINT, fontsize=10)
        figure.text(right, y, f"{error_deg:.1f}\N{DEGREE SIGN}", color=FAINT, fontsize=10, ha="right")


def draw_legend(figure: Figure) -> None:
    """Explain the colours."""

    def line(color: str, name: str, **style: object) -> Line2D:
        return Line2D([], [], color=color, label=name, **style)

    entries = [
        line(EGO, "ego with six LIDARs", marker="s", linestyle="none", markersize=9),
        line(POINT, "LIDAR points on road users", marker="o", linestyle="none", markersize=4),
        line(FAINT, "LIDAR points on buildings", marker="o", linestyle="none", markersize=4),
        line(TRUTH, "true vehicle", linewidth=1.2),
        line(HIDDEN, "true vehicle, hidden", linewidth=1.2, linestyle=(0, (2, 1.5))),
        line(FIT, "rectangle fitted to one scan", linewidth=1.5),
        line(TRACKS[0], "track: id, speed, motion in 1 s", linewidth=2.6),
    ]
    figure.legend(
        handles=entries,
        loc="upper left",
        bbox_to_anchor=(0.712, 0.845),
        frameon=False,
        labelcolor=TEXT,
        fontsize=9.5,
        handlelength=1.6,
        labelspacing=0.62,
        borderpad=0,
    )


def draw_scale(axes: Axes) -> None:
    """Draw a bar of 10 m."""
    x, y = MAP_M[0] + 2.0, MAP_M[2] + 2.0
    axes.plot([x, x + 10.0], [y, y], color=TEXT, linewidth=2, zorder=9)
    axes.text(x + 5.0, y + 0.8, "10 m", color=TEXT, fontsize=8, ha="center", zorder=9)
