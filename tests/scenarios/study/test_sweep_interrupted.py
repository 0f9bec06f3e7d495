"""A sweep that is interrupted, by whatever, and started again, has the rows of one that was not."""

import os
import signal
from pathlib import Path

import pytest
from support.processes import children_of
from support.sweeps import PATIENCE_S, end, rows, rows_so_far, small_study, start, sweep, undisturbed, wait_for_rows


@pytest.mark.slow
def test_three_interruptions_cost_nothing(tmp_path: Path):
    study = small_study(tmp_path, seeds=10)

    first = start(study, "--workers", "2")
    wait_for_rows(study, 3, first)
    os.killpg(first.pid, signal.SIGINT)  # as Ctrl-C does: to every process of the terminal
    output, error = first.communicate(timeout=60)
    end(first)
    there = len(rows(study))
    assert (first.returncode, output) == (130, "")
    assert error == (
        f"luxloop: error: interrupted; {there} of 40 rows are in out, the same command goes on from there\n"
    )
    assert 3 <= there < 40

    second = start(study, "--workers", "2")
    wait_for_rows(study, 2, second)
    before = rows_so_far(study)
    os.kill(a_worker_of(second.pid), signal.SIGKILL)
    wait_for_rows(study, before + 5, second)  # more than the other worker alone had in hand
    os.killpg(second.pid, signal.SIGKILL)
    end(second)
    kept = there + rows_so_far(study)

    third = start(study, "--workers", "2")
    wait_for_rows(study, rows_so_far(study) + 1, third)
    os.kill(third.pid, signal.SIGSTOP)  # lest it be done before the next one looks
    code, _, error = sweep(study)
    os.kill(third.pid, signal.SIGCONT)
    assert code == 2
    assert error == "luxloop: error: out: another sweep writes there now; wait for it, or choose another --out\n"
    output, error = third.communicate(timeout=PATIENCE_S)
    assert (third.returncode, error) == (0, "")
    assert output.startswith(f"40 runs: 40 passed. {kept} of them were there from an earlier start.\n")
    assert list(rows(study)["trace_hash"]) == undisturbed(study)
    assert list(rows(study)["index"]) == list(range(40))
    assert kept < 40
    assert not (tmp_path / "out" / "runs.jsonl").exists()


def a_worker_of(pid: int) -> int:
    """A process of Dask's that runs simulations: a child that has loaded more than the resource tracker does."""
    return max(children_of(pid), key=lambda child: int(Path(f"/proc/{child}/statm").read_text().split()[1]))
