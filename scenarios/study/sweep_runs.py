"""Sweeps: execute all runs of a study and resume after an interruption."""

from contextlib import suppress
from dataclasses import dataclass
from itertools import chain
from pathlib import Path

import pandas as pd
import pyarrow as pa

from luxloop.scenarios.errors import InputError, Interrupted, OutputError
from luxloop.scenarios.metrics.definitions import survival_measure
from luxloop.scenarios.run import device, progress
from luxloop.scenarios.study import design
from luxloop.scenarios.study.row_store import FIXED_COLUMNS, TABLE, RowStore, schema_of
from luxloop.scenarios.study.study_file import Study
from luxloop.scenarios.study.survival import survival_columns
from luxloop.scenarios.study.sweep_plan import TAKEN_OVER, SweepPlan


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
