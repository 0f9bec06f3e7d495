"""A sweep on somebody's Dask scheduler, and what becomes of it if there is none, or no longer."""

import json
import os
import signal
import socket
import subprocess
import sys
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path

import pytest
from support.processes import until
from support.sweeps import end, rows, small_study, start, sweep, undisturbed, wait_for_rows

from scenarios.cli import main
from scenarios.study import dask_runs


@contextmanager
def dask(*arguments: str) -> Iterator[subprocess.Popen[str]]:
    """A `dask` command, as an administrator starts it."""
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
    """A scheduler and workers on loopback: its address, and its process."""
    told = folder / "scheduler.json"
    with ExitStack() as stack:
        scheduler = stack.enter_context(
            dask("scheduler", "--host", "127.0.0.1", "--port", "0", "--no-dashboard", "--scheduler-file", str(told))
        )
        until(lambda: told.is_file() and told.read_text().rstrip().endswith("}"))
        for _ in range(workers):
            stack.enter_context(
                dask("worker", "--scheduler-file", str(told), "--nthreads", "1", "--no-dashboard",
                     "--local-directory", str(folder))
            )  # fmt: skip
        yield json.loads(told.read_text())["address"], scheduler


@pytest.mark.slow
def test_two_workers_of_another_cluster_make_the_same_rows_until_its_scheduler_dies(tmp_path: Path):
    study = small_study(tmp_path / "study", seeds=5)
    with cluster(tmp_path, workers=2) as (address, scheduler):
        code, output, error = sweep(study, "--scheduler", address)
        assert (code, error) == (0, "")
        assert output.startswith("20 runs: 20 passed.\n")
        assert list(rows(study)["trace_hash"]) == undisturbed(study)

        small_study(tmp_path / "study", seeds=40)
        more = start(study, "--scheduler", address)
        wait_for_rows(study, 3, more)
        os.killpg(scheduler.pid, signal.SIGKILL)
        output, error = more.communicate(timeout=60)
        end(more)
        assert (more.returncode, output) == (2, "")
        assert error == (
            f"luxloop: error: the Dask scheduler is gone; {len(rows(study))} of 160 rows are in out, "
            "the same command goes on from there\n"
        )
        assert 23 <= len(rows(study)) < 160


@pytest.mark.parametrize("listens", [False, True])
def test_no_scheduler_answers(tmp_path: Path, monkeypatch, capfd, listens: bool):
    monkeypatch.chdir(small_study(tmp_path).parent)
    monkeypatch.setattr(dask_runs, "ANSWER_S", 0.5)
    with socket.create_server(("127.0.0.1", 0)) as server:
        address = f"127.0.0.1:{server.getsockname()[1]}"
        if not listens:
            server.close()
        assert main(["sweep", "small.toml", "--scheduler", address]) == 2
    error = capfd.readouterr().err
    told = f"luxloop: error: --scheduler {address}: no Dask scheduler answers there; give host:port of one"
    assert error.startswith(told)
    assert error.count("\n") == 1


def test_an_address_that_is_none(tmp_path: Path, monkeypatch, capfd):
    monkeypatch.chdir(small_study(tmp_path).parent)
    assert main(["sweep", "small.toml", "--scheduler", "the cluster"]) == 2
    error = capfd.readouterr().err
    assert error.startswith("luxloop: error: --scheduler the cluster: no Dask scheduler answers there")
    assert error.count("\n") == 1
