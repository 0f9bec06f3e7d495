"""Sweep on an external Dask scheduler, including missing and lost schedulers."""

import os
import signal
import socket
from pathlib import Path

import pytest
from support.optional import need

need("sweeps")

from distributed import LocalCluster
from support.dask_cluster import cluster
from support.sweeps import end, rows, sequential_hashes, small_study, start, sweep, wait_for_rows

from luxloop.scenarios.cli import main
from luxloop.scenarios.study import dask_runs


@pytest.mark.slow
def test_an_external_cluster_gives_the_same_rows_until_its_scheduler_dies(tmp_path: Path):
    study = small_study(tmp_path / "study", seeds=5)
    with cluster(tmp_path, workers=2) as (address, scheduler):
        code, output, error = sweep(study, "--scheduler", address)
        assert (code, error) == (0, "")
        assert "\n20 of 20 runs have a result\n20 runs: 20 passed.\n" in output
        assert list(rows(study)["trace_hash"]) == sequential_hashes(study)

        small_study(tmp_path / "study", seeds=40)
        more = start(study, "--scheduler", address)
        wait_for_rows(study, 23, more)  # 20 are of the first sweep
        os.killpg(scheduler.pid, signal.SIGKILL)
        output, error = more.communicate(timeout=60)
        end(more)
        assert (more.returncode, output) == (2, "160 runs in small (combinations: 4, seeds: 40)\n")
        assert error == (
            f"luxloop: error: the connection to the Dask scheduler is lost; {len(rows(study))} of 160 rows are in out; "
            "run the same command to resume\n"
        )
        assert 23 <= len(rows(study)) < 160


def test_workers_of_an_external_cluster_have_no_profiler_during_a_sweep():
    """The profiler of Dask deadlocked a run in CPython 3.11; a worker that joins later has none either."""
    local = {"processes": False, "threads_per_worker": 1, "dashboard_address": "127.0.0.1:0", "memory_limit": 0}
    with LocalCluster(n_workers=1, **local) as cluster:
        assert "profile" in cluster.workers[0].periodic_callbacks
        with dask_runs.connect(1, cluster.scheduler_address) as client:
            cluster.scale(2)
            client.wait_for_workers(2, timeout=60)
            of_workers = client.run(lambda dask_worker: sorted(dask_worker.periodic_callbacks))
    assert len(of_workers) == 2
    assert all("heartbeat" in names and not {"profile", "profile-cycle"} & {*names} for names in of_workers.values())


@pytest.mark.parametrize("accepts", [False, True])
def test_an_unresponsive_scheduler_is_an_error(tmp_path: Path, monkeypatch, capfd, accepts: bool):
    monkeypatch.chdir(small_study(tmp_path).parent)
    monkeypatch.setattr("luxloop.scenarios.study.dask_runs.TIMEOUT_S", 0.5)
    with socket.create_server(("127.0.0.1", 0)) as server:
        address = f"127.0.0.1:{server.getsockname()[1]}"
        if not accepts:
            server.close()
        assert main(["sweep", "small.toml", "--scheduler", address]) == 2
    error = capfd.readouterr().err
    message = f"luxloop: error: --scheduler {address}: no Dask scheduler answers there; give its host:port"
    assert error.startswith(message)
    assert error.count("\n") == 1


def test_an_invalid_scheduler_address_is_an_error(tmp_path: Path, monkeypatch, capfd):
    monkeypatch.chdir(small_study(tmp_path).parent)
    assert main(["sweep", "small.toml", "--scheduler", "the cluster"]) == 2
    error = capfd.readouterr().err
    assert error.startswith("luxloop: error: --scheduler the cluster: no Dask scheduler answers there")
    assert error.count("\n") == 1


@pytest.mark.parametrize(("option", "lines"), [([], 1), (["--quiet"], 0), (["--json"], 0)])
def test_the_number_of_runs_is_printed_before_the_first_begins(tmp_path: Path, monkeypatch, capfd, option, lines):
    """Steps with a zero too many make a study of hours, which a log without a progress bar would not show."""
    study = small_study(tmp_path, seeds=3)
    monkeypatch.chdir(tmp_path)
    assert main(["sweep", study.name, "--scheduler", "the cluster", *option]) == 2
    assert capfd.readouterr().out == lines * "12 runs in small (combinations: 4, seeds: 3)\n"
