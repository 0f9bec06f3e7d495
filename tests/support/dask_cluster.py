"""Dask clusters on this computer: a scheduler and its workers as subprocesses, and a worker in this process."""

import json
import logging
import os
import subprocess
import sys
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path

from support.optional import need
from support.processes import until
from support.sweeps import end


@contextmanager
def dask_command(*arguments: str) -> Iterator[subprocess.Popen[str]]:
    """Run a `dask` command as a subprocess."""
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, sys.path))}
    process = subprocess.Popen(
        [sys.executable, "-m", "dask", *arguments], env=environment, start_new_session=True, text=True,
        stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
    )  # fmt: skip
    try:
        yield process
    finally:
        end(process)


@contextmanager
def cluster(folder: Path, workers: int) -> Iterator[tuple[str, subprocess.Popen[str]]]:
    """Start a scheduler and workers on loopback; yield its address and its process."""
    need("sweeps")
    file = folder / "scheduler.json"
    with ExitStack() as stack:
        scheduler = stack.enter_context(
            dask_command("scheduler", "--host", "127.0.0.1", "--port", "0", "--no-dashboard",
                         "--scheduler-file", str(file))
        )  # fmt: skip
        until(lambda: file.is_file() and file.read_text().rstrip().endswith("}"))
        for _ in range(workers):
            stack.enter_context(
                dask_command("worker", "--scheduler-file", str(file), "--nthreads", "1", "--no-dashboard",
                             "--local-directory", str(folder))
            )  # fmt: skip
        yield json.loads(file.read_text())["address"], scheduler


@contextmanager
def worker_thread() -> Iterator[str]:
    """Start a worker as a thread of this process, which has loaded luxloop; yield the address of its scheduler.

    For sweeps by `scenarios.cli.main` whose tests are not about processes: a worker process takes five seconds to load.
    """
    need("sweeps")
    import dask.config
    from distributed import LocalCluster

    from luxloop.scenarios.study.dask_runs import DASK_CONFIG

    with (
        dask.config.set(DASK_CONFIG),
        LocalCluster(
            n_workers=1, threads_per_worker=1, processes=False, dashboard_address="127.0.0.1:0", memory_limit=0,
            silence_logs=logging.CRITICAL,
        ) as cluster,
    ):  # fmt: skip
        yield cluster.scheduler_address
