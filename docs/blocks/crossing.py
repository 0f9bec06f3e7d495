"""Animation of the README: the scenario `sumo-crossing` from above, with LIDAR points, fits and tracks.

The map is at the left, legend and close-up at the right.
"""

import io
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from blocks import crossing_layers as layers
from blocks.steps import Step, steps
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Rectangle
from PIL import Image

from luxloop.arrays import Floats
from luxloop.scenarios.files.shipped import find
from luxloop.scenarios.grading.plane_geometry import QUARTER, wrap

PICTURE = Path(__file__).parents[1] / "pictures" / "crossing.gif"
SCENARIO = "sumo-crossing"
BEGIN_S, END_S = 22.7, 30.3
"""The light turns green, the queue starts, and the ego crosses [s]."""
EVERY = 2
"""Frames from one picture to the next."""
PICTURE_MS = 160
"""Time that a picture is shown: real time [ms]."""
COLORS = 128
MAP_M = (-26.0, 38.0, -39.0, 25.0)
"""West, east, south and north edge of the map, world frame [m]."""
CLOSE_UP_M = 3.4
"""Half the width of the close-up [m]."""
CLOSE_UP_OF = "s_n.17"
"""The actor in the close-up, by its name in SUMO."""
LEGEND = (
    (layers.EGO, "ego with six LIDARs", {"marker": "s", "linestyle": "none", "markersize": 9}),
    (layers.POINT, "LIDAR points on road users", {"marker": "o", "linestyle": "none", "markersize": 4}),
    (layers.FAINT, "LIDAR points on buildings", {"marker": "o", "linestyle": "none", "markersize": 4}),
    (layers.TRUTH, "true vehicle", {"linewidth": 1.2}),
    (layers.HIDDEN, "true vehicle, hidden", {"linewidth": 1.2, "linestyle": layers.DASHES}),
    (layers.FIT, "rectangle fitted to one scan", {"linewidth": 1.5}),
    (layers.TRACKS[0], "track: id, speed, motion in 1 s", {"linewidth": 2.6}),
)


def draw(_name: str) -> None:
    """Write the animation; half a minute."""
    shown = [step for step in steps(find(SCENARIO), END_S) if step.frame.time >= BEGIN_S]
    pictures = [picture(step) for step in shown[::EVERY]]
    sample = Image.new("RGB", (pictures[0].width, 3 * pictures[0].height))
    for n, index in enumerate((0, len(pictures) // 2, -1)):
        sample.paste(pictures[index], (0, n * pictures[0].height))
    palette = sample.quantize(COLORS, method=Image.Quantize.MAXCOVERAGE, kmeans=3)  # one for all, for a small file
    first, *rest = [image.quantize(palette=palette, dither=Image.Dither.NONE) for image in pictures]
    first.save(PICTURE, save_all=True, append_images=rest, duration=PICTURE_MS, loop=0, optimize=True)


def picture(step: Step) -> Image.Image:
    """Draw one frame."""
    figure = plt.figure(figsize=(9.6, 6.72), dpi=100, facecolor=layers.NIGHT)
    town = add_axes(figure, (0.0, 0.0, 0.70, 1.0), framed=False)
    near = add_axes(figure, (0.715, 0.025, 0.27, 0.27 * 9.6 / 6.72), framed=True)
    layers.draw_town(town, step.obstacles, SCENARIO)
    layers.draw_step(town, step, layers.MAP)
    layers.draw_step(near, step, layers.CLOSE_UP)
    town.set(xlim=MAP_M[:2], ylim=MAP_M[2:])
    draw_scale(town)
    (row,) = np.flatnonzero(step.frame.actors.name == CLOSE_UP_OF)
    pose = step.frame.actors.pose_world[row]
    x, y = pose[:2] - CLOSE_UP_M
    side = 2 * CLOSE_UP_M
    near.set(xlim=(x, x + side), ylim=(y, y + side))
    town.add_patch(Rectangle((x, y), side, side, fill=False, edgecolor=layers.FAINT, linewidth=0.8, zorder=8))
    write_texts(figure, step, pose)
    figure.legend(
        handles=[Line2D([], [], color=color, label=name, **style) for color, name, style in LEGEND],
        loc="upper left",
        bbox_to_anchor=(0.712, 0.845),
        frameon=False,
        labelcolor=layers.TEXT,
        fontsize=9.5,
        handlelength=1.6,
        labelspacing=0.62,
        borderpad=0,
    )
    buffer = io.BytesIO()
    figure.savefig(buffer, facecolor=layers.NIGHT)
    plt.close(figure)
    return Image.open(buffer).convert("RGB")


def add_axes(figure: Figure, place: tuple[float, float, float, float], *, framed: bool) -> Axes:
    """Add empty axes at a place (left, bottom, width, height) in fractions of the figure."""
    axes = figure.add_axes(place)
    axes.set(facecolor=layers.NIGHT, xticks=[], yticks=[], aspect="equal")
    axes.spines[:].set(color=layers.FAINT, visible=framed)
    return axes


def write_texts(figure: Figure, step: Step, pose: Floats) -> None:
    """Write title and time, and the heading errors of the nearest fit, modulo 90 degrees, and the nearest track."""
    left, right = 0.715, 0.985
    figure.text(left, 0.945, "luxloop", color=layers.TEXT, fontsize=17, fontweight="bold")
    figure.text(left, 0.905, f"{SCENARIO} from above", color=layers.TEXT, fontsize=10.5)
    figure.text(left, 0.875, f"{step.frame.time:4.1f} s", color=layers.FAINT, fontsize=10.5)
    figure.text(left, 0.495, "close-up", color=layers.TEXT, fontsize=10.5)
    errors = {
        "fit": heading_error(layers.fit_poses(step), pose, QUARTER),
        "track": heading_error(layers.track_poses(step), pose, 2 * np.pi),
    }
    for y, (name, error) in zip((0.46, 0.43), errors.items(), strict=True):
        figure.text(left, y, f"heading error of the {name}", color=layers.FAINT, fontsize=10)
        text = f"{np.degrees(error):.1f}\N{DEGREE SIGN}"
        figure.text(right, y, text, color=layers.FAINT, fontsize=10, ha="right")


def heading_error(poses: Floats, truth: Floats, period: float) -> float:
    """Return the absolute heading error of the pose nearest to the truth [rad]."""
    nearest = poses[np.linalg.norm(poses[:, :2] - truth[:2], axis=1).argmin()]
    return float(abs(wrap(nearest[2] - truth[2], period)))


def draw_scale(axes: Axes) -> None:
    """Draw a bar of 10 m."""
    x, y = MAP_M[0] + 2.0, MAP_M[2] + 2.0
    axes.plot([x, x + 10.0], [y, y], color=layers.TEXT, linewidth=2, zorder=9)
    axes.text(x + 5.0, y + 0.8, "10 m", color=layers.TEXT, fontsize=8, ha="center", zorder=9)
