"""Evaluation of scenarios for a search; results are stored on disk, so that a restart repeats no run."""

import json
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from luxloop.scenarios.errors import Interrupted, OutputError
from luxloop.scenarios.exit_codes import INTERNAL_ERROR
from luxloop.scenarios.search.objective import fails
from luxloop.scenarios.study import append_log
from luxloop.scenarios.study.design import StudyRun
from luxloop.scenarios.study.row_format import RunRow
from luxloop.scenarios.study.run_content import Contents
from luxloop.scenarios.study.study_file import Search
from luxloop.scenarios.study.worker import BROKEN, carry_out

Json = dict[str, Any]

EVALUATIONS = "answers.jsonl"
"""Name of the log of evaluations."""

Executor = Callable[[list[StudyRun]], Iterable[list[RunRow]]]
"""Executes runs, and yields their rows in batches, as they complete."""

Notify = Callable[[str], None]
"""Receives a line of text."""


def no_report(_line: str) -> None:
    """Ignore a line of text."""


@dataclass(frozen=True, slots=True)
class Evaluation:
    """Result of one run."""

    key: str
    """Key of the run, see `StudyRun.key`."""
    value: float | None
    """Value of the metric; None if the run did not complete, or the metric does not apply."""
    trace_hash: str
    error: str
    """Error of a run that failed or ended early."""


class Evaluator:
    """Evaluates scenarios by one metric.

    An evaluation with an error is reused as any other, unless `retry_errors` is set.

    Parameters
    ----------
    search
        Metric and limit.
    path
        Path that the scenarios' file would have: paths in the scenarios are relative to its folder.
    tracker
        MODULE:NAME of the device under test.
    log
        Append log of the evaluations, one JSON object per line; those of an earlier start are reused.
    execute_runs
        Executes runs, e.g. `dask_runs.rows_of` with a client; default: sequential execution in this process.
    retry_errors
        True to run again what ended with an error; the log keeps both, the later one counts.
    report_defect
        Receives the error of every evaluation that ended by a defect of luxloop.

    Raises
    ------
    OutputError
        The log cannot be read, or is not a log of evaluations.
    """

    def __init__(
        self,
        search: Search,
        path: Path,
        tracker: str,
        log: Path,
        execute_runs: Executor | None = None,
        *,
        retry_errors: bool = False,
        report_defect: Notify = no_report,
    ) -> None:
        self._report_defect = report_defect
        self.search, self.path, self.tracker = search, path, tracker
        self._contents = Contents(tracker)
        self._log, self._execute_runs = log, execute_runs or _execute_sequentially
        earlier = _read(log)
        self._evaluations = {key: one for key, one in earlier.items() if not (retry_errors and one.error)}
        self.retried = len(earlier) - len(self._evaluations)
        """Number of evaluations that ended with an error and are run again."""
        self.runs = 0
        """Number of scenarios evaluated so far, including those known from the log."""

    @contextmanager
    def resumable(self) -> Iterator[None]:
        """Raise `Interrupted`, which says how to resume, for a KeyboardInterrupt in the body."""
        try:
            yield
        except KeyboardInterrupt as error:
            raise Interrupted(
                f"interrupted; {self.known} evaluations are in {self._log}; run the same command to resume"
            ) from error

    @property
    def known(self) -> int:
        """Number of scenarios whose evaluation is known."""
        return len(self._evaluations)

    def evaluate(self, document: Json) -> Evaluation:
        """Return the evaluation of a scenario; run it if it is not known."""
        (evaluation,) = self.evaluate_all([document])
        return evaluation

    def evaluate_all(self, documents: list[Json]) -> list[Evaluation]:
        """Return the evaluations of scenarios in the same order; run those that are not known in parallel."""
        runs = [
            StudyRun(
                self.runs + n,
                {},
                document["seed"],
                document,
                self.path,
                self.tracker,
                self._contents.of(document, self.path.parent),
            )
            for n, document in enumerate(documents, 1)
        ]
        self.runs += len(runs)
        new = {run.key: run for run in runs if run.key not in self._evaluations}
        for rows in self._execute_runs(list(new.values())) if new else ():
            for row in rows:
                self._store(self._evaluation(row))
        evaluations = [self._evaluations[run.key] for run in runs]
        for evaluation in evaluations:
            if evaluation.error.startswith(INTERNAL_ERROR):
                self._report_defect(evaluation.error)
        return evaluations

    def fails(self, document: Json) -> bool:
        """Return True if the metric violates its limit in a scenario."""
        return fails(self.search.limit, self.evaluate(document).value)

    def _evaluation(self, row: RunRow) -> Evaluation:
        broken = row["status"] in BROKEN
        return Evaluation(row["key"], None if broken else row.get(self.search.metric), row["trace_hash"], row["error"])

    def _store(self, evaluation: Evaluation) -> None:
        self._evaluations[evaluation.key] = evaluation
        try:
            append_log.append(self._log, json.dumps(asdict(evaluation)) + "\n")
        except OSError as error:
            raise OutputError(
                f"{self._log}: cannot write there ({error.strerror}); earlier evaluations are stored: "
                "free some space and run the same command to resume"
            ) from error


def _execute_sequentially(runs: list[StudyRun]) -> Iterable[list[RunRow]]:
    for run in runs:
        yield [carry_out(run)]


def _read(log: Path) -> dict[str, Evaluation]:
    """Return the evaluations of a log by key; an incomplete last line is removed."""
    try:
        log.parent.mkdir(parents=True, exist_ok=True)
        append_log.truncate_partial_line(log)
        lines = log.read_text(encoding="utf-8").splitlines() if log.exists() else []
        evaluations = [Evaluation(**json.loads(line)) for line in lines]
    except OSError as error:
        raise OutputError(f"{log}: {error.strerror}; choose another folder with --out") from error
    except (ValueError, TypeError) as error:
        raise OutputError(f"{log}: not a log of a search; choose a new folder with --out") from error
    return {evaluation.key: evaluation for evaluation in evaluations}
