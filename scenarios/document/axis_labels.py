"""Labels of axes that do not collide."""

import math
from itertools import pairwise
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure as Canvas
    from matplotlib.text import Text

GAP_PX = 2.0
"""Least gap between two labels, at 72 pixels per inch [px]."""
LINE = 1.25
"""Height of a line of text, as a multiple of the size of its letters."""
SLANT_DEG = 35.0
"""Angle of labels that do not fit beside each other."""


def separate_labels(canvas: "Canvas") -> None:
    """Slant the labels of a horizontal axis that collide, and hide every second one as long as any still do."""
    if not any(len(axes.get_xticks()) or len(axes.get_yticks()) for axes in canvas.axes):
        return  # a map
    canvas.draw_without_rendering()
    for axes in canvas.axes:
        if _collide(axes, "x"):
            for label in axes.get_xticklabels(which="both"):
                label.set(rotation=SLANT_DEG, ha="right", rotation_mode="anchor")
            canvas.draw_without_rendering()
        for side in ("x", "y"):
            while _collide(axes, side):
                for label in _shown(axes, side)[1::2]:
                    label.set_visible(False)


def _shown(axes: "Axes", side: str) -> "list[Text]":
    """Return the labels of an axis that are in the figure."""
    labels = axes.get_xticklabels(which="both") if side == "x" else axes.get_yticklabels(which="both")
    low, high = sorted(axes.get_xlim() if side == "x" else axes.get_ylim())
    place = 0 if side == "x" else 1
    margin = 1e-9 * (high - low)
    return [
        label
        for label in labels
        if label.get_visible() and label.get_text() and low - margin <= label.get_position()[place] <= high + margin
    ]


def _collide(axes: "Axes", side: str) -> bool:
    """Return True if two neighbouring labels of an axis overlap."""
    shown = _shown(axes, side)
    if not shown:
        return False
    boxes = [label.get_window_extent() for label in shown]
    slant = math.radians(shown[0].get_rotation())
    if not slant:
        return any(one.padded(0.5 * GAP_PX).overlaps(other) for one, other in pairwise(boxes))
    # Slanted labels are parallel lines of text that end below their ticks.
    line = LINE * max(float(label.get_fontsize()) for label in shown) * axes.figure.dpi / 72.0
    return any(abs(right.x1 - left.x1) * math.sin(slant) < line + GAP_PX for left, right in pairwise(boxes))
