"""Objective of a search and evaluation of scenarios; results are stored on disk, so that a restart repeats no run."""

import math
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Self

from luxloop.scenarios.errors import Interrupted
from luxloop.scenarios.exit_codes import INTERNAL_ERROR
from luxloop.scenarios.files.expect import Limit
from luxloop.scenarios.metrics.own_metric import PREFIX
from luxloop.scenarios.run import device
from luxloop.scenarios.study.design import StudyRun
from luxloop.scenarios.study.parameter import Parameter, Value
from luxloop.scenarios.study.row_store import RowStore, RowText, RunRow, as_row, as_text, schema_of
from luxloop.scenarios.study.run_content import Contents
from luxloop.scenarios.study.study_file import Search
from luxloop.scenarios.study.worker import BROKEN, carry_out

NO_VALUE_SCORE = 3.0
"""Score of a run in which the metric has no value: worse than all others."""


def size(varied: Sequence[Parameter], values: Mapping[str, Value]) -> float:
    """Return the size of a disturbance, 0 (all parameters neutral) to 1 (all as far from neutral as possible).

    The size is the mean distance over the parameters. This norm (L1) favours few large disturbances over many small
    ones, so that the cause of a failure is easier to see.
    """
    return sum(distance(parameter, values[parameter.key]) for parameter in varied) / len(varied)


def distance(parameter: Parameter, value: Value) -> float:
    """Return the distance of a value from neutral, relative to the farther end of the range.

    For texts and booleans, every value other than neutral has the distance 1.
    """
    assert parameter.neutral is not None
    if value == parameter.neutral:
        return 0.0
    ends = parameter.values if parameter.values is not None else [parameter.low, parameter.high]
    if any(isinstance(end, str | bool) for end in ends):
        return 1.0
    positions = [_position(parameter, end) for end in ends if end is not None]
    neutral = _position(parameter, parameter.neutral)
    return abs(_position(parameter, value) - neutral) / max(abs(end - neutral) for end in positions)


def _position(parameter: Parameter, value: Value) -> float:
    return math.log(float(value)) if parameter.scale == "log" else float(value)


def fails(limit: Limit, value: float | None) -> bool:
    """Return True if a metric violates its limit; a metric without a value is not a failure."""
    return value is not None and not limit.holds(value)


def score(limit: Limit, value: float | None, disturbance: float) -> float:
    """Return the score that the search minimises: the size of a disturbance that fails; more than 1 for all others.

    The others are scored by the metric's distance to its limit, and by their size: most tracking metrics are counts,
    which are constant until they fail, and larger disturbances are more likely to fail.
    """
    if value is None:
        return NO_VALUE_SCORE
    if fails(limit, value):
        return disturbance
    margin = min(abs(end - value) for end in (limit.min, limit.max) if end is not None)
    return 1.0 + 0.5 * (margin / (1.0 + margin)) + 0.5 * (1.0 - disturbance)


Json = dict[str, Any]

Executor = Callable[[list[StudyRun]], Iterable[list[RowText]]]
"""Executes runs, and yields their rows in batches, as they complete."""

Notify = Callable[[str], None]
"""Receives a line of text."""


def no_report(_line: str) -> None:
    """Ignore a line of text."""


@dataclass(frozen=True, slots=True)
class TrialOptions:
    """Where the runs of a search are executed, and what becomes of errors."""

    workers: int = 1
    """Number of local processes; not used with a scheduler."""
    scheduler: str | None = None
    """Address of a Dask scheduler."""
    retry_errors: bool = False
    """True to run again what ended with an error."""
    report_defect: Notify = no_report
    """Receives the error of every evaluation that ended by a defect of luxloop."""


BY_DEFAULT = TrialOptions()


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

    An evaluation with an error is reused as any other, unless `options.retry_errors` is set.

    Parameters
    ----------
    search
        Metric and limit.
    path
        Path that the scenarios' file would have: paths in the scenarios are relative to its folder.
    tracker
        MODULE:NAME of the device under test.
    rows
        Rows of the evaluated scenarios; those of an earlier start are reused.
    execute_runs
        Executes runs on workers; default: sequential execution in this process.
    options
        Options on errors.
    """

    def __init__(
        self,
        search: Search,
        path: Path,
        tracker: str,
        rows: RowStore,
        execute_runs: Executor | None = None,
        options: TrialOptions = BY_DEFAULT,
    ) -> None:
        self._report_defect = options.report_defect
        self.search, self.path, self.tracker = search, path, tracker
        self._contents = Contents(tracker)
        self._metrics = () if search.metric.startswith(PREFIX) else (search.metric,)
        self._rows, self._execute_runs = rows, execute_runs or _execute_sequentially
        self._asked: dict[str, None] = {}
        earlier = {row["key"]: self._evaluation(row) for row in rows.rows()}
        self._evaluations = {key: one for key, one in earlier.items() if not (options.retry_errors and one.error)}
        self.retried = len(earlier) - len(self._evaluations)
        """Number of evaluations that ended with an error and are run again."""
        self.runs = 0
        """Number of scenarios evaluated so far, including those of an earlier start."""

    @classmethod
    @contextmanager
    def opened(
        cls, search: Search, path: Path, tracker: str, out: Path, notify: Notify, options: TrialOptions, at_once: int
    ) -> Iterator[Self]:
        """Yield an evaluator whose rows are in the folder `out`, and which executes up to `at_once` runs at a time.

        Raises
        ------
        DeviceError, OutputError
            The tracker cannot be loaded; the folder cannot be written.
        """
        device.load(tracker)  # an invalid tracker is reported once, not by every evaluation
        workers = min(options.workers, at_once)
        with RowStore.opened(out) as rows, executor(workers, options.scheduler) as execute_runs:
            evaluator = cls(search, path, tracker, rows, execute_runs, options)
            if evaluator.known:
                notify(f"{evaluator.known} evaluations of an earlier start are reused")
            if evaluator.retried:
                notify(f"{evaluator.retried} evaluations ended with an error and are run again")
            yield evaluator

    @contextmanager
    def resumable(self) -> Iterator[None]:
        """Raise `Interrupted`, which says how to resume, for a KeyboardInterrupt in the body."""
        try:
            yield
        except KeyboardInterrupt as error:
            raise Interrupted(
                f"interrupted; {self.known} evaluations are in {self._rows.path}; run the same command to resume"
            ) from error

    def write_table(self, own: Collection[str]) -> None:
        """Write the rows of the evaluated scenarios to the Parquet file, in the order of their evaluation.

        Parameters
        ----------
        own
            Names of the metrics of the study file.

        Raises
        ------
        OutputError
            The file cannot be written.
        """
        self._rows.write_table(schema_of({}, own), list(self._asked))

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
                metrics=self._metrics,
            )
            for n, document in enumerate(documents, 1)
        ]
        self.runs += len(runs)
        self._asked |= {run.key: None for run in runs}
        new = {run.key: run for run in runs if run.key not in self._evaluations}
        for rows in self._execute_runs(list(new.values())) if new else ():
            self._rows.add(rows)
            self._evaluations |= {row[0]: self._evaluation(as_row(row)) for row in rows}
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


def _execute_sequentially(runs: list[StudyRun]) -> Iterable[list[RowText]]:
    for run in runs:
        yield [as_text(carry_out(run))]


@contextmanager
def executor(workers: int, scheduler: str | None) -> Iterator[Executor | None]:
    """Yield a function that executes runs on workers; None for a single worker, which needs no other process."""
    if workers == 1 and scheduler is None:
        yield None
    else:
        from luxloop.scenarios.study import dask_runs  # imports dask, which is slow and optional

        with dask_runs.connect(workers, scheduler) as client:
            yield lambda runs: dask_runs.rows_of(client, runs, len(runs))
