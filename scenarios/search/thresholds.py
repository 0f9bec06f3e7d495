"""`luxloop thresholds`: the value of a parameter at which a share of runs keeps a metric, by an adaptive design.

Each run is placed by `luxloop.scenarios.statistics.adaptive_curve`, separately for every setting: the combination
of the other parameters. The values depend on the evaluations only, so a restart proposes the same runs.
"""

import json
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from luxloop.scenarios.document.document import Table
from luxloop.scenarios.document.figure import Figure
from luxloop.scenarios.document.palette import SERIES
from luxloop.scenarios.errors import StudyError
from luxloop.scenarios.files import atomic_file
from luxloop.scenarios.report.cells import table_of
from luxloop.scenarios.run import progress
from luxloop.scenarios.search.evaluator import BY_DEFAULT, Evaluator, Json, Notify, TrialOptions
from luxloop.scenarios.statistics.adaptive_curve import AdaptiveCurve, Threshold
from luxloop.scenarios.study import design
from luxloop.scenarios.study.figures import label, text
from luxloop.scenarios.study.parameter import Value
from luxloop.scenarios.study.study_file import Search, Study
from luxloop.scenarios.study.study_file import Threshold as Goal

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure as Canvas


DIGITS = 4
"""Significant digits of a proposed value."""


@dataclass(frozen=True, slots=True)
class Trial:
    """A run of a setting."""

    value: float
    """Value of the parameter."""
    seed: int
    outcome: float | None
    """Value of the metric; None if it does not apply, or the run did not complete."""


@dataclass(frozen=True, slots=True, eq=False)
class Setting:
    """A combination of the other parameters, its trials and the posterior of its curve."""

    parameters: dict[str, Value]
    curve: AdaptiveCurve
    trials: list[Trial]

    def thresholds(self, shares: list[float]) -> list[Threshold]:
        """Return the value at which each share of runs keeps the metric."""
        return [self.curve.threshold(share) for share in shares]


def thresholds(
    study: Study,
    tracker: str,
    out: Path,
    notify: Notify,
    options: TrialOptions = BY_DEFAULT,
) -> list[Setting]:
    """Estimate the thresholds of every setting of a study.

    Parameters
    ----------
    study
        Study with a `[threshold]` table.
    tracker
        MODULE:NAME of the device under test.
    out
        Folder of the rows of all runs; those of an earlier start are reused.
    notify
        Receives a line of text.
    options
        Where runs are executed, and what becomes of errors.

    Raises
    ------
    StudyError
        The study has no `[threshold]`, a scene rejects its parameters, or the metric is not from 0 to 1.
    OutputError
        The folder cannot be written.
    Interrupted
        Ctrl-C was pressed; all evaluations received so far are on disk.
    """
    if study.threshold is None:
        raise StudyError(f"{study.path}: no [threshold] table; add one with the key, the metric and the shares")
    goal = study.threshold
    make, path = design.source(study)
    settings = settings_of(study, goal)
    criterion = Search(metric=goal.metric, min=1.0)
    with (
        Evaluator.opened(criterion, path, tracker, out, notify, options, len(settings)) as evaluator,
        evaluator.resumable(),
        progress.runs(study.path.stem, goal.runs * len(settings), done=0) as advance,
    ):
        for round_ in range(goal.runs):
            _run_round(study, goal, settings, evaluator, make, round_)
            advance(len(settings))
        evaluator.write_table([metric.name for metric in study.metric])
    return settings


def settings_of(study: Study, goal: Goal) -> list[Setting]:
    """Return the settings: all combinations of the other parameters, without trials."""
    (parameter,) = (one for one in study.vary if one.key == goal.key)
    assert parameter.low is not None
    assert parameter.high is not None
    others = study.model_copy(update={"vary": [one for one in study.vary if one.key != goal.key], "samples": None})
    return [
        Setting(values, AdaptiveCurve(parameter.low, parameter.high, goal.shares, rising=goal.rising), [])
        for values in design.combinations(others)
    ]


def _run_round(
    study: Study, goal: Goal, settings: list[Setting], evaluator: Evaluator, make: design.MakeDocument, round_: int
) -> None:
    """Execute one run of every setting, all with the same seed."""
    seed = study.seed_list[round_ % len(study.seed_list)]
    values = [float(f"{setting.curve.next_value():.{DIGITS}g}") for setting in settings]
    documents: list[Json] = [
        {**make({**study.fixed, **setting.parameters, goal.key: value}), "seed": seed}
        for setting, value in zip(settings, values, strict=True)
    ]
    for setting, value, one in zip(settings, values, evaluator.evaluate_all(documents), strict=True):
        if one.value is not None and not 0.0 <= one.value <= 1.0:
            raise StudyError(
                f"{study.path}: threshold.metric = {goal.metric}: is {one.value:g} with {goal.key} = {value:g}; "
                "name a metric from 0 to 1, such as track.occlusion_survival"
            )
        if one.value is not None:
            setting.curve.add(value, one.value)
        setting.trials.append(Trial(value, seed, one.value))


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
    atomic_file.save_text(out / DOCUMENT, json.dumps(document(study, settings), indent=2, allow_nan=False) + "\n")
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
    Figure(PICTURE, title, "", size, paint).save(out, list(dict.fromkeys(["png", *formats])))


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
