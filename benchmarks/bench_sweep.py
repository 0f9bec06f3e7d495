"""A sweep of short runs: what Dask adds to a run, and what a second worker gains."""

import time
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from scenarios import device
from scenarios.study import engine
from scenarios.study.design import Run, runs
from scenarios.study.study import Study
from scenarios.study.task import carry_out

STUDY = """\
description = "Dropout behind a truck, in short runs."
scenario = "truck-shadow"
seeds = 10
fixed = { duration_s = 2.0 }
vary = [{ key = "noise.dropout.random_rate", low = 0.0, high = 0.3, steps = 4 }]
"""
WARM = 8
"""Runs before the clock starts: each process imports, and loads its kernels."""


def rows() -> dict[str, dict[str, Any]]:
    """Time the same runs one after the other in this process, on one worker and on two."""
    with TemporaryDirectory() as folder:
        path = Path(folder) / "bench.toml"
        path.write_text(STUDY, encoding="utf-8")
        todo = runs(Study.load(path), device.SHIPPED)
    bare_ms = _bare_ms(todo)
    one_ms, two_ms = (_swept_ms(todo, workers) for workers in (1, 2))
    return {
        "sweep.run_ms": {"value": one_ms, "unit": "ms", "peer": "the bare loop", "ratio": one_ms / bare_ms},
        "sweep.run_ms_two_workers": {"value": two_ms, "unit": "ms", "peer": "one worker", "ratio": one_ms / two_ms},
    }


def _bare_ms(todo: list[Run]) -> float:
    """Wall time per run."""
    for run in todo[:WARM]:
        carry_out(run)
    begin = time.perf_counter()
    for run in todo[WARM:]:
        carry_out(run)
    return 1e3 * (time.perf_counter() - begin) / len(todo[WARM:])


def _swept_ms(todo: list[Run], workers: int) -> float:
    """Wall time per run."""
    with engine.connect(workers, None) as client:
        for _ in engine.rows_of(client, todo[:WARM]):
            pass
        begin = time.perf_counter()
        for _ in engine.rows_of(client, todo[WARM:]):
            pass
        return 1e3 * (time.perf_counter() - begin) / len(todo[WARM:])
