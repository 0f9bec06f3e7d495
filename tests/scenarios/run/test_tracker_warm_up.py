"""Compilation of the tracker in a process beside that of traffic and sensor."""

import subprocess
import sys

import pytest

LUXLOOP = (sys.executable, "-m", "luxloop")


@pytest.mark.slow
def test_no_kernel_is_left_to_a_run_after_the_warm_up(tmp_path, monkeypatch):
    """Kernels that both processes compiled for different types would be compiled again by the run."""
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "cache"))
    subprocess.run([*LUXLOOP, "warm-up", "--quiet"], check=True)
    compiled = {path: path.stat().st_mtime_ns for path in (tmp_path / "cache").rglob("*.nbc")}
    assert len(compiled) > 100
    run = [*LUXLOOP, "run", "sumo-crossing", "--duration", "0.8", "--no-recording", "--out", str(tmp_path / "out")]
    subprocess.run(run, check=False)
    assert {path: path.stat().st_mtime_ns for path in (tmp_path / "cache").rglob("*.nbc")} == compiled
