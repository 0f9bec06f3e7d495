"""`luxloop search`: optimise, reduce, write the scenario file of the finding, and run it with a recording."""

from dataclasses import dataclass
from pathlib import Path

from luxloop.scenarios.errors import StudyError
from luxloop.scenarios.execute import execute
from luxloop.scenarios.files.scenario import Scenario
from luxloop.scenarios.result import Result
from luxloop.scenarios.run import device
from luxloop.scenarios.search import finding_file, reductions
from luxloop.scenarios.search.evaluator import Evaluator, Json, Notify, executor, no_report
from luxloop.scenarios.search.optimise import optimise
from luxloop.scenarios.search.shrink import shrink
from luxloop.scenarios.study.design import source
from luxloop.scenarios.study.parameter import Value
from luxloop.scenarios.study.row_store import RowStore
from luxloop.scenarios.study.study_file import Search, Study

RUN = "run"


@dataclass(frozen=True, slots=True)
class Finding:
    """The smallest failure found."""

    file: Path
    """Scenario file."""
    result: Result
    """Run of the scenario file."""
    what: str
    """Value of the metric, its limit and the worst frame."""


def search(
    study: Study,
    tracker: str,
    out: Path,
    notify: Notify,
    workers: int = 1,
    scheduler: str | None = None,
    *,
    retry_errors: bool = False,
    report_defect: Notify = no_report,
) -> Finding | None:
    """Find the smallest disturbance with which the study's metric fails; None if no trial fails.

    Parameters
    ----------
    study
        Study with a `[search]` table.
    tracker
        MODULE:NAME of the device under test.
    out
        Folder of the scenario file, its run and the rows of all trials; those of an earlier start are reused.
    notify
        Receives a line of text for every step.
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
        The study has no `[search]`, the undisturbed scenario cannot run, or the finding is not reproducible.
    OutputError
        The folder cannot be written.
    Interrupted
        Ctrl-C was pressed; all evaluations received so far are on disk.
    """
    if study.search is None:
        raise StudyError(f"{study.path}: no [search] table; add one with the metric that should fail, and its limit")
    goal, (stage, path) = study.search, source(study)
    device.load(tracker)  # an invalid tracker is reported once, not by every evaluation

    def make(parameters: dict[str, Value], seed: int) -> Json:
        document = {**stage({**study.fixed, **parameters}), "seed": seed}
        return {**document, "expect": finding_file.expectation(goal.metric, goal.limit, "")}

    with RowStore.opened(out) as rows, executor(min(workers, goal.at_once), scheduler) as execute_runs:
        evaluator = Evaluator(
            goal, path, tracker, rows, execute_runs, retry_errors=retry_errors, report_defect=report_defect
        )
        if evaluator.known:
            notify(f"{evaluator.known} evaluations of an earlier start are reused")
        if evaluator.retried:
            notify(f"{evaluator.retried} evaluations ended with an error and are run again")
        with evaluator.resumable():
            best, search_runs = optimise(study, evaluator, make, notify), evaluator.runs
            smallest = shrink(study, best, evaluator, make, notify, goal.reduction_runs) if best else None
            evaluator.write_table([metric.name for metric in study.metric])
        if smallest is None:
            notify(f"no failure in {evaluator.runs} runs: {goal.metric} kept to {goal.limit}")
            return None
        notify(f"{search_runs} runs to find it, {evaluator.runs - search_runs} to reduce it")
        return _reproduce(study, goal, smallest, evaluator, out)


def _reproduce(study: Study, goal: Search, document: Json, evaluator: Evaluator, out: Path) -> Finding:
    """Write the scenario file, run it as `luxloop run` does, and compare the trace hash."""
    evaluation = evaluator.evaluate(document)
    what, tracker = _describe_failure(goal, document, evaluator), device.load(evaluator.tracker)
    file = out / f"{study.path.stem}.toml"
    scenario = {
        **document,
        "description": f"Found by luxloop search in {study.path.name}, the smallest failure: {_scene(document)}.",
        "reason": study.description,
        "expect": finding_file.expectation(goal.metric, goal.limit, what, device.name_of(tracker)),
    }
    finding_file.write(scenario, evaluator.path, file)
    result = execute(Scenario.load(file), tracker, out / RUN)
    if result.trace_hash != evaluation.trace_hash:
        raise StudyError(
            f"{file}: a second run gives another result; check that {evaluator.tracker} is deterministic "
            "with luxloop check-tracker"
        )
    return Finding(file, result, what)


def _describe_failure(goal: Search, document: Json, evaluator: Evaluator) -> str:
    """Return the symptom: the value, the limit and the worst frame; the cause is left to the reader."""
    value = evaluator.evaluate(document).value
    worst = reductions.worst_frame(document, evaluator)
    where = f"; worst in {worst}" if worst else ""
    return f"{value:.4g}: {goal.limit} is wanted{where}"


def _scene(document: Json) -> str:
    """Return a short description of the scene: the number of actors and obstacles, and the duration."""
    traffic = document["traffic"]
    counts = [(len(traffic.get(kind, [])), kind) for kind in ("actor", "obstacle")]
    scene = " and ".join(f"{count} {kind}{'s' * (count > 1)}" for count, kind in counts if count)
    return f"{scene or traffic['kind']} around the ego, {document['duration_s']:g} s long"
