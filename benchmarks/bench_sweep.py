"""Sweep of short runs: overhead of Dask, and speed-up by a second worker."""

import time
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
import numpy.typing as npt
from distributed import Client

from luxloop.scenarios.run import device
from luxloop.scenarios.study import dask_runs
from luxloop.scenarios.study.design import StudyRun, runs
from luxloop.scenarios.study.study_file import Study
from luxloop.scenarios.study.worker import carry_out

Floats = npt.NDArray[np.float64]

STUDY = """\
description = "Dropout behind a truck, in short runs."
scenario = "truck-shadow"
seeds = 12
fixed = { duration_s = 2.0 }
vary = [{ key = "noise.dropout.random_rate", low = 0.0, high = 0.3, steps = 4 }]
"""
WARM, ROUND = 8, 8
"""Runs before timing, in which each process imports and loads its kernels; and runs per method and round. The methods
alternate, since the computer's speed changes within minutes."""


def rows() -> dict[str, dict[str, Any]]:
    """Time runs in this process, on one worker and on two workers, alternating."""
    with TemporaryDirectory() as folder:
        path = Path(folder) / "bench.toml"
        path.write_text(STUDY, encoding="utf-8")
        pending = runs(Study.load(path), device.SHIPPED)
    with dask_runs.connect(1, None) as one, dask_runs.connect(2, None) as two:
        methods = (_bare, partial(_swept, one), partial(_swept, two))
        for method in methods:
            method(pending[:WARM])
        rounds = [pending[first : first + ROUND] for first in range(WARM, len(pending), ROUND)]
        bare_ms, one_ms, two_ms = (
            1e3 * np.array([[method(batch) for method in methods] for batch in rounds]) / ROUND
        ).T
    return {
        "sweep.run_ms": _row(one_ms, bare_ms / one_ms, "the bare loop"),
        "sweep.run_ms_two_workers": _row(two_ms, one_ms / two_ms, "one worker"),
    }


def _bare(batch: list[StudyRun]) -> float:
    """Return the time [s] of runs in this process."""
    begin = time.perf_counter()
    for run in batch:
        carry_out(run)
    return time.perf_counter() - begin


def _swept(client: Client, batch: list[StudyRun]) -> float:
    """Return the time [s] of runs on workers."""
    begin = time.perf_counter()
    for _ in dask_runs.rows_of(client, batch, len(batch)):
        pass
    return time.perf_counter() - begin


def _row(milliseconds: Floats, times_faster: Floats, peer: str) -> dict[str, Any]:
    return {
        "value": float(np.median(milliseconds)), "unit": "ms", "peer": peer, "ratio": float(np.median(times_faster)),
    }  # fmt: skip
