"""Draw one scan of the scenario `ring` in plan, and one of its cars with the fitted rectangles."""

from collections import deque
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from blocks.steps import Step, steps
from matplotlib.axes import Axes
from matplotlib.patches import Polygon

from luxloop.arrays import Floats
from luxloop.scenarios.files.shipped import find
from luxloop.scenarios.grading.plane_geometry import CORNER_SIGNS, corner
from luxloop.sensor_model.truth import Cause
from luxloop.tracker.records import METHODS

PICTURE = Path(__file__).parents[1] / "pictures" / "scan.png"
AT_S, CAR = 2.16, 2
"""Time at which two sides, the mirrors and the windscreen of the car with this id are visible."""
METHOD_COLORS = ("tab:red", "tab:green", "tab:blue", "tab:purple", "tab:cyan")
COLORS = {Cause.CLEAN: "black", Cause.MIRROR: "magenta", Cause.LAYER_OVERLAP: "darkorange"}


def draw(_name: str) -> None:
    """Write the picture; the ego of the scenario is at the origin, so that ego and world frame coincide."""
    (step,) = deque(steps(find("ring"), AT_S), maxlen=1)
    figure, (left, right) = plt.subplots(1, 2, figsize=(12, 5.2))
    draw_all(left, step)
    draw_car(right, step)
    for axes in (left, right):
        axes.set_aspect("equal")
    figure.tight_layout()
    figure.savefig(PICTURE, dpi=110)


def draw_all(axes: Axes, step: Step) -> None:
    """Draw every point by its unit, and the true boxes."""
    x, y, _ = step.scan.points_ego.T
    axes.scatter(x, y, c=step.scan.unit, s=2, cmap="tab10")
    actors, ego = step.frame.actors, step.frame.ego
    for pose, size in zip(actors.pose_world, actors.size, strict=True):
        axes.plot(*outline(*pose, *size[:2]), color="0.6", linewidth=1)
    axes.add_patch(Polygon(outline(*ego.pose_world, *ego.size[:2]).T, color="black"))
    axes.set(xlim=(-37, 37), ylim=(-37, 37), title="A scan, one colour a unit", xlabel="x [m]", ylabel="y [m]")


def draw_car(axes: Axes, step: Step) -> None:
    """Draw one car's points by cause, its true box and all rectangles fitted to it, the selected one thick."""
    own, found = step.truth.actor_id == CAR, step.trace.candidates
    for cause, color in COLORS.items():
        x, y, _ = step.scan.points_ego[own & (step.truth.cause == cause)].T
        axes.scatter(x, y, s=7, color=color, label=f"points: {cause.name.lower().replace('_', ' ')}", zorder=3)
    (row,) = np.flatnonzero(step.frame.actors.id == CAR)
    pose, size = step.frame.actors.pose_world[row], step.frame.actors.size[row]
    axes.plot(*outline(*pose, *size[:2]), "0.6", label="truth")
    label = step.trace.segments.label[own]
    segment = np.bincount(label[label >= 0]).argmax()
    for m, (method, color) in enumerate(zip(METHODS, METHOD_COLORS, strict=True)):
        best = found.best[segment] == m
        box = (*found.center_ego[segment, m], found.heading[segment, m], *found.size[segment, m])
        name = f"{method} (selected)" if best else method
        axes.plot(*outline(*box), color, linewidth=2.5 if best else 1.0, label=name)
    axes.set(title=f"One of its cars at {np.hypot(*pose[:2]):.0f} m", xlabel="x [m]")
    axes.legend(fontsize=8, loc="center left", bbox_to_anchor=(1.0, 0.5))


def outline(x: float, y: float, yaw: float, length: float, width: float) -> Floats:
    """Return (2, 5) coordinates of a closed box outline [m]."""
    return corner(np.array([[x, y, yaw, length, width]]), CORNER_SIGNS[[0, 1, 2, 3, 0]]).T
