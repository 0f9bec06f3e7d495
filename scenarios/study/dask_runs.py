"""Execution of study runs on a Dask cluster: local processes or any Dask scheduler.

The only module that imports `dask` and `distributed`; callers import it where they need it.
"""

import asyncio
import json
import logging
import signal
from collections.abc import Iterator
from concurrent.futures import CancelledError
from contextlib import contextmanager
from itertools import islice
from multiprocessing import resource_tracker

import dask
from distributed import Client, Future, KilledWorker, LocalCluster, Security, as_completed, rpc

from scenarios.errors import InputError, StudyError
from scenarios.run.versions import installed
from scenarios.study.design import StudyRun
from scenarios.study.worker import RunRow, carry_out_as_json, failed, first_columns

MAX_SUBMITTED = 4000
"""Maximum number of runs submitted to the scheduler: several per worker for a thousand workers, with bounded memory."""

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
        No Dask scheduler answers at the address.
    """
    for logger in ("distributed", "distributed.client"):  # a lost scheduler is reported as one line, not a traceback
        logging.getLogger(logger).setLevel(logging.CRITICAL)
    with dask.config.set(DASK_CONFIG):
        if scheduler is None:
            with _local_cluster(workers) as cluster, Client(cluster, set_as_default=False) as client:
                yield client
        else:
            with _client_of(scheduler) as client:
                yield client


def rows_of(client: Client, runs: list[StudyRun], keep_at: str | None = None) -> Iterator[list[RunRow]]:
    """Execute runs; yield their rows in batches, as they complete.

    Parameters
    ----------
    client
        Client from `connect`.
    runs
        The runs.
    keep_at
        Folder or fsspec URL that receives the folder of every run; default: the folders are not kept.

    Raises
    ------
    StudyError
        The scheduler is lost, or a worker cannot execute any run.
    OutputError
        A worker cannot store the folder of its run.
    """
    waiting = iter(runs)
    run_of: dict[str, StudyRun] = {}

    def submit(count: int) -> list[Future[str]]:
        # The client id in the key keeps tasks of two sweeps on one scheduler apart.
        batch = {f"luxloop-{run.key}-{client.id}": run for run in islice(waiting, count)}
        run_of.update(batch)
        return [
            client.submit(carry_out_as_json, run.portable(), keep_at, installed(), key=key, pure=False)
            for key, run in batch.items()
        ]

    done = as_completed(submit(MAX_SUBMITTED), loop=client.loop)
    for futures in done.batches():
        yield _rows(client, {future: run_of.pop(future.key) for future in futures})
        done.update(submit(len(futures)))


def _rows(client: Client, run_of: dict[Future[str], StudyRun]) -> list[RunRow]:
    """Return the rows of completed runs, gathered in one round trip."""
    try:
        return [json.loads(text) for text in client.gather(list(run_of))]
    except Exception:  # one of them failed: fetch them one by one
        return [_row(run, future) for future, run in run_of.items()]


def _row(run: StudyRun, future: Future[str]) -> RunRow:
    """Return the row of a completed run, or an error row if the run killed its workers."""
    try:
        row: RunRow = json.loads(future.result())
        return row
    except InputError:
        raise
    except KilledWorker:
        return first_columns(run) | failed("each worker that tried it died: out of memory, or killed by the run")
    except (CancelledError, OSError) as error:
        raise StudyError("the connection to the Dask scheduler is lost") from error
    except Exception as error:
        reason = f"{type(error).__name__}: {error}"
        raise StudyError(f"a worker cannot execute runs ({reason}); install the same packages there as here") from error


@contextmanager
def _local_cluster(workers: int) -> Iterator[LocalCluster]:
    """Start workers that ignore Ctrl-C, which a terminal sends to all its processes: only this process handles it.

    Workers, including restarted ones, inherit the signal mask of the threads that start here.
    """
    resource_tracker.ensure_running()  # CPython clears the signal mask of the thread that starts the tracker
    signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        with LocalCluster(
            n_workers=workers,
            threads_per_worker=1,
            processes=True,
            dashboard_address="127.0.0.1:0",
            memory_limit=0,
            silence_logs=logging.CRITICAL,
        ) as cluster:
            signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGINT})
            yield cluster
    finally:
        signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGINT})


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
