"""`luxloop sweep`: all runs of a study, their rows on disk, and what is still missing after an interruption."""

from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

import pandas as pd

from scenarios.errors import InputError, Interrupted, OutputError
from scenarios.run import device, progress
from scenarios.study import dask_runs
from scenarios.study.design import runs
from scenarios.study.row_store import Rows
from scenarios.study.study_file import Study


@dataclass(frozen=True, slots=True)
class Sweep:
    """What has been run of a study."""

    study: Study
    rows: pd.DataFrame
    """A row per run that is done, in the order of the study."""
    count: int
    """Runs of the whole study."""
    taken_up: int = 0
    """Of them, runs whose rows were there from an earlier start."""


def sweep(
    study: Study, tracker: str, out: Path, workers: int, scheduler: str | None = None, keep_at: str | None = None
) -> Sweep:
    """Carry out what is not done yet.

    Parameters
    ----------
    study
        What to run.
    tracker
        MODULE:NAME of the device under test.
    out
        Folder of the rows; those of an earlier start are taken up.
    workers
        Processes of this computer, unless
    scheduler
        names a Dask scheduler.
    keep_at
        Folder or fsspec URL in which the folders of the runs are kept; nothing but the rows is kept if left out.

    Raises
    ------
    StudyError, OutputError
        As `runs`, `Rows` and `engine.connect`.
    Interrupted
        Ctrl-C; all rows that came in are on disk.
    """
    wanted = runs(study, tracker)
    device.load(tracker)  # that there is none should be told once, not by every row
    keys = [run.key for run in wanted]
    with Rows.opened(out, {vary.key: [run.parameters[vary.key] for run in wanted] for vary in study.vary}) as rows:
        todo = [run for run in wanted if run.key not in rows.keys]
        try:
            if todo:
                with (
                    dask_runs.connect(min(workers, len(todo)), scheduler) as client,
                    progress.runs(study.path.stem, len(wanted), len(wanted) - len(todo)) as advance,
                ):
                    for some in dask_runs.rows_of(client, todo, keep_at):
                        rows.add(some)
                        advance(len(some))
        except KeyboardInterrupt as error:
            raise Interrupted(f"interrupted; {_state(rows, keys, out)}") from error
        except InputError as error:
            raise type(error)(f"{error}; {_state(rows, keys, out)}") from error
        return Sweep(study, rows.join(keys), len(wanted), len(wanted) - len(todo))


def _state(rows: Rows, keys: list[str], out: Path) -> str:
    """Tidy up after a sweep that did not come to its end, and say what is there."""
    with suppress(OutputError):  # where the disk is full, the journal has to do
        rows.join(keys)
    return f"{len(rows.keys.intersection(keys))} of {len(keys)} rows are in {out}, the same command goes on from there"
