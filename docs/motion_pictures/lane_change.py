"""Picture of a lane change on the motorway that SUMO makes in one step."""

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from motion_pictures.stage import (
    DT,
    INSTANT,
    RAW,
    TRUE,
    Course,
    Floats,
    Traffic,
    delivered_courses,
    draw_road,
    named,
    on_scenario,
    raw_courses,
    save,
)
from sensor_pictures.stage import label

JUMPER = "entering.32"
"""Changes from the ramp to the right lane."""
BEFORE_S, AFTER_S = 2.4, 2.6
EVERY = 5
"""Frames between two boxes in the picture."""


def draw() -> None:
    """Write the picture."""
    traffic = on_scenario("sumo-cut-in", INSTANT)
    raw, true = named(raw_courses(traffic), JUMPER), named(delivered_courses(traffic.delivered()), JUMPER)
    jump = int(np.hypot(*raw.differences(2).T).argmax())
    middle = raw.pose[jump + 1]
    begin, end = raw.time[jump + 1] - BEFORE_S, raw.time[jump + 1] + AFTER_S
    raw, true = raw.part(begin, end), true.part(begin, end)
    figure = plt.figure(figsize=(11.0, 6.6), layout="constrained")
    grid = figure.add_gridspec(3, 2, height_ratios=(1, 1, 2.3))
    for row, (course, color, title) in enumerate(
        ((raw, RAW, "SUMO: in the next lane from one step to the next"), (true, TRUE, "Delivered"))
    ):
        _above(figure.add_subplot(grid[row, :]), traffic, course, color, title)
    _across(figure.add_subplot(grid[2, 0]), raw, true, middle)
    _accelerations(figure.add_subplot(grid[2, 1]), raw, true)
    save(figure, "lane_change")


def _above(axes: Axes, traffic: Traffic, course: Course, color: str, title: str) -> None:
    """Draw boxes from above."""
    draw_road(axes, traffic)
    for box in course.outlines(EVERY):
        axes.fill(*box.T, facecolor=color, alpha=0.25)
        axes.plot(*box.T, color=color, linewidth=1.0)
    axes.plot(*course.pose[:, :2].T, ".", color=color, markersize=2)
    x = course.pose[:, 0]
    axes.set(xlim=(x.min() - 4, x.max() + 4), ylim=(-9.5, 0.5), aspect="equal")
    label(axes, f"{title} (a point every {DT:.2f} s, a box every {EVERY * DT:.1f} s)", "x [m]", "y [m]")


def _across(axes: Axes, raw: Course, true: Course, middle: Floats) -> None:
    """Draw the lateral position, from the middle between the lanes."""
    for course, color, name in ((raw, RAW, "SUMO"), (true, TRUE, "Delivered")):
        left = (course.pose[:, :2] - middle[:2]) @ [-np.sin(true.pose[0, 2]), np.cos(true.pose[0, 2])]
        axes.plot(course.time - course.time[0], left, ".-", color=color, markersize=3, linewidth=1, label=name)
    axes.grid(alpha=0.3)
    axes.legend(fontsize=8)
    label(axes, "Box centre across the road", "time [s]", "to the left [m]")


def _accelerations(axes: Axes, raw: Course, true: Course) -> None:
    """Draw the magnitude of the second difference quotient."""
    for course, color, name in ((raw, RAW, "SUMO"), (true, TRUE, "Delivered")):
        size = np.hypot(*course.differences(2).T)
        axes.semilogy(course.time[1:-1] - course.time[0], size, ".-", color=color, markersize=3, linewidth=1,
                      label=f"{name}: at most {size.max():.{0 if size.max() > 10 else 1}f} m/s²")  # fmt: skip
    axes.grid(alpha=0.3)
    axes.legend(fontsize=8)
    label(axes, "Acceleration, from differences of positions", "time [s]", "[m/s²], logarithmic")
