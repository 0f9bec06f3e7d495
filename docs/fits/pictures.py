"""Pictures of fits: points by line, the true box, the selected rectangle, and the headings of all candidates."""

from pathlib import Path

import matplotlib
import numpy as np
from fits.case import Case
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from luxloop.scenarios.document.figure import STYLE
from luxloop.scenarios.document.palette import BLUE, FAINT, GREEN, INK, PAGE, RED, SKY
from luxloop.scenarios.report.html.run_page import METHOD_LOOKS
from luxloop.tracker.records import METHODS

COLUMNS = 4
PIXELS_PER_INCH = 100
SIGNS = np.array([(1, 1), (-1, 1), (-1, -1), (1, -1), (1, 1)])
LINE_COLORS = {0: BLUE, 1: GREEN}
"""Colours of points on the first and the second face; those of other lines have `SKY`."""


def draw(cases: list[Case], path: Path) -> None:
    """Draw the fits, `COLUMNS` in a row, with one legend."""
    rows = -(-len(cases) // COLUMNS)
    with matplotlib.rc_context(STYLE):
        canvas = Figure(figsize=(2.75 * COLUMNS, 2.6 * rows + 0.7), layout="constrained", facecolor=PAGE)
        grid = canvas.subplots(rows, COLUMNS, squeeze=False).ravel()
        for axes, case in zip(grid, cases, strict=False):
            _draw_case(axes, case)
        for axes in grid[len(cases) :]:
            axes.axis("off")
        canvas.legend(handles=_legend(), loc="outside lower center", ncols=6)
        canvas.savefig(path, dpi=PIXELS_PER_INCH, metadata={"Software": None})


def _draw_case(axes: Axes, case: Case) -> None:
    true = 0.5 * SIGNS * case.size
    axes.plot(*true.T, color=FAINT, ls="--", lw=1.2)
    for line in np.unique(case.line):
        own = case.points[case.line == line]
        marker, color = ("x", RED) if line < 0 else (".", LINE_COLORS.get(int(line), SKY))
        axes.plot(*own.T, marker, color=color, ms=4 if line >= 0 else 5, zorder=3)
    axes.plot(*_rectangle(case, case.best).T, color=INK, lw=1.3)
    pivot = np.median(case.points, axis=0)
    for k in np.flatnonzero(np.isfinite(case.errors)):
        color, style = _look(METHODS[k])
        # The axis of the heading nearest to the vehicle's own, so that errors show as angles between the lines.
        along = np.deg2rad(case.errors[k])
        ends = pivot + np.outer((-1.6, 1.6), (np.cos(along), np.sin(along)))
        axes.plot(*ends.T, color=color, ls=style, lw=1.1, zorder=2)
    toward = case.sensor / np.hypot(*case.sensor)
    axes.annotate("", -0.5 * toward, 0.9 * toward - 0.5 * toward, arrowprops={"arrowstyle": "->", "color": FAINT})
    least = np.nanargmin(np.abs(case.errors))
    axes.set_title(
        f"{case.name}, {len(case.points)} points\n"
        f"best {case.errors[case.best]:+.1f}, {METHODS[least]} {case.errors[least]:+.1f} deg",
        fontsize=7.5,
    )
    middle, reach = 0.5 * (case.points.min(axis=0) + case.points.max(axis=0)), 0.5 * max(case.size) + 0.4
    middle = np.clip(middle, *(0.5 * np.array([[-1.0], [1.0]]) * case.size))
    reach = min(max(reach, 2.7), 4.5)
    axes.set(xlim=middle[0] + np.array([-reach, reach]), ylim=middle[1] + np.array([-reach, reach]), aspect="equal")
    axes.tick_params(labelsize=6)


def _rectangle(case: Case, method: int) -> np.ndarray:
    """(5, 2) closed outline of a candidate."""
    cos, sin = np.cos(case.heading[method]), np.sin(case.heading[method])
    local = 0.5 * SIGNS * case.extent[method]
    return case.center[method] + local @ np.array([[cos, sin], [-sin, cos]])


def _look(method: str) -> tuple[str, object]:
    """Colour and line style of a method; of one that reports do not know, red and solid."""
    return METHOD_LOOKS.get(method, (RED, "-"))


def _legend() -> list[Line2D]:
    points = (("first face", ".", BLUE), ("second face", ".", GREEN), ("other line", ".", SKY), ("outlier", "x", RED))
    boxes = (("true box", "--", FAINT), ("best", "-", INK))
    return [
        *(Line2D([], [], marker=mark, ls="", color=color, label=name) for name, mark, color in points),
        *(Line2D([], [], ls=style, color=color, label=name) for name, style, color in boxes),
        *(Line2D([], [], color=_look(name)[0], ls=_look(name)[1], label=name) for name in METHODS),
    ]
