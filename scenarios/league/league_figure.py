"""Picture of the league: HOTA of each tracker with its interval."""

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

from luxloop.scenarios.document.figure import Figure
from luxloop.scenarios.document.palette import BLUE, INK, LINE, MUTED
from luxloop.scenarios.league.standings import Standing
from luxloop.scenarios.run.device import REFERENCE

if TYPE_CHECKING:
    from matplotlib.figure import Figure as Canvas

CAPTION = (
    "Dots are HOTA over all vehicles of all runs, lines 95 % intervals over vehicles; the shipped tracker is blue."
)


def hota_figure(found: Sequence[Standing]) -> Figure:
    """Draw HOTA of each tracker, the highest first."""
    shown = [each for each in found if math.isfinite(each.hota)]

    def on(canvas: "Canvas") -> None:
        axes = canvas.subplots()
        for row, each in enumerate(shown):
            color = BLUE if each.tracker == REFERENCE else INK
            axes.axhline(row, color=LINE, lw=0.4)
            if math.isfinite(each.hota_interval[0]):
                axes.plot(each.hota_interval, [row, row], color=color, lw=2.0, solid_capstyle="butt")
            axes.plot(each.hota, row, "o", color=color, ms=6)
            axes.annotate(
                f"{each.hota:.3f}", (each.hota, row), (0, 6), textcoords="offset points", ha="center", color=MUTED
            )
        axes.set_yticks(range(len(shown)), [each.tracker for each in shown])
        axes.set(xlim=(0.0, 1.0), ylim=(len(shown) - 0.5, -0.7), xlabel="HOTA")
        axes.grid(visible=False, axis="y")

    return Figure("hota", "HOTA of each tracker", CAPTION, (5.4, 0.9 + 0.36 * max(len(shown), 2)), on)
