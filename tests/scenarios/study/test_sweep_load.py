"""Resource use of a sweep does not grow with the number of runs."""

import os
from pathlib import Path

import pandas as pd
import pytest
from support.processes import children_of
from support.sweeps import PATIENCE_S, end, rows, rows_so_far, small_study, start, wait_for_rows

SETTLED = 100
"""Runs after which all modules are loaded and all kernels compiled."""
SAMPLES = 18
"""Samples of memory and open files, evenly over the runs after those."""
PAGE_MB = os.sysconf("SC_PAGE_SIZE") / 1e6
FEW_MB = 10.0
"""Variation of memory between runs; a leak of one row, scan or trace per run would exceed this in total."""


@pytest.mark.parametrize(
    "runs", [pytest.param(480, marks=pytest.mark.slow), pytest.param(2000, marks=pytest.mark.soak)]
)
def test_memory_and_open_files_do_not_grow_with_the_runs(runs: int, tmp_path: Path):
    study = small_study(tmp_path, seeds=runs // 4)
    process = start(study, "--workers", "2")
    samples = []
    for count in range(SETTLED, runs, (runs - SETTLED) // SAMPLES)[:SAMPLES]:
        wait_for_rows(study, count, process)
        samples += [usage(pid, rows_so_far(study)) for pid in (process.pid, *children_of(process.pid))]
    output, error = process.communicate(timeout=PATIENCE_S)
    end(process)
    assert (process.returncode, error) == (0, "")
    assert len(rows(study)) == runs
    print(output)

    of_process = pd.DataFrame(samples).groupby("pid")
    assert len(of_process) >= 3, "the command and two workers"
    for _, used in of_process:
        print(used.to_string())
        half = len(used) // 2
        assert len(used) > 15
        early, late = used.iloc[:half], used.iloc[half:]
        assert late["memory_mb"].max() <= early["memory_mb"].max() + FEW_MB
        assert late["files"].max() <= early["files"].max()


def usage(pid: int, count: int) -> dict[str, float]:
    """Return resident memory and number of open files of a process, after `count` runs."""
    resident_pages = int(Path(f"/proc/{pid}/statm").read_text().split()[1])
    # The least of several counts leaves out files that are open for a moment only; a leaked file is in all of them.
    files = min(len(list(Path(f"/proc/{pid}/fd").iterdir())) for _ in range(20))
    return {"pid": pid, "runs": count, "memory_mb": resident_pages * PAGE_MB, "files": files}
