"""Processes of a local cluster and the signals of a terminal, which it sends to all of them."""

import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest
from support.optional import need

CLUSTER = """
from multiprocessing import resource_tracker
from pathlib import Path
from luxloop.scenarios.study import dask_runs

if __name__ == "__main__":
    with dask_runs.connect(1, None) as client:
        pids = [resource_tracker._resource_tracker._pid, *client.run(__import__("os").getpid).values()]
        for pid in pids:
            print(Path(f"/proc/{pid}/status").read_text())
"""


@pytest.mark.slow
def test_workers_and_resource_tracker_outlive_the_signals_of_a_terminal(tmp_path: Path):
    """A tracker that dies of SIGHUP is started again, and prints a traceback for each lock that it does not know."""
    need("sweeps")
    (tmp_path / "starts.py").write_text(CLUSTER)
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, sys.path))}
    done = subprocess.run(
        [sys.executable, "starts.py"], cwd=tmp_path, env=environment, capture_output=True, text=True, check=True
    )
    kept = [int(line.split()[1], 16) for line in done.stdout.splitlines() if line.startswith(("SigBlk", "SigIgn"))]
    assert len(kept) == 4
    for blocked, ignored in (kept[:2], kept[2:]):
        for number in (signal.SIGINT, signal.SIGHUP):
            assert (blocked | ignored) >> (number - 1) & 1, number
