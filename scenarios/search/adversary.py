"""`luxloop search`: optimise, reduce, write the scenario file of the finding, and run it with a recording."""

import copy
import os
import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import tomli_w

from luxloop.scenarios.errors import StudyError
from luxloop.scenarios.execute import execute
from luxloop.scenarios.files import atomic_file
from luxloop.scenarios.files.expect import SHIPPED, Limit
from luxloop.scenarios.files.scenario import Scenario
from luxloop.scenarios.result import Result
from luxloop.scenarios.run import device
from luxloop.scenarios.search import reductions
from luxloop.scenarios.search.evaluator import BY_DEFAULT, Evaluator, Json, Notify, TrialOptions
from luxloop.scenarios.search.optimise import optimise
from luxloop.scenarios.search.reductions import shrink
from luxloop.scenarios.study.design import source
from luxloop.scenarios.study.parameter import Value
from luxloop.scenarios.study.study_file import Search, Study

HEAD = ("description", "reason", "suite", "seed", "duration_s", "traffic")
"""First keys of the file, in this order; all other keys follow, `[expect]` last."""

_NUMBERS = re.compile(r"\[\n\s*([\w\s.,+-]+?),\n\s*\]")
"""List of numbers or booleans as tomli_w writes it, one item per line."""


def expectation(metric: str, limit: Limit, known_failure: str, tracker: str = SHIPPED) -> Json:
    """Return an `[expect]` table with one limit; `known_failure` describes the failure of `tracker`."""
    table = {"min": limit.min, "max": limit.max, "unit": limit.unit, "need": limit.need, "known_failure": known_failure}
    table["known_failure_of"] = "" if tracker == SHIPPED else tracker
    return {metric: {key: _plain(value) for key, value in table.items() if value not in (None, "")}}


def write(document: Json, made_at: Path, path: Path) -> None:
    """Write a scenario file.

    Parameters
    ----------
    document
        Content of the file.
    made_at
        File to which relative paths in the document refer.
    path
        File to write; relative paths are changed to refer to it.

    Raises
    ------
    OutputError
        The file cannot be written.
    """
    moved = _moved(document, made_at.parent, path.parent)
    last = [key for key in moved if key not in (*HEAD, "expect")]
    ordered = {key: moved[key] for key in (*HEAD, *last, "expect") if key in moved}
    atomic_file.save_text(path, _NUMBERS.sub(lambda found: f"[{' '.join(found[1].split())}]", tomli_w.dumps(ordered)))


def _plain(value: Any) -> Any:
    """Return 0 for 0.0, which is easier to read."""
    return int(value) if isinstance(value, float) and value.is_integer() else value


def _moved(document: Json, start: Path, new_start: Path) -> Json:
    """Return a copy with relative paths that lead from a new folder to the same files."""
    moved = copy.deepcopy(document)
    for container, key in _paths(moved):
        value = container[key]
        if value:
            container[key] = Path(os.path.relpath(start / value, new_start)).as_posix()
    return moved


def _paths(document: Json) -> Iterator[tuple[Any, str | int]]:
    """Yield the location of every path in a scenario: the list or table, and the index or key."""
    traffic = document["traffic"]
    for key in ("config", "net", "file"):
        if traffic.get("kind") != "highway-env" and key in traffic:
            yield traffic, key
    for key in ("routes", "additional"):
        for index in range(len(traffic.get(key, []))):
            yield traffic[key], index
    if "file" in document.get("rig", {}):
        yield document["rig"], "file"


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
    options: TrialOptions = BY_DEFAULT,
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
    options
        Where runs are executed, and what becomes of errors.

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

    def make(parameters: dict[str, Value], seed: int) -> Json:
        document = {**stage({**study.fixed, **parameters}), "seed": seed}
        return {**document, "expect": expectation(goal.metric, goal.limit, "")}

    with Evaluator.opened(goal, path, tracker, out, notify, options, goal.at_once) as evaluator:
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
        "expect": expectation(goal.metric, goal.limit, what, device.name_of(tracker)),
    }
    write(scenario, evaluator.path, file)
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
