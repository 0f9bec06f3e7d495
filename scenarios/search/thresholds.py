"""`luxloop thresholds`: the value of a parameter at which a share of runs keeps a metric, by an adaptive design.

Each run is placed by `luxloop.scenarios.statistics.adaptive_curve`, separately for every setting: the combination
of the other parameters. The values depend on the evaluations only, so a restart proposes the same runs.
"""

from dataclasses import dataclass
from pathlib import Path

from luxloop.scenarios.errors import StudyError
from luxloop.scenarios.run import device, progress
from luxloop.scenarios.search.evaluator import Evaluator, Json, Notify, executor, no_report
from luxloop.scenarios.statistics.adaptive_curve import AdaptiveCurve, Threshold
from luxloop.scenarios.study import design
from luxloop.scenarios.study.parameter import Value
from luxloop.scenarios.study.row_store import RowStore
from luxloop.scenarios.study.study_file import Search, Study
from luxloop.scenarios.study.study_file import Threshold as Goal

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
    workers: int = 1,
    scheduler: str | None = None,
    *,
    retry_errors: bool = False,
    report_defect: Notify = no_report,
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
    workers
        Number of local processes; not used with a scheduler.
    scheduler
        Address of a Dask scheduler.
    retry_errors
        True to run again what ended with an error.
    report_defect
        As `Evaluator`.

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
    device.load(tracker)  # an invalid tracker is reported once, not by every evaluation
    settings = settings_of(study, goal)
    criterion = Search(metric=goal.metric, min=1.0)
    with RowStore.opened(out) as rows, executor(min(workers, len(settings)), scheduler) as execute_runs:
        evaluator = Evaluator(
            criterion, path, tracker, rows, execute_runs, retry_errors=retry_errors, report_defect=report_defect
        )
        if evaluator.known:
            notify(f"{evaluator.known} evaluations of an earlier start are reused")
        with evaluator.resumable(), progress.runs(study.path.stem, goal.runs * len(settings), done=0) as advance:
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
