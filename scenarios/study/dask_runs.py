"""Execution of study runs on a Dask cluster: local processes or any Dask scheduler.

Only this module and `local_cluster` import `dask` and `distributed`; callers import them where they need them.
"""

import asyncio
import json
import logging
from collections.abc import Iterable, Iterator
from concurrent.futures import CancelledError
from contextlib import contextmanager
from dataclasses import dataclass
from itertools import islice

import dask
from distributed import Client, Future, KilledWorker, Security, as_completed, rpc

from luxloop.scenarios.errors import InputError, StudyError
from luxloop.scenarios.run.versions import installed
from luxloop.scenarios.study.design import StudyRun
from luxloop.scenarios.study.local_cluster import local_cluster
from luxloop.scenarios.study.row_format import RowFormat, RunRow
from luxloop.scenarios.study.worker import as_json, carry_out_as_lines, failed, first_columns

MAX_SUBMITTED = 4000
"""Maximum number of tasks submitted at a time: several per worker for a thousand workers, with bounded memory."""
FIRST_PER_WORKER = 2
"""Tasks per worker that are submitted before the first results are awaited; then two for each that is complete."""
SHORT_S = 15.0
"""Longest simulated time [s] of runs of which several are executed in one task: 1 to 2 s of processor time."""
MOST_AT_ONCE = 16
"""Maximum number of runs of a task: a worker that dies repeats at most so many."""
TASKS_PER_WORKER = 8
"""Least number of tasks per worker, so that all of them end at about the same time."""

TIMEOUT_S = 5
"""Connection timeout [s]."""

DASK_CONFIG = {
    # Profiling and monitoring are not used and cost processor time on machines with few cores.
    "distributed.worker.profile.enabled": False,
    "distributed.admin.tick.interval": "1s",
    "distributed.admin.system-monitor.interval": "10s",
    # The client's periodic request for the scheduler's state is not used. While results are gathered, it would open a
    # second connection, which the connection pool keeps.
    "distributed.client.scheduler-info-interval": "1 day",
    # LocalCluster removes a worker for good if its restart takes longer; without any worker, a sweep waits forever.
    "distributed.deploy.lost-worker-timeout": "1 day",
    # Without Dask's MALLOC_TRIM_THRESHOLD_, which makes workers release and reallocate the same memory every scan.
    "distributed.nanny.pre-spawn-environ": {"OMP_NUM_THREADS": 1, "MKL_NUM_THREADS": 1, "OPENBLAS_NUM_THREADS": 1},
}


@contextmanager
def connect(workers: int, scheduler: str | None) -> Iterator[Client]:
    """Yield a client of a Dask scheduler, or of a new local cluster.

    Parameters
    ----------
    workers
        Number of processes of the local cluster; not used with a scheduler.
    scheduler
        Address of a Dask scheduler, host:port; None for a local cluster.

    Raises
    ------
    StudyError
        No Dask scheduler answers at the address, or all workers of the local cluster ended.
    """
    for logger in ("distributed", "distributed.client"):  # a lost scheduler is reported as one line, not a traceback
        logging.getLogger(logger).setLevel(logging.CRITICAL)
    with dask.config.set(DASK_CONFIG):
        if scheduler is None:
            with local_cluster(workers) as cluster, Client(cluster, set_as_default=False) as client:
                yield client
        else:
            with _client_of(scheduler) as client:
                yield client


@dataclass(frozen=True, slots=True)
class Delivery:
    """Destination of the results of runs."""

    keep_at: str | None = None
    """Folder or fsspec URL that receives the folder of every run; None keeps no folders."""
    form: RowFormat | None = None
    """Format of the lines; None for JSON of all values."""
    parts: str | None = None
    """Folder or fsspec URL to which workers write the rows as Parquet parts; the lines are then empty."""


def rows_of(client: Client, runs: list[StudyRun]) -> Iterator[list[RunRow]]:
    """Execute runs; yield their rows in batches, as they complete. Errors are those of `lines_of`."""
    for batch in lines_of(client, iter(runs), len(runs), Delivery()):
        yield [json.loads(line) for _, line in batch]


def lines_of(
    client: Client, runs: Iterator[StudyRun], count: int, delivery: Delivery
) -> Iterator[list[tuple[StudyRun, str]]]:
    """Execute runs; yield them with their rows as text in batches, as they complete.

    Short runs of one study are executed several per task, as long as all workers have enough tasks. The runs are taken
    from `runs` when they are due: those that are planned last are not built before the first ones are executed.

    Parameters
    ----------
    client
        Client from `connect`.
    runs
        The runs.
    count
        Their number at most.
    delivery
        Where the results go.

    Raises
    ------
    StudyError
        The scheduler is lost, or a worker cannot execute any run.
    OutputError
        A worker cannot store the folder of its run, or its rows.
    """
    workers = max(1, sum(client.nthreads().values()))
    waiting = grouped(runs, min(MOST_AT_ONCE, 1 + count // (TASKS_PER_WORKER * workers)))
    tasks: dict[str, list[StudyRun]] = {}

    def submit(batches: Iterable[list[StudyRun]]) -> list[Future[list[str]]]:
        futures = []
        for batch in batches:
            # The client id in the key keeps tasks of two sweeps on one scheduler apart.
            key = f"luxloop-{batch[0].key}-{len(batch)}-{client.id}"
            tasks[key] = batch
            portable = [run.portable() for run in batch]
            arguments = (portable, delivery.keep_at, installed(), delivery.form, delivery.parts)
            futures.append(client.submit(carry_out_as_lines, *arguments, key=key, pure=False))
        return futures

    done = as_completed(submit(islice(waiting, FIRST_PER_WORKER * workers)), loop=client.loop)
    for futures in done.batches():
        finished = {future: tasks.pop(future.key) for future in futures}
        results, again = _results(client, finished, delivery.form)
        yield results
        done.update(submit([[run] for run in again]))
        done.update(submit(islice(waiting, max(0, min(2 * len(futures), MAX_SUBMITTED - len(tasks))))))


def grouped(runs: Iterator[StudyRun], most: int) -> Iterator[list[StudyRun]]:
    """Yield runs in the same order in groups of up to `most` short runs; other runs alone."""
    group: list[StudyRun] = []
    for run in runs:
        if float(run.document["duration_s"]) > SHORT_S:
            yield [run]
            continue
        group.append(run)
        if len(group) == most:
            yield group
            group = []
    if group:
        yield group


def _results(
    client: Client, tasks: dict[Future[list[str]], list[StudyRun]], form: RowFormat | None
) -> tuple[list[tuple[StudyRun, str]], list[StudyRun]]:
    """Return the runs of completed tasks with their lines, and runs to be executed alone; gather in one round trip."""
    try:
        lines = client.gather(list(tasks))
    except Exception:  # one of them failed: fetch them one by one
        lines = [_lines(client, runs, future, form) for future, runs in tasks.items()]
    done, again = list[tuple[StudyRun, str]](), list[StudyRun]()
    for runs, of_task in zip(tasks.values(), lines, strict=True):
        if of_task:
            done += zip(runs, of_task, strict=True)
        else:
            again += runs
    return done, again


def _lines(client: Client, runs: list[StudyRun], future: Future[list[str]], form: RowFormat | None) -> list[str]:
    """Return the lines of a completed task, an error row for a run that killed its workers, and none for several."""
    try:
        lines: list[str] = future.result()
        return lines
    except InputError:
        raise
    except KilledWorker:
        if len(runs) > 1:  # one of them is to blame
            return []
        row = first_columns(runs[0]) | failed("each worker that tried it died: out of memory, or killed by the run")
        return [form.line(row) if form else as_json(row)]
    except (CancelledError, OSError) as error:
        raise StudyError("the connection to the Dask scheduler is lost") from error
    except Exception as error:
        if client.cluster is not None:  # a local one, with the packages of this process: a defect of luxloop
            raise
        reason = f"{type(error).__name__}: {error}"
        raise StudyError(f"a worker cannot execute runs ({reason}); install the same packages there as here") from error


def _client_of(scheduler: str) -> Client:
    try:
        # Client waits forever for a server that accepts the connection but never replies.
        asyncio.run(asyncio.wait_for(_check_identity(scheduler), TIMEOUT_S))
        return Client(scheduler, timeout=TIMEOUT_S, set_as_default=False)
    except (OSError, ValueError) as error:
        raise StudyError(f"--scheduler {scheduler}: no Dask scheduler answers there; give its host:port") from error


async def _check_identity(scheduler: str) -> None:
    async with rpc(scheduler, connection_args=Security().get_connection_args("client")) as remote:
        if (await remote.identity())["type"] != "Scheduler":
            raise ValueError("the server is a Dask process, but not a scheduler")
