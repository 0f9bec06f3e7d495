"""Sweeps: execute all runs of a study and resume after an interruption."""

from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

import pandas as pd

from scenarios.errors import InputError, Interrupted, OutputError
from scenarios.run import device, progress
from scenarios.study.design import runs
from scenarios.study.row_reasons import RETRIED, TAKEN_OVER, RowReasons
from scenarios.study.row_store import RowStore
from scenarios.study.study_file import Study


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
    wanted = runs(study, tracker)
    device.load(tracker)  # an invalid tracker is reported once, not in every row
    keys = [run.key for run in wanted]
    values = {parameter.key: [run.parameters[parameter.key] for run in wanted] for parameter in study.vary}
    with RowStore.opened(out, values, [metric.name for metric in study.metric]) as rows:
        failed = {key for key, row in rows.earlier.items() if row["status"] == "error"} if retry_errors else set()
        missing = {key: run for key, run in zip(keys, wanted, strict=True) if key not in rows.keys or key in failed}
        todo, taken_over = list(missing.values()), set(keys).difference(missing)
        reasons = RowReasons([parameter.key for parameter in study.vary], rows.earlier.values())
        why = {key: RETRIED if key in failed else reasons.why_run(run) for key, run in missing.items()}
        try:
            if todo:
                from scenarios.study import dask_runs  # imports dask, which is slow and optional

                with (
                    dask_runs.connect(min(workers, len(todo)), scheduler) as client,
                    progress.runs(study.path.stem, len(wanted), len(wanted) - len(todo)) as advance,
                ):
                    for batch in dask_runs.rows_of(client, todo, keep_at):
                        rows.add([row | {"why": why[row["key"]]} for row in batch])
                        advance(len(batch))
        except KeyboardInterrupt as error:
            raise Interrupted(f"interrupted; {_state(rows, keys, taken_over, out)}") from error
        except InputError as error:
            raise type(error)(f"{error}; {_state(rows, keys, taken_over, out)}") from error
        return Sweep(study, rows.merge(keys, taken_over, TAKEN_OVER), len(wanted), len(wanted) - len(todo))


def _state(rows: RowStore, keys: list[str], taken_over: set[str], out: Path) -> str:
    """Merge the rows of an unfinished sweep and return a message with their number."""
    with suppress(OutputError):  # if the disk is full, the rows stay in the append log
        rows.merge(keys, taken_over, TAKEN_OVER)
    return f"{len(rows.keys.intersection(keys))} of {len(keys)} rows are in {out}; run the same command to resume"
