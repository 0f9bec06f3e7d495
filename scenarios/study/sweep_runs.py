"""Sweeps: plan and execute all runs of a study, and resume after an interruption."""

import json
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from itertools import chain, islice
from pathlib import Path

import pandas as pd
import pyarrow as pa

from luxloop.scenarios.errors import InputError, Interrupted, OutputError
from luxloop.scenarios.metrics.definitions import survival_measure
from luxloop.scenarios.run import device, progress
from luxloop.scenarios.study import design, run_content
from luxloop.scenarios.study.design import StudyRun
from luxloop.scenarios.study.row_store import FIXED_COLUMNS, TABLE, RowStore, RunRow, schema_of
from luxloop.scenarios.study.study_file import Study
from luxloop.scenarios.study.survival import survival_columns

NEW = "new"
TAKEN_OVER = "taken over: the same scenario, files, sources and versions"
RETRIED = "run again: it ended with an error"
AGAIN = "run again: "
"""Reasons why the row of a run is taken over from an earlier start, or the run is executed."""
CHECKED_FIRST = 100
"""Combinations that are built and validated before the first run; the others are while earlier ones are executed."""

Combination = tuple[str, ...]
"""Texts of seed, tracker and values of all parameters."""


class SweepPlan:
    """Plan of a sweep: the first combinations are built at once, the others when `missing` is asked for their runs.

    Parameters
    ----------
    study
        The study.
    tracker
        MODULE:NAME of the device under test.
    rows
        Rows of earlier starts.
    retry_errors
        True to execute runs again whose row has the status `error`.

    Raises
    ------
    StudyError
        As for `design.plan`.
    """

    def __init__(self, study: Study, tracker: str, rows: RowStore, *, retry_errors: bool) -> None:
        self._parameters = [parameter.key for parameter in study.vary]
        known = ("key", "status", "inputs", "seed", "tracker", *self._parameters)
        self._earlier = [{name: row[name] for name in known} for row in rows.facts()]
        self._status = {row["key"]: row["status"] for row in self._earlier}
        self._retry_errors = retry_errors
        new, earlier = self._split(study, tracker)
        planned = design.plan(study, tracker, new + earlier)
        self._checked = list(islice(planned, CHECKED_FIRST))
        self._planned = chain.from_iterable(chain(self._checked, planned))
        self._keys: dict[int, str] = {}
        self._count = (len(new) + len(earlier)) * len(study.seed_list)
        self._new = len(new) * len(study.seed_list)
        self.taken_over: set[str] = set()
        """Keys of the planned runs whose rows are reused."""

    def _split(self, study: Study, tracker: str) -> tuple[list[int], list[int]]:
        """Return the numbers of the combinations that miss a row, and of those with rows for all seeds.

        Only the scene says whether such rows are up to date. Those scenes are built last: the first run of a resumed
        sweep does not wait for them.
        """
        rows = (row for row in self._earlier if not self._is_retried(row["status"]))
        known = {combination(row, self._parameters) for row in rows}
        split: tuple[list[int], list[int]] = [], []
        for number, values in enumerate(design.combinations(study)):
            runs = ({"seed": seed, "tracker": tracker, **values} for seed in study.seed_list)
            split[all(combination(run, self._parameters) in known for run in runs)].append(number)
        return split

    def _is_retried(self, status: str) -> bool:
        return status == "error" and self._retry_errors

    @property
    def keys(self) -> list[str]:
        """Keys of the runs planned so far, in the order of the study."""
        checked = {run.index: run.key for of_combination in self._checked for run in of_combination}
        return [key for _, key in sorted((checked | self._keys).items())]

    @property
    def unseen(self) -> int:
        """Number of runs that are not planned yet and have a row of an earlier start, which may be out of date."""
        return self._count - max(self._new, len(self.keys))

    def missing(self) -> Iterator[StudyRun]:
        """Yield the runs without a row, once each, with the reason why they are executed.

        Runs of combinations that miss a row come first.

        Raises
        ------
        StudyError
            A combination after the first `CHECKED_FIRST` is not a valid scenario.
        """
        seen, inputs = set[str](), dict[Combination, str]()
        for run in self._planned:
            key = run.key
            self._keys[run.index] = key
            status = self._status.get(key)
            retried = status is not None and self._is_retried(status)
            if status is not None and not retried:
                self.taken_over.add(key)
            elif key not in seen:
                seen.add(key)
                inputs = inputs or {combination(row, self._parameters): row["inputs"] for row in self._earlier}
                yield run.because(RETRIED if retried else why_run(run, inputs))


def why_run(run: StudyRun, inputs: Mapping[Combination, str]) -> str:
    """Return why a run without a row is executed: it is new, or its inputs differ from those of an earlier row.

    Parameters
    ----------
    run
        The run.
    inputs
        Digests of the inputs of earlier rows, as JSON; the latest of each combination.
    """
    before = inputs.get(combination({"seed": run.seed, "tracker": run.tracker, **run.parameters}, [*run.parameters]))
    if before is None:
        return NEW
    return AGAIN + ", ".join(run_content.changes(json.loads(before or "{}"), run.inputs))


def combination(row: RunRow, parameters: Sequence[str]) -> Combination:
    """Return seed, tracker and values of the varied parameters of a row as texts, which can be compared."""
    values = (row[key] for key in ("seed", "tracker", *parameters))
    return tuple(
        f"{float(value):.12g}" if isinstance(value, int | float) and not isinstance(value, bool) else str(value)
        for value in values
    )


@dataclass(frozen=True, slots=True)
class Sweep:
    """Completed runs of a study."""

    study: Study
    rows: pd.DataFrame
    """Rows of the completed runs, in the order of the study."""
    count: int
    """Number of runs of the whole study."""
    taken_up: int = 0
    """Number of runs whose rows were reused from an earlier start."""
    keep_at: str | None = None
    """Folder or fsspec URL of the run folders, if they are kept."""


def sweep(
    study: Study,
    tracker: str,
    out: Path,
    workers: int,
    scheduler: str | None = None,
    keep_at: str | None = None,
    retry_errors: bool = False,
) -> Sweep:
    """Execute all runs of a study that have no row yet.

    Parameters
    ----------
    study
        The study.
    tracker
        MODULE:NAME of the device under test.
    out
        Folder of the rows; rows of an earlier start are reused.
    workers
        Number of local processes; not used with a scheduler.
    scheduler
        Address of a Dask scheduler.
    keep_at
        Folder or fsspec URL that receives the folder of every run; default: only the rows are kept.
    retry_errors
        True to execute runs again whose row has the status `error`.

    Raises
    ------
    StudyError, OutputError
        As for `design.runs`, `RowStore` and `dask_runs.connect`.
    Interrupted
        Ctrl-C was pressed; all rows received so far are on disk.
    """
    combinations = design.combinations(study)
    count = len(combinations) * len(study.seed_list)
    device.load(tracker)  # an invalid tracker is reported once, not in every row
    values = {parameter.key: [values[parameter.key] for values in combinations] for parameter in study.vary}
    schema = schema_of(values, [*(metric.name for metric in study.metric), *study.filtered_metrics])
    with RowStore.opened(out, values) as rows:
        plan = SweepPlan(study, tracker, rows, retry_errors=retry_errors)
        try:
            _execute(plan, rows, count, workers, scheduler, keep_at, study.path.stem)
        except KeyboardInterrupt as error:
            raise Interrupted(f"interrupted; {_state(plan, rows, schema, count, out)}") from error
        except InputError as error:
            raise type(error)(f"{error}; {_state(plan, rows, schema, count, out)}") from error
        rows.write_table(schema, plan.keys, plan.taken_over, TAKEN_OVER)
        found = pd.read_parquet(out / TABLE, columns=columns(study))
        return Sweep(study, found, count, len(plan.taken_over), keep_at)


def _execute(
    plan: SweepPlan,
    rows: RowStore,
    count: int,
    workers: int,
    scheduler: str | None,
    keep_at: str | None,
    name: str,
) -> None:
    """Execute the missing runs and store their rows; without any, nothing is started."""
    missing = plan.missing()
    first = next(missing, None)
    if first is None:
        return
    from luxloop.scenarios.study import dask_runs  # imports dask, which is slow and optional

    with (
        dask_runs.connect(min(workers, count), scheduler) as client,
        progress.runs(name, count, len(plan.taken_over)) as advance,
    ):
        known = len(plan.taken_over)
        for batch in dask_runs.rows_of(client, chain([first], missing), count, keep_at):
            rows.add(batch)
            advance(len(batch) + len(plan.taken_over) - known)
            known = len(plan.taken_over)


def columns(study: Study) -> list[str]:
    """Return the columns that report and summary of a study need: all but the metrics that no curve shows."""
    metrics: list[str] = []
    for curve in study.curve:
        metrics += [key for key in (curve.metric, *curve.keys) if study.definition(key)]
        if measure := survival_measure(curve.metric) if curve.kind == "survival" else None:
            metrics += survival_columns(*measure)
    return list(dict.fromkeys([*FIXED_COLUMNS[:4], *(p.key for p in study.vary), *FIXED_COLUMNS[4:-1], *metrics]))


def _state(plan: SweepPlan, rows: RowStore, schema: pa.Schema, count: int, out: Path) -> str:
    """Write the table of an unfinished sweep and return a message with the number of its rows."""
    keys = plan.keys
    with suppress(OutputError):  # if the disk is full, the rows are in the SQLite file
        rows.write_table(schema, keys, plan.taken_over, TAKEN_OVER)
    unseen = f", and up to {plan.unseen} of an earlier start" if plan.unseen else ""
    return f"{len(rows.keys.intersection(keys))} of {count} rows are in {out}{unseen}; run the same command to resume"
