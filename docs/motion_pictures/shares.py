"""Picture of the distributions of accelerations and jerks, before and after the truth layer."""

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from motion_pictures.stage import (
    INSTANT,
    SUBLANES,
    TIMED,
    Course,
    delivered_courses,
    on_net,
    on_scenario,
    raw_courses,
    save,
)
from sensor_pictures.stage import label

LIMITS = (10.0, 60.0)
"""[m/s^2], [m/s^3] Limits that tests check for every delivered motion."""


def draw() -> None:
    """Write the picture."""
    runs = {
        "motorway, jumps (SUMO's default)": ("tab:red", on_scenario("sumo-cut-in", INSTANT)),
        "motorway, lanechange.duration 3": ("tab:orange", on_scenario("sumo-cut-in", TIMED)),
        "motorway, lateral-resolution 0.8": ("tab:green", on_scenario("sumo-cut-in", SUBLANES)),
        "winding road, lanechange.duration 3": ("tab:purple", on_net("winding", TIMED)),
    }
    figure, panels = plt.subplots(1, 2, figsize=(11.0, 4.8), layout="constrained", sharey=True)
    for color, traffic in runs.values():
        raw, true = raw_courses(traffic), delivered_courses(traffic.delivered())
        for axes, order in zip(panels, (2, 3), strict=True):
            _share(axes, raw, order, color=color, linestyle="--")
            _share(axes, true, order, color=color, linestyle="-")
    for axes, name, unit, limit in zip(panels, ("Acceleration", "Jerk"), ("m/s²", "m/s³"), LIMITS, strict=True):
        axes.axvline(limit, color="0.3", linewidth=0.8)
        axes.text(limit * 1.08, 0.35, f"{limit:.0f} {unit}", fontsize=8)
        axes.grid(alpha=0.3)
        label(axes, name, f"x [{unit}], from differences of positions", "share of all frames with more than x")
    panels[0].set(xlim=(0.05, 1000), ylim=(3e-5, 1.5))
    panels[1].set(xlim=(0.05, 30_000))
    lines = [Line2D([], [], color=color, linewidth=4, label=name) for name, (color, _) in runs.items()]
    styles = [
        Line2D([], [], color="black", linestyle="--", label="SUMO"), Line2D([], [], color="black", label="delivered")
    ]  # fmt: skip
    figure.legend(handles=[*styles, *lines], loc="outside lower center", ncols=3, fontsize=8.5)
    save(figure, "shares")


def _share(axes: Axes, courses: list[Course], order: int, **style: str) -> None:
    """Draw the share of difference quotients of an order that are larger than x, over x."""
    size = np.sort(np.concatenate([np.hypot(*course.differences(order).T) for course in courses]))
    axes.loglog(np.maximum(size, 1e-9), 1.0 - np.arange(len(size)) / len(size), linewidth=1.3, **style)
