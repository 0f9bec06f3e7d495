"""Execution of the runs of a search on workers."""

from collections.abc import Iterator
from contextlib import contextmanager

from luxloop.scenarios.search.evaluator import Executor


@contextmanager
def executor(workers: int, scheduler: str | None) -> Iterator[Executor | None]:
    """Yield a function that executes runs on workers; None for a single worker, which needs no other process."""
    if workers == 1 and scheduler is None:
        yield None
    else:
        from luxloop.scenarios.study import dask_runs  # imports dask, which is slow and optional

        with dask_runs.connect(workers, scheduler) as client:
            yield lambda runs: dask_runs.rows_of(client, runs, len(runs))
