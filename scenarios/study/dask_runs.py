"""Execution of study runs on a Dask cluster: local processes or any Dask scheduler.

Only this module imports `dask` and `distributed`; callers import it where they need it.
"""

import asyncio
import logging
import signal
import socket
import threading
from collections.abc import Iterable, Iterator
from concurrent.futures import CancelledError
from contextlib import contextmanager
from itertools import islice

import dask
from distributed import (
    Client,
    Future,
    KilledWorker,
    LocalCluster,
    Security,
    Status,
    Worker,
    WorkerPlugin,
    as_completed,
    rpc,
)
from tornado.ioloop import PeriodicCallback

from luxloop.scenarios.errors import InputError, StudyError
from luxloop.scenarios.run.termination import start_resource_tracker
from luxloop.scenarios.run.versions import installed
from luxloop.scenarios.study.design import StudyRun
from luxloop.scenarios.study.row_store import RowText, as_text
from luxloop.scenarios.study.worker import carry_out_as_texts, failed, first_columns

OF_TERMINALS = {signal.SIGINT, signal.SIGHUP}
"""Signals of Ctrl-C and of a terminal that closes."""
ENDED = {Status.failed, Status.closing, Status.closed}
"""Status of a supervisor of a worker process that has given up; it restarts killed processes until then."""
WATCH_S = 5.0
"""Interval [s] between checks for workers."""


@contextmanager
def local_cluster(workers: int) -> Iterator[LocalCluster]:
    """Yield a cluster whose workers ignore the signals of a terminal, which it sends to all its processes.

    Only this process reacts to them. Workers, including restarted ones, inherit the signal mask of the threads that
    start here.

    Raises
    ------
    StudyError
        All workers ended, and cannot be started again.
    """
    start_resource_tracker()
    try:
        signal.pthread_sigmask(signal.SIG_BLOCK, OF_TERMINALS)
        with LocalCluster(
            n_workers=workers,
            threads_per_worker=1,
            processes=True,
            dashboard_address=f"{LOOPBACK}:0",
            memory_limit=0,
            silence_logs=logging.CRITICAL,
        ) as cluster:
            signal.pthread_sigmask(signal.SIG_UNBLOCK, OF_TERMINALS)
            with _watched(cluster):
                yield cluster
    finally:
        signal.pthread_sigmask(signal.SIG_UNBLOCK, OF_TERMINALS)


@contextmanager
def _watched(cluster: LocalCluster) -> Iterator[None]:
    """Close the scheduler if no worker can be started any more: Dask would wait for one forever."""
    without_workers, scheduler, loop = threading.Event(), cluster.scheduler, cluster.loop
    assert scheduler is not None
    assert loop is not None

    async def check() -> None:
        if all(worker.status in ENDED for worker in cluster.workers.values()):
            watch.stop()
            without_workers.set()
            cluster.shutdown_scheduler = False  # at its end, which would wait 30 s for the answer of a closed one
            await scheduler.close()

    watch = PeriodicCallback(check, 1000.0 * WATCH_S)
    loop.add_callback(watch.start)
    try:
        yield
    except StudyError as error:
        if without_workers.is_set():
            raise StudyError(
                "all worker processes ended and could not be started again: out of memory, or a full disk of "
                "temporary files"
            ) from error
        raise
    finally:
        loop.add_callback(watch.stop)


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
LOOPBACK = "127.0.0.1"
"""Address of the local cluster."""

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


class WithoutProfiler(WorkerPlugin):
    """Stop the sampling profiler of a worker.

    It calls `sys._current_frames`, which deadlocks with a busy thread in CPython 3.11 now and then
    (github.com/python/cpython/issues/106883): the run never ends, and the sweep waits for it.
    """

    name = "luxloop-without-profiler"

    def setup(self, worker: Worker) -> None:
        """Remove the profiler's callbacks: a worker that joins starts all that it has, after this."""
        for callback in ("profile", "profile-cycle"):
            if callback in worker.periodic_callbacks:
                worker.periodic_callbacks.pop(callback).stop()


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
        No Dask scheduler answers at the address, the machine has no loopback, or all workers of the local cluster
        ended.
    """
    for logger in ("distributed", "distributed.client"):  # a lost scheduler is reported as one line, not a traceback
        logging.getLogger(logger).setLevel(logging.CRITICAL)
    with dask.config.set(DASK_CONFIG):
        if scheduler is None:
            _require_loopback()
            with local_cluster(workers) as cluster, Client(cluster, set_as_default=False) as client:
                yield client
        else:
            with _client_of(scheduler) as client:
                client.register_plugin(WithoutProfiler())
                yield client


def rows_of(
    client: Client, runs: Iterable[StudyRun], count: int, keep_at: str | None = None
) -> Iterator[list[RowText]]:
    """Execute runs; yield their rows in batches, as they complete.

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
    keep_at
        Folder or fsspec URL that receives the folder of every run; default: no folder is kept.

    Raises
    ------
    StudyError
        The scheduler is lost, or a worker cannot execute any run.
    OutputError
        A worker cannot store the folder of its run.
    """
    workers = max(1, sum(client.nthreads().values()))
    waiting = grouped(iter(runs), min(MOST_AT_ONCE, 1 + count // (TASKS_PER_WORKER * workers)))
    tasks: dict[str, list[StudyRun]] = {}

    def submit(batches: Iterable[list[StudyRun]]) -> list[Future[list[RowText]]]:
        futures = []
        for batch in batches:
            # The client id in the key keeps tasks of two sweeps on one scheduler apart.
            key = f"luxloop-{batch[0].key}-{len(batch)}-{client.id}"
            tasks[key] = batch
            portable = [run.portable() for run in batch]
            arguments = (portable, keep_at, installed())
            futures.append(client.submit(carry_out_as_texts, *arguments, key=key, pure=False))
        return futures

    done = as_completed(submit(islice(waiting, FIRST_PER_WORKER * workers)), loop=client.loop)
    for futures in done.batches():
        finished = {future: tasks.pop(future.key) for future in futures}
        rows, again = _results(client, finished)
        yield rows
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
    client: Client, tasks: dict[Future[list[RowText]], list[StudyRun]]
) -> tuple[list[RowText], list[StudyRun]]:
    """Return the rows of completed tasks, and runs to be executed alone; gather in one round trip."""
    try:
        found = client.gather(list(tasks))
    except Exception:  # one of them failed: fetch them one by one
        found = [_rows(client, runs, future) for future, runs in tasks.items()]
    done, again = list[RowText](), list[StudyRun]()
    for runs, of_task in zip(tasks.values(), found, strict=True):
        done += of_task
        again += [] if of_task else runs
    return done, again


def _rows(client: Client, runs: list[StudyRun], future: Future[list[RowText]]) -> list[RowText]:
    """Return the rows of a completed task, an error row for a run that killed its workers, and none for several."""
    try:
        rows: list[RowText] = future.result()
        return rows
    except InputError:
        raise
    except KilledWorker:
        if len(runs) > 1:  # one of them is to blame
            return []
        reason = "each worker that tried it died: out of memory, or killed by the run"
        return [as_text(first_columns(runs[0]) | failed(reason))]
    except (CancelledError, OSError) as error:
        raise StudyError("the connection to the Dask scheduler is lost") from error
    except Exception as error:
        if client.cluster is not None:  # a local one, with the packages of this process: a defect of luxloop
            raise
        reason = f"{type(error).__name__}: {error}"
        raise StudyError(f"a worker cannot execute runs ({reason}); install the same packages there as here") from error


def _require_loopback() -> None:
    """Check that processes of this machine reach each other; Dask would try for 30 s, and end in a traceback."""
    try:
        with socket.create_server((LOOPBACK, 0)) as server:
            socket.create_connection(server.getsockname(), timeout=TIMEOUT_S).close()
    except OSError as error:
        raise StudyError(
            f"{LOOPBACK} cannot be reached ({error.strerror}), by which the processes of a sweep exchange runs; bring "
            "the loopback interface up: ip link set lo up"
        ) from error


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
