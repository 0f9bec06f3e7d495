"""Thresholds of a study as text, JSON and figure."""

import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from luxloop.scenarios.document import figure_files
from luxloop.scenarios.document.document import Table
from luxloop.scenarios.document.figure import Figure
from luxloop.scenarios.document.palette import SERIES
from luxloop.scenarios.errors import OutputError
from luxloop.scenarios.files import atomic_file
from luxloop.scenarios.report.cells import table_of
from luxloop.scenarios.search.thresholds import Setting
from luxloop.scenarios.statistics.adaptive_curve import Threshold
from luxloop.scenarios.study.figures import label, text
from luxloop.scenarios.study.study_file import Study

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure as Canvas

DOCUMENT, PICTURE = "thresholds.json", "thresholds"
PANEL_IN = (2.6, 2.2)
MOST_PANELS_WIDE = 3


def report(study: Study, settings: list[Setting]) -> Table:
    """Return the printed table: a line per setting."""
    assert study.threshold
    shares = study.threshold.shares
    keys = list(settings[0].parameters)
    columns = [name for share in shares for name in (f"{share:.0%} at", "95 %")]
    title = f"{label(study, study.threshold.key)} at which a share of runs keeps {study.threshold.metric}"
    table = table_of(
        title, label(study, keys[0]) if keys else "", *(label(study, key) for key in keys[1:]), *columns, "runs"
    )
    for setting in settings:
        cells = [cell for one in setting.thresholds(shares) for cell in _cells(one, setting)]
        counted = sum(trial.outcome is not None for trial in setting.trials)
        runs = f"{counted}" if counted == len(setting.trials) else f"{counted} of {len(setting.trials)}"
        table.add_row(*(text(value) for value in setting.parameters.values()), *([] if keys else [""]), *cells, runs)
    return table


def document(study: Study, settings: list[Setting]) -> dict[str, Any]:
    """Return thresholds and trials as JSON."""
    assert study.threshold
    goal = study.threshold
    return {
        "study": study.path.stem,
        "key": goal.key,
        "metric": goal.metric,
        "runs": sum(len(setting.trials) for setting in settings),
        "settings": [
            {
                "parameters": setting.parameters,
                "thresholds": [
                    {"share": one.share, "value": one.value, "low": one.interval[0], "high": one.interval[1]}
                    for one in setting.thresholds(goal.shares)
                ],
                "trials": [{"value": one.value, "seed": one.seed, "outcome": one.outcome} for one in setting.trials],
            }
            for setting in settings
        ],
    }


def write(study: Study, settings: list[Setting], out: Path, formats: list[str]) -> None:
    """Write JSON and figure.

    Raises
    ------
    OutputError
        The folder cannot be written.
    """
    try:
        with atomic_file.create(out / DOCUMENT) as partial:
            content = json.dumps(document(study, settings), indent=2, allow_nan=False)
            partial.write_text(content + "\n", encoding="utf-8")
    except OSError as error:
        raise OutputError(f"{out}: cannot write there ({error.strerror}); choose another folder with --out") from error
    assert study.threshold
    title = f"Share of runs that keep {study.threshold.metric}, and the runs of the adaptive design"
    wide = min(len(settings), MOST_PANELS_WIDE)
    high = -(-len(settings) // MOST_PANELS_WIDE)

    def paint(canvas: "Canvas") -> None:
        grid = canvas.subplots(high, wide, sharex=True, sharey=True, squeeze=False)
        for axes, setting in zip(grid.flat, settings, strict=False):
            _panel(axes, setting, study)
        for axes in grid.flat[len(settings) :]:
            axes.set_axis_off()
        canvas.supxlabel(label(study, study.threshold.key) if study.threshold else "", fontsize=9)

    size = (1.0 + PANEL_IN[0] * wide, 0.8 + PANEL_IN[1] * high)
    figure_files.save(Figure(PICTURE, title, "", size, paint), out, list(dict.fromkeys(["png", *formats])))


def _cells(one: Threshold, setting: Setting) -> tuple[str, str]:
    low, high = one.interval
    ends = setting.curve.values[[0, -1]].tolist()
    return f"{one.value:.2f}", f"{'<= ' * (low <= ends[0])}{low:.2f} to {'>= ' * (high >= ends[1])}{high:.2f}"


def _panel(axes: "Axes", setting: Setting, study: Study) -> None:
    """Draw the posterior curve with its band, the thresholds, and a dot per run."""
    assert study.threshold
    mean, low, high = setting.curve.curve()
    axes.fill_between(setting.curve.values, low, high, color=SERIES[0], alpha=0.15, linewidth=0)
    axes.plot(setting.curve.values, mean, color=SERIES[0])
    known = [trial for trial in setting.trials if trial.outcome is not None]
    spread = 0.04 * np.sin(np.arange(len(known)))  # keeps dots of equal runs apart
    outcome = np.array([trial.outcome for trial in known], dtype=np.float64)
    axes.plot([trial.value for trial in known], outcome + spread, ".", color=SERIES[1])
    for one in setting.thresholds(study.threshold.shares):
        axes.plot(one.interval, (one.share, one.share), color=SERIES[2], linewidth=2)
    axes.set_ylim(-0.1, 1.1)
    axes.set_title(", ".join(text(value) for value in setting.parameters.values()), fontsize=8)
