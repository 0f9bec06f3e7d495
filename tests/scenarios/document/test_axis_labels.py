"""Labels of axes never overlap, and all points lie on their axes: both measured without the code under test."""

import re
from itertools import combinations

import numpy as np
import pytest
from support import recorded, short_run
from support.few import few
from support.paths import ROOT

from luxloop.scenarios.compare import baseline_file
from luxloop.scenarios.compare.comparison import compare
from luxloop.scenarios.compare.comparison_document import change_figure
from luxloop.scenarios.compare.run_pairs import Side, pair
from luxloop.scenarios.compare.trends import suite_figures, trends
from luxloop.scenarios.document.figure import Figure
from luxloop.scenarios.report.html.reported_run import ReportedRun
from luxloop.scenarios.report.html.run_page import run_figures
from luxloop.scenarios.report.html.suite_page import suite_figure
from luxloop.scenarios.run import run_folder


def boxes(labels):
    """Corners of the rotated rectangles of the labels that are drawn [px]."""
    found = []
    for label in labels:
        if not (label.get_visible() and label.get_text()):
            continue
        turned = label.get_rotation()
        label.set_rotation(0.0)
        flat = label.get_window_extent()
        label.set_rotation(turned)
        box, angle = label.get_window_extent(), np.radians(turned)
        axis = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
        half = 0.5 * np.array([flat.width, flat.height])
        middle = np.array([0.5 * (box.x0 + box.x1), 0.5 * (box.y0 + box.y1)])
        found.append((middle, half, axis))
    return found


def overlap(one, other):
    """Separating axes of two rectangles."""
    gap = other[0] - one[0]
    for axis in (*one[2], *other[2]):
        reach = sum((half * np.abs(axes @ axis)).sum() for _, half, axes in (one, other))
        if abs(gap @ axis) >= reach - 0.5:
            return False
    return True


def faults(figure):
    """Describe overlapping labels and points beyond their axes."""
    found = []
    with figure.canvas("none") as canvas:
        canvas.draw_without_rendering()
        for axes in canvas.axes:
            for side in (axes.xaxis, axes.yaxis):
                low, high = sorted(side.get_view_interval())
                ticks = [tick for tick in side.get_major_ticks() if low - 1e-9 <= tick.get_loc() <= high + 1e-9]
                shown = boxes([tick.label1 for tick in ticks])
                if any(overlap(*two) for two in combinations(shown, 2)):
                    found.append(f"{figure.name}: labels of {side.axis_name}")
            (left, right), (bottom, top) = sorted(axes.get_xlim()), sorted(axes.get_ylim())
            for line in axes.get_lines():
                if line.get_marker() in ("None", None, "") or line.get_transform() != axes.transData:
                    continue
                x, y = (np.asarray(values, dtype=float) for values in line.get_data())
                inside = (left - 1e-9 <= x) & (x <= right + 1e-9) & (bottom - 1e-9 <= y) & (y <= top + 1e-9)
                if not (inside | np.isnan(x) | np.isnan(y)).all():
                    found.append(f"{figure.name}: a point is beyond its axes")
    return found


def bars(names):
    def paint(canvas):
        axes = canvas.subplots()
        axes.plot(range(len(names)), range(len(names)), "o")
        axes.set_xticks(range(len(names)), names)

    return Figure("bars", "Bars", "", (3.0, 2.0), paint)


@pytest.mark.parametrize("count", few([2, 6, 12, 40], 12, 40))
@pytest.mark.parametrize("name", ["a", "a name of twenty letters"])
def test_labels_are_slanted_and_thinned_until_none_overlap(count, name):
    one = bars([name] * count)
    assert faults(one) == []
    assert name in re.sub("<[^>]*>", "", one.svg)


def test_a_fault_would_be_found():
    one = bars(["a name of twenty letters"] * 12)
    hidden = Figure("raw", "", "", (3.0, 2.0), lambda canvas: canvas.subplots().plot([0, 1], [0, 1], "o"))
    with one.canvas("none") as canvas:
        for label in canvas.axes[0].get_xticklabels():
            label.set(visible=True, rotation=0.0, ha="center")
        labels = boxes(canvas.axes[0].get_xticklabels())
        assert any(overlap(*two) for two in combinations(labels, 2))
    beyond = Figure("out", "", "", (3.0, 2.0), lambda canvas: (hidden.paint(canvas), canvas.axes[0].set_xlim(0, 0.5)))
    assert faults(beyond) == ["out: a point is beyond its axes"]


def test_figures_of_a_run(tmp_path):
    run_folder.write(tmp_path, short_run.result(), [], "")
    run = ReportedRun.read(tmp_path)
    figures = run_figures(run)
    shown = [*figures.fits, *figures.tracks, *figures.models, suite_figure([run])]
    assert len(shown) >= 8
    assert [fault for figure in shown for fault in faults(figure)] == []


@pytest.mark.slow
def test_figures_of_comparisons_and_trends(tmp_path):
    runs = baseline_file.read(ROOT / "scenarios" / "baseline" / "catalog.jsonl")[:12]

    def side(name):
        return Side(tmp_path / f"a-long-name-of-a-baseline-{name}.jsonl", {run.key: run for run in runs}, [])

    blind = [run.with_tracks(recorded.withhold(1, share=0.9), "blind") for run in recorded.runs()]
    sides = (Side(tmp_path, {run.key: run for run in found}, []) for found in (recorded.base(), blind))
    shown = [change_figure(compare(pair(*sides))), *suite_figures(trends([side(n) for n in range(9)]))]
    assert [fault for figure in shown for fault in faults(figure)] == []
