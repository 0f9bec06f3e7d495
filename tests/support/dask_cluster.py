"""A Dask scheduler and its workers as subprocesses on this computer."""

import json
import os
import subprocess
import sys
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path

from support.processes import until
from support.sweeps import end


@contextmanager
def dask(*arguments: str) -> Iterator[subprocess.Popen[str]]:
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
    file = folder / "scheduler.json"
    with ExitStack() as stack:
        scheduler = stack.enter_context(
            dask("scheduler", "--host", "127.0.0.1", "--port", "0", "--no-dashboard", "--scheduler-file", str(file))
        )
        until(lambda: file.is_file() and file.read_text().rstrip().endswith("}"))
        for _ in range(workers):
            stack.enter_context(
                dask("worker", "--scheduler-file", str(file), "--nthreads", "1", "--no-dashboard",
                     "--local-directory", str(folder))
            )  # fmt: skip
        yield json.loads(file.read_text())["address"], scheduler
