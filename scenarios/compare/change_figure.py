"""Figure of a comparison: all changes with their intervals, in units of the stated losses."""

import math
from typing import TYPE_CHECKING

from luxloop.scenarios.compare.comparison import Comparison, MetricChange
from luxloop.scenarios.document.figure import Figure
from luxloop.scenarios.document.palette import BAD, FAINT, GOOD, INK, LINE, PANEL, WARN

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure as Canvas

SHOWN = 3.5
"""Largest change on the axis [stated losses]; arrows show that an interval continues."""
COLORS = {"worse": BAD, "lost": BAD, "better": GOOD, "unclear": WARN}


def change_figure(comparison: Comparison) -> Figure:
    """Draw the change of each metric, as a loss to the right and as a gain to the left."""
    shown = [change for change in comparison.changes if not math.isnan(change.numbers.difference)]

    def on(canvas: "Canvas") -> None:
        axes = canvas.subplots()
        axes.axvspan(1.0, SHOWN, color=PANEL, lw=0)
        axes.axvline(0.0, color=INK, lw=0.8)
        axes.axvline(1.0, color=FAINT, lw=0.8, ls=(0, (4, 3)))
        for row, change in enumerate(shown):
            _draw(axes, row, change, change.metric.relevance.stated_loss(change.numbers.base, comparison.loss))
        axes.set_yticks(range(len(shown)), [change.metric.name for change in shown], fontsize=7.0)
        axes.set(xlim=(-SHOWN, SHOWN), ylim=(len(shown) - 0.4, -0.6))
        axes.set_xlabel("better  ←  stated losses  →  worse")
        axes.grid(visible=False, axis="y")

    percent = f"{100.0 * comparison.loss:g} %"
    caption = (
        f"Dots are changes from BASE to HEAD, lines their 95 % intervals. An interval that reaches into the shaded "
        f"range contains the loss of {percent} that a comparison must exclude. Arrows continue beyond the axis."
    )
    return Figure("changes", "Change of each metric", caption, (5.4, 0.8 + 0.2 * max(len(shown), 3)), on)


def _draw(axes: "Axes", row: int, change: MetricChange, stated_loss: float) -> None:
    """Draw one metric in units of its stated loss, with the sign of a loss."""
    color = COLORS.get(change.verdict, FAINT)
    low, high = sorted(change.metric.loss(end) / stated_loss for end in change.numbers.interval)
    value = change.metric.loss(change.numbers.difference) / stated_loss
    axes.axhline(row, color=LINE, lw=0.4)
    if not math.isnan(low):
        axes.plot([max(low, -SHOWN), min(high, SHOWN)], [row, row], color=color, lw=2.0, solid_capstyle="butt")
        for end, marker in ((-SHOWN, "<"), (SHOWN, ">")):
            if low < end < high or (abs(end) < min(abs(low), abs(high)) and end * low > 0.0):
                axes.plot(end, row, marker, color=color, ms=6, clip_on=False)
    beyond = abs(value) > SHOWN
    marker = (">" if value > 0.0 else "<") if beyond else "o"
    axes.plot(min(max(value, -SHOWN), SHOWN), row, marker, color=color, ms=6 if beyond else 5, clip_on=False)
