"""`luxloop search`: hunt, shrink, write the scenario file, and run it once more with a recording."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from scenarios.errors import Interrupted, StudyError
from scenarios.execute import ExecutedRun, execute
from scenarios.files.scenario import Scenario
from scenarios.run import device
from scenarios.search import finding_file, reductions
from scenarios.search.evaluator import Bench, CarryOut, Json
from scenarios.search.optimise import Tell, hunt
from scenarios.search.shrink import shrink
from scenarios.study import dask_runs
from scenarios.study.design import source
from scenarios.study.parameter import Value
from scenarios.study.study_file import Search, Study

ANSWERS, RUN = "answers.jsonl", "run"


@dataclass(frozen=True, slots=True)
class Found:
    """The smallest failure that was found."""

    file: Path
    """The scenario file."""
    outcome: ExecutedRun
    """Of its run."""
    what: str
    """What happens, and in which frame."""


def search(
    study: Study, tracker: str, out: Path, tell: Tell, workers: int = 1, scheduler: str | None = None
) -> Found | None:
    """Look for the smallest disturbance that makes the study's metric fail; None if none of the trials did.

    Parameters
    ----------
    study
        With a `[search]` table.
    tracker
        MODULE:NAME of the device under test.
    out
        Folder of the scenario file, its run and the answers of all trials; of an earlier start none is run again.
    tell
        Is told every step, a line each.
    workers
        Processes of this computer, unless
    scheduler
        names a Dask scheduler.

    Raises
    ------
    StudyError
        There is no `[search]`, the undisturbed scenario cannot be run, or the finding does not repeat itself.
    OutputError
        The folder cannot be written.
    Interrupted
        Ctrl-C; all answers that came in are on disk.
    """
    if study.search is None:
        raise StudyError(f"{study.path}: no [search] table; add one with the metric that is to fail, and its limit")
    wanted, (stage, path) = study.search, source(study)
    device.load(tracker)  # that there is none should be told once, not by every answer

    def make(parameters: dict[str, Value], seed: int) -> Json:
        document = {**stage({**study.fixed, **parameters}), "seed": seed}
        return {**document, "expect": finding_file.expectation(wanted.metric, wanted.limit, "")}

    with _side_by_side(min(workers, wanted.at_once), scheduler) as carry_out:
        bench = Bench(wanted, path, tracker, out / ANSWERS, carry_out)
        if bench.known:
            tell(f"{bench.known} answers of an earlier start are taken up")
        try:
            found = hunt(study, bench, make, tell)
            if found is None:
                tell(f"no failure in {bench.runs} runs: {wanted.metric} kept to {wanted.limit}")
                return None
            hunted = bench.runs
            smallest = shrink(study, found, bench, make, tell)
        except KeyboardInterrupt as error:
            told = f"interrupted; {bench.known} answers are in {out / ANSWERS}, the same command goes on from there"
            raise Interrupted(told) from error
        tell(f"{hunted} runs to find it, {bench.runs - hunted} to shrink it")
        return _reproduced(study, wanted, smallest, bench, out)


@contextmanager
def _side_by_side(workers: int, scheduler: str | None) -> Iterator[CarryOut | None]:
    """Give what carries out runs on workers; nothing, where this process is enough."""
    if workers == 1 and scheduler is None:
        yield None
    else:
        with dask_runs.connect(workers, scheduler) as client:
            yield partial(dask_runs.rows_of, client)


def _reproduced(study: Study, wanted: Search, document: Json, bench: Bench, out: Path) -> Found:
    """Write the file, and run it as anybody will."""
    answer = bench.ask(document)
    what = _tell_failure(wanted, document, bench)
    file = out / f"{study.path.stem}.toml"
    named = {
        **document,
        "description": f"Found by luxloop search in {study.path.name}, the smallest failure: {_scene(document)}.",
        "reason": study.description,
        "expect": finding_file.expectation(wanted.metric, wanted.limit, what),
    }
    finding_file.write(named, bench.path, file)
    outcome = execute(Scenario.load(file), device.load(bench.tracker), out / RUN)
    if outcome.result.trace_hash != answer.trace_hash:
        raise StudyError(f"{file}: does not repeat itself: is {bench.tracker} deterministic? (luxloop check-tracker)")
    return Found(file, outcome, what)


def _tell_failure(wanted: Search, document: Json, bench: Bench) -> str:
    """Say what is seen; why it is so is for a person to find out."""
    value = bench.ask(document).value
    worst = reductions.failing_frame(document, bench)
    where = f"; worst in {worst}" if worst else ""
    return f"{value:.4g} where {wanted.limit} is wanted{where}"


def _scene(document: Json) -> str:
    """Count what is in it."""
    traffic = document["traffic"]
    counts = [(len(traffic.get(kind, [])), kind) for kind in ("actor", "obstacle")]
    scene = " and ".join(f"{count} {kind}{'s' * (count > 1)}" for count, kind in counts if count)
    return f"{scene or traffic['kind']} around the ego, {document['duration_s']:g} s long"
