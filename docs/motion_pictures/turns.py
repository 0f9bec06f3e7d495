"""Picture of turns at junctions, including one of a semitrailer."""

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from motion_pictures.stage import (
    DT,
    INSTANT,
    RAW,
    TRUE,
    Course,
    Traffic,
    delivered_courses,
    draw_road,
    named,
    on_net,
    on_scenario,
    raw_courses,
    save,
)
from sensor_pictures.stage import label

ROOM_M = 2.0
"""[m] Margin around the boxes."""


def draw() -> None:
    """Write the picture."""
    figure, panels = plt.subplots(
        2, 3, figsize=(12.0, 7.4), layout="constrained", height_ratios=(2.2, 1), width_ratios=(1, 1, 1)
    )
    crossing, spider = on_scenario("sumo-crossing"), on_net("spider", INSTANT)
    _turn(panels[:, 0], crossing, "s_w.3", (22.6, 26.2), 12, "A car turns left")
    _turn(panels[:, 1], crossing, "e_n.4", (10.8, 14.0), 13, "A car turns right")
    _turn(panels[:, 2], spider, "out.3.6", (5.2, 13.8), 35, "A semitrailer turns left")
    panels[0, 0].legend(fontsize=8, loc="lower left")
    save(figure, "turns")


def _turn(panels: np.ndarray, traffic: Traffic, name: str, time: tuple[float, float], every: int, title: str) -> None:
    """Draw one turn from above and its yaw rates."""
    raw, true = (
        named(raw_courses(traffic), name).part(*time),
        named(delivered_courses(traffic.delivered()), name).part(*time),
    )
    draw_road(panels[0], traffic)
    _above(panels[0], raw, every, RAW, "SUMO: path of the front bumper, boxes", linestyle="--")
    _above(panels[0], true, every, TRUE, "delivered", linestyle="-")
    points = np.vstack([*raw.outlines(every), *true.outlines(every)])
    (left, low), (right, high) = points.min(axis=0) - ROOM_M, points.max(axis=0) + ROOM_M
    panels[0].set(xlim=(left, right), ylim=(low, high), aspect="equal")
    label(panels[0], f"{title} (boxes every {every * DT:.1f} s)", "x [m]", "y [m]")
    for course, color in ((raw, RAW), (true, TRUE)):
        rate = np.diff(np.unwrap(course.pose[:, 2])) / DT
        panels[1].plot(course.time[1:] - course.time[0], np.rad2deg(rate), color=color, linewidth=1.2)
    panels[1].grid(alpha=0.3)
    label(panels[1], "Yaw rate of the box, from differences", "time [s]", "[deg/s]")


def _above(axes: Axes, course: Course, every: int, color: str, text: str, **style: str) -> None:
    """Draw boxes and the path of the front."""
    for box in course.outlines(every):
        axes.fill(*box.T, facecolor=color, alpha=0.12)
        axes.plot(*box.T, color=color, linewidth=1.2, **style)
    axes.plot(*course.fronts().T, color=color, linewidth=1.6, label=text, **style)
