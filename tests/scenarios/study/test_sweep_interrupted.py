"""An interrupted and resumed sweep has the same rows as an uninterrupted one."""

import os
import signal
from pathlib import Path

import pytest
from support.processes import children_of
from support.sweeps import (
    PATIENCE_S,
    end,
    rows,
    rows_so_far,
    sequential_hashes,
    small_study,
    start,
    sweep,
    wait_for_rows,
)

FIRST_LINE = "40 runs in small (combinations: 4, seeds: 10)\n"


@pytest.mark.slow
def test_a_sweep_resumes_after_three_interruptions(tmp_path: Path):
    study = small_study(tmp_path, seeds=10)

    first = start(study, "--workers", "2")
    wait_for_rows(study, 3, first)
    os.killpg(first.pid, signal.SIGINT)  # like Ctrl-C, which a terminal sends to all its processes
    output, error = first.communicate(timeout=60)
    end(first)
    completed = len(rows(study))
    assert (first.returncode, output) == (130, FIRST_LINE)
    assert error == (
        f"luxloop: error: interrupted; {completed} of 40 rows are in out; run the same command to resume\n"
    )
    assert 3 <= completed < 40

    second = start(study, "--workers", "2")
    wait_for_rows(study, completed + 2, second)
    before = rows_so_far(study)
    os.kill(worker_of(second.pid), signal.SIGKILL)
    wait_for_rows(study, before + 5, second)  # more than the remaining worker had already started
    os.killpg(second.pid, signal.SIGKILL)
    end(second)
    kept = rows_so_far(study)

    third = start(study, "--workers", "2")
    wait_for_rows(study, rows_so_far(study) + 1, third)
    os.kill(third.pid, signal.SIGSTOP)  # so that it does not finish before the next sweep starts
    code, _, error = sweep(study)
    os.kill(third.pid, signal.SIGCONT)
    assert code == 2
    refused = "out: another command is writing to it; wait until it ends, or choose another --out"
    assert error == f"luxloop: error: {refused}\n"
    output, error = third.communicate(timeout=PATIENCE_S)
    assert (third.returncode, error) == (0, "")
    answer = f"40 of 40 runs have a result\n40 runs: 40 passed. {kept} of them were there from an earlier start.\n"
    assert output.startswith(FIRST_LINE + answer)
    assert list(rows(study)["trace_hash"]) == sequential_hashes(study)
    assert list(rows(study)["index"]) == list(range(40))
    assert kept < 40
    assert sorted(path.name for path in (tmp_path / "out").glob("runs.*")) == ["runs.parquet", "runs.sqlite"]


def worker_of(pid: int) -> int:
    """Return the process id of a Dask worker: the child with the most memory (the resource tracker has less)."""
    return max(children_of(pid), key=lambda child: int(Path(f"/proc/{child}/statm").read_text().split()[1]))
