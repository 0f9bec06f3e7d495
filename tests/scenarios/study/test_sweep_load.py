"""Thousands of runs: what a sweep takes of the computer does not grow with them."""

import os
from pathlib import Path

import pandas as pd
import pytest
from support.processes import children_of
from support.sweeps import PATIENCE_S, end, rows, rows_so_far, small_study, start, wait_for_rows

RUNS = 2000
SETTLED = 100
"""Runs after which all is loaded and compiled."""
EVERY = 100
PAGE_MB = os.sysconf("SC_PAGE_SIZE") / 1e6
FEW_MB = 10.0
"""Memory that comes and goes with a run; a row, a scan or a trace kept of each run would be more than this in all."""


@pytest.mark.slow
def test_memory_and_open_files_are_flat_through_two_thousand_runs(tmp_path: Path):
    study = small_study(tmp_path, seeds=RUNS // 4)
    process = start(study, "--workers", "2")
    samples = []
    for count in range(SETTLED, RUNS - EVERY, EVERY):
        wait_for_rows(study, count, process)
        samples += [taken(pid, rows_so_far(study)) for pid in (process.pid, *children_of(process.pid))]
    output, error = process.communicate(timeout=PATIENCE_S)
    end(process)
    assert (process.returncode, error) == (0, "")
    assert len(rows(study)) == RUNS
    print(output)

    of_process = pd.DataFrame(samples).groupby("pid")
    assert len(of_process) >= 3, "the command and two workers"
    for _, taken_by in of_process:
        print(taken_by.to_string())
        half = len(taken_by) // 2
        assert len(taken_by) > 15
        early, late = taken_by.iloc[:half], taken_by.iloc[half:]
        assert late["memory_mb"].max() <= early["memory_mb"].max() + FEW_MB
        assert late["files"].max() <= early["files"].max()


def taken(pid: int, count: int) -> dict[str, float]:
    """Resident memory and open files of a process, after so many runs."""
    resident_pages = int(Path(f"/proc/{pid}/statm").read_text().split()[1])
    files = len(list(Path(f"/proc/{pid}/fd").iterdir()))
    return {"pid": pid, "runs": count, "memory_mb": resident_pages * PAGE_MB, "files": files}
