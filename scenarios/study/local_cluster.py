"""Dask cluster of worker processes on this computer."""

import logging
import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from multiprocessing import resource_tracker

from distributed import LocalCluster, Status
from tornado.ioloop import PeriodicCallback

from luxloop.scenarios.errors import StudyError

OF_TERMINALS = {signal.SIGINT, signal.SIGHUP}
"""Signals of Ctrl-C and of a terminal that closes."""
ENDED = {Status.failed, Status.closing, Status.closed}
"""Status of a supervisor of a worker process that has given up; it restarts killed processes until then."""
WATCH_S = 5.0
"""Interval [s] between checks for workers."""


@contextmanager
def local_cluster(workers: int) -> Iterator[LocalCluster]:
    """Yield a cluster whose workers ignore the signals of a terminal, which it sends to all its processes.

    Only this process reacts to them. Workers, including restarted ones, and the resource tracker inherit the signal
    mask of the threads that start here.

    Raises
    ------
    StudyError
        All workers ended, and cannot be started again.
    """
    try:
        signal.pthread_sigmask(signal.SIG_BLOCK, OF_TERMINALS)
        resource_tracker.ensure_running()  # CPython unblocks SIGINT in the thread that starts the tracker
        signal.pthread_sigmask(signal.SIG_BLOCK, OF_TERMINALS)
        with LocalCluster(
            n_workers=workers,
            threads_per_worker=1,
            processes=True,
            dashboard_address="127.0.0.1:0",
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
