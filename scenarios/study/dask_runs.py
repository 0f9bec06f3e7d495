"""Carries out the runs of a study on a Dask cluster: processes of this computer, or any scheduler."""

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
from scenarios.study.worker import Row, carry_out_as_text, failed, first_columns

AT_ONCE = 4000
"""Runs that the scheduler knows of: some for each of a thousand workers, and few enough that memory does not grow."""

ANSWER_S = 5
"""[s] A scheduler that has not answered by then is none."""

SETTINGS = {
    # Nobody looks at these, and on few cores they take time from the runs.
    "distributed.worker.profile.enabled": False,
    "distributed.admin.tick.interval": "1s",
    "distributed.admin.system-monitor.interval": "10s",
    # Without Dask's MALLOC_TRIM_THRESHOLD_, which makes workers ask for the same memory anew, scan after scan.
    "distributed.nanny.pre-spawn-environ": {"OMP_NUM_THREADS": 1, "MKL_NUM_THREADS": 1, "OPENBLAS_NUM_THREADS": 1},
}


@contextmanager
def connect(workers: int, scheduler: str | None) -> Iterator[Client]:
    """Give a client of the scheduler at that address, or of as many new processes of this computer.

    Raises
    ------
    StudyError
        Nobody answers at the address.
    """
    for logger in ("distributed", "distributed.client"):  # a death is told in one line, not by a traceback
        logging.getLogger(logger).setLevel(logging.CRITICAL)
    with dask.config.set(SETTINGS):
        if scheduler is None:
            with _local(workers) as cluster, Client(cluster, set_as_default=False) as client:
                yield client
        else:
            with _client_of(scheduler) as client:
                yield client


def rows_of(client: Client, runs: list[StudyRun], keep_at: str | None = None) -> Iterator[list[Row]]:
    """Carry out runs; yield their rows as they come, as many as have come.

    Raises
    ------
    StudyError
        The scheduler is gone, or a worker cannot carry out any run.
    OutputError
        A worker cannot keep the folder of its run.
    """
    waiting = iter(runs)
    run_of: dict[str, StudyRun] = {}

    def submit(count: int) -> list[Future[str]]:
        # with the client's id in its name, two sweeps on one scheduler share no task
        some = {f"luxloop-{run.key}-{client.id}": run for run in islice(waiting, count)}
        run_of.update(some)
        return [
            client.submit(carry_out_as_text, run.portable(), keep_at, installed(), key=key, pure=False)
            for key, run in some.items()
        ]

    done = as_completed(submit(AT_ONCE), loop=client.loop)
    for futures in done.batches():
        yield _rows(client, {future: run_of.pop(future.key) for future in futures})
        done.update(submit(len(futures)))


def _rows(client: Client, run_of: dict[Future[str], StudyRun]) -> list[Row]:
    """Return the rows of ended runs, fetched in one go: one by one it is a round trip each."""
    try:
        return [json.loads(text) for text in client.gather(list(run_of))]
    except Exception:  # of one among them: ask each
        return [_row(run, future) for future, run in run_of.items()]


def _row(run: StudyRun, future: Future[str]) -> Row:
    """Return the row of a finished run; of one that killed its workers, that it did."""
    try:
        row: Row = json.loads(future.result())
        return row
    except InputError:
        raise
    except KilledWorker:
        return first_columns(run) | failed("each worker that tried it died: out of memory, or taken down by the run")
    except (CancelledError, OSError) as error:
        raise StudyError("the Dask scheduler is gone") from error
    except Exception as error:
        told = f"{type(error).__name__}: {error}"
        raise StudyError(f"a worker cannot carry out runs ({told}); install there what is installed here") from error


@contextmanager
def _local(workers: int) -> Iterator[LocalCluster]:
    """Start workers that hear nothing of Ctrl-C, which goes to all processes of a terminal: it is for this one alone.

    They, and those that replace the dead among them, inherit a signal mask from the threads that start here.
    """
    resource_tracker.ensure_running()  # whichever thread starts it has its mask lifted, see CPython's resource_tracker
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
        asyncio.run(asyncio.wait_for(_ask_who_it_is(scheduler), ANSWER_S))  # Client itself waits for the mute for ever
        return Client(scheduler, timeout=ANSWER_S, set_as_default=False)
    except (OSError, ValueError) as error:
        raise StudyError(f"--scheduler {scheduler}: no Dask scheduler answers there; give host:port of one") from error


async def _ask_who_it_is(scheduler: str) -> None:
    async with rpc(scheduler, connection_args=Security().get_connection_args("client")) as there:
        if (await there.identity())["type"] != "Scheduler":
            raise ValueError("it is something else of Dask's")
