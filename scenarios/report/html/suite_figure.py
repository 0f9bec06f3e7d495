"""Figure of a suite: HOTA of each run by family, with its verdict."""

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

from luxloop.scenarios.document.figure import Figure, note
from luxloop.scenarios.document.palette import BAD, GOOD, LINE, MUTED, WARN
from luxloop.scenarios.report.html.reported_run import ReportedRun

if TYPE_CHECKING:
    from matplotlib.figure import Figure as Canvas

COLORS = {"passed": (GOOD, "o"), "failed": (BAD, "X"), "incomplete": (WARN, "s"), "no limits": (MUTED, "D")}
"""Colour and mark of each verdict."""


def suite_figure(runs: Sequence[ReportedRun]) -> Figure:
    """Draw HOTA of each run, in a row per family."""
    measured = [(run, run.result.metrics["track.hota"].value) for run in runs]
    shown = [(run, value) for run, value in measured if value is not None and math.isfinite(value)]
    families = sorted({run.family or "others" for run, _ in shown})
    found = list(dict.fromkeys(run.verdict for run, _ in shown))

    def on(canvas: "Canvas") -> None:
        axes = canvas.subplots()
        if not shown:
            note(axes, "no run has a value")
        for verdict in found:
            color, mark = COLORS[verdict]
            of = [(value, families.index(run.family or "others")) for run, value in shown if run.verdict == verdict]
            axes.plot(*zip(*of, strict=True), mark, color=color, ms=6, alpha=0.8, mew=0.0, label=verdict, clip_on=False)
        for row in range(len(families)):
            axes.axhline(row, color=LINE, lw=0.4, zorder=0)
        axes.set_yticks(range(len(families)), families)
        axes.set(xlim=(0.0, 1.0), ylim=(max(len(families), 1) - 0.5, -0.5), xlabel="HOTA (1 is best)")
        axes.grid(visible=False, axis="y")
        if found:
            canvas.legend(loc="outside upper left", ncols=len(found))

    caption = "A mark is a run: how well it tracks as a whole, and the verdict on its expectations."
    return Figure("hota", "HOTA of each run", caption, (5.2, 1.0 + 0.24 * max(len(families), 2)), on)
