"""Execution of the runs of a search on workers."""

from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial

from luxloop.scenarios.search.evaluator import Executor


@contextmanager
def executor(workers: int, scheduler: str | None) -> Iterator[Executor | None]:
    """Yield a function that executes runs on workers; None for a single worker, which needs no other process."""
    if workers == 1 and scheduler is None:
        yield None
    else:
        from luxloop.scenarios.study import dask_runs  # imports dask, which is slow and optional

        with dask_runs.connect(workers, scheduler) as client:
            yield partial(dask_runs.rows_of, client)
