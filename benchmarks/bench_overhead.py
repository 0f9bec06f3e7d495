"""Processor time of the client of a sweep per run: planning, submission, gathering and storing of rows.

The workers' runs are replaced by rows of a typical size, so that thousands of runs take seconds; everything else is
real: Dask's scheduler in a process of its own, its workers, and the files. Fixed costs cancel in the difference of two
numbers of runs.
"""

import json
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from luxloop.scenarios.metrics.definitions import standard_names
from luxloop.scenarios.run import device
from luxloop.scenarios.study import dask_runs, worker
from luxloop.scenarios.study.design import StudyRun
from luxloop.scenarios.study.row_store import RunRow
from luxloop.scenarios.study.study_file import Study
from luxloop.scenarios.study.sweep_runs import sweep

STUDY = """\
description = "Dropout behind a truck, in runs of one second."
scenario = "truck-shadow"
seeds = {seeds}
fixed = {{ duration_s = 1.0 }}
vary = [{{ key = "noise.dropout.random_rate", low = 0.0, high = 0.3, steps = 4 }}]
"""
FEW, MANY = 50, 550
"""Seeds of the two sweeps of 200 and 2200 runs."""
VALUES = dict.fromkeys(standard_names(), 0.123456789)
"""A row has a value of every metric: 13 kB, more than that of a typical scenario."""


def rows() -> dict[str, dict[str, Any]]:
    """Measure the client with a scheduler in another process."""
    with TemporaryDirectory() as folder, _cluster(Path(folder)) as address:
        _sweep_ms(Path(folder), address, FEW)  # loads modules
        few_ms = _sweep_ms(Path(folder), address, FEW)
        per_run_ms = (_sweep_ms(Path(folder), address, MANY) - few_ms) / (4 * (MANY - FEW))
    return {"sweep.client_cpu_ms": {"value": per_run_ms, "unit": "ms", "peer": None, "ratio": None}}


def _sweep_ms(folder: Path, address: str, seeds: int) -> float:
    """Return the processor time [ms] of this process, including all its threads, during a sweep and its table."""
    with TemporaryDirectory(dir=folder) as out:
        path = Path(out) / "bench.toml"
        path.write_text(STUDY.format(seeds=seeds), encoding="utf-8")
        study = Study.load(path)
        begin = time.process_time()
        done = sweep(study, device.SHIPPED, Path(out) / "out", 2, address)
        used_ms = 1e3 * (time.process_time() - begin)
    assert len(done.rows) == done.count == 4 * seeds
    assert set(done.rows["status"]) == {"passed"}
    return used_ms


def _without_simulation() -> None:
    """Replace the runs of a worker; executed in its process."""
    worker.carry_out = _typical_row


def _typical_row(run: StudyRun, *_: object) -> RunRow:
    measured = {"status": "passed", "error": "", "trace_hash": "0" * 32, "frames": 25, "wall_s": 0.2}
    return {**worker.first_columns(run), **measured, **VALUES}


@contextmanager
def _cluster(folder: Path) -> Iterator[str]:
    """Start a scheduler and two workers as processes; yield the scheduler's address."""
    file = folder / "scheduler.json"
    scheduler = ["scheduler", "--host", "127.0.0.1", "--port", "0", "--no-dashboard", "--scheduler-file", str(file)]
    workers = ["worker", "--scheduler-file", str(file), "--nthreads", "1", "--nworkers", "2", "--no-dashboard",
               "--local-directory", str(folder)]  # fmt: skip
    processes = [
        subprocess.Popen([sys.executable, "-m", "dask", *command], stderr=subprocess.DEVNULL)
        for command in (scheduler, workers)
    ]
    try:
        address = _address(file)
        with dask_runs.connect(1, address) as client:
            client.wait_for_workers(2)
            client.run(_without_simulation)
        yield address
    finally:
        for process in processes:
            process.terminate()
            process.wait()


def _address(file: Path) -> str:
    """Return the address of the scheduler, once its file is complete."""
    while True:
        with suppress(FileNotFoundError, json.JSONDecodeError):
            return str(json.loads(file.read_text(encoding="utf-8"))["address"])
        time.sleep(0.05)
