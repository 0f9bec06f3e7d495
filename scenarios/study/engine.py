"""Carries out the runs of a study on a Dask cluster: processes of this computer, or any scheduler."""

import logging
import signal
import time
from collections.abc import Iterator
from contextlib import contextmanager
from itertools import islice

import dask
from distributed import Client, Future, LocalCluster, WorkerPlugin, as_completed

from scenarios.errors import StudyError
from scenarios.study.design import Run
from scenarios.study.task import Row, carry_out

IN_FLIGHT = 3
"""Runs per worker that the scheduler knows of: enough that none waits, few enough that memory does not grow."""

DEATHS = 5
"""Workers that may die over one run before it is given up, and its row says so: the run itself may be what kills them."""

FLUSH_S = 1.0
"""[s] Rows are on disk no later than this after they came in."""


class LeaveInterruptsToTheClient(WorkerPlugin):  # type: ignore[misc]
    """Ctrl-C goes to all processes of a terminal; only the one that collects the rows is to heed it."""

    def setup(self, worker: object) -> None:
        """Ignore it; called by each worker when it starts, in its main thread."""
        del worker
        signal.signal(signal.SIGINT, signal.SIG_IGN)


@contextmanager
def connect(workers: int, scheduler: str | None) -> Iterator[Client]:
    """Give a client of the scheduler at that address, or of as many new processes of this computer.

    Raises
    ------
    StudyError
        Nobody answers at the address.
    """
    logging.getLogger("distributed").setLevel(
        logging.CRITICAL
    )  # a worker's death is told by the rows, not by a traceback
    with dask.config.set(
        {"distributed.scheduler.allowed-failures": DEATHS, "distributed.comm.timeouts.connect": "10s"}
    ):
        if scheduler is not None:
            try:
                client = Client(scheduler, set_as_default=False)
            except (OSError, ValueError) as error:
                raise StudyError(
                    f"--scheduler {scheduler}: no Dask scheduler answers there; give host:port of one"
                ) from error
            with client:
                yield client
            return
        with (
            LocalCluster(
                n_workers=workers,
                threads_per_worker=1,
                processes=True,
                dashboard_address=None,
                memory_limit=0,
                silence_logs=logging.CRITICAL,
            ) as cluster,
            Client(cluster, set_as_default=False) as client,
        ):
            client.register_plugin(LeaveInterruptsToTheClient())
            yield client


def rows_of(client: Client, runs: list[Run], keep_at: str | None) -> Iterator[list[Row]]:
    """Carry out runs; yield their rows as they come, some at a time."""
    waiting = iter(runs)
    slots = IN_FLIGHT * max(1, len(client.scheduler_info(n_workers=-1)["workers"]))
    run_of: dict[str, Run] = {}

    def submit(count: int) -> list[Future]:
        futures = []
        for run in islice(waiting, count):
            future = client.submit(carry_out, run, keep_at, key=f"luxloop-{run.key}", pure=False)
            run_of[future.key] = run
            futures.append(future)
        return futures

    done = as_completed(submit(slots), loop=client.loop)
    rows: list[Row] = []
    flushed = time.monotonic()
    for future in done:
        run = run_of.pop(future.key)
        rows.append(_row(run, future))
        for more in submit(1):
            done.add(more)
        if time.monotonic() - flushed > FLUSH_S:
            yield rows
            rows, flushed = [], time.monotonic()
    yield rows


def _row(run: Run, future: Future) -> Row:
    """Return the row of a finished run; of one that killed its workers, that it did."""
    if future.status == "finished":
        row: Row = future.result()
        return row
    told = " ".join(str(future.exception()).split())
    base = {"index": run.index, "key": run.key, "seed": run.seed, **run.parameters}
    return {
        **base,
        "status": "error",
        "error": f"its workers died: {told}",
        "trace_hash": "",
        "frames": 0,
        "wall_s": 0.0,
    }
