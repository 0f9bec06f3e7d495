"""Workers that are killed, slow to restart, or cannot be started again."""

import errno
import os
import signal
import time
from pathlib import Path

import pytest
from support.optional import need

need("sweeps")

from support.processes import children_of, until
from support.sweeps import small_study

from luxloop.scenarios.errors import StudyError
from luxloop.scenarios.run import device
from luxloop.scenarios.study import dask_runs
from luxloop.scenarios.study.design import StudyRun, runs
from luxloop.scenarios.study.study_file import Study

LONGER_THAN_DASK_WAITS_S = 20.0


def short_runs(folder: Path) -> list[StudyRun]:
    return runs(Study.load(small_study(folder)), device.SHIPPED)


def worker_process(other_than: int | None = None) -> int:
    """Return the id of the worker process."""
    found: list[int] = []

    def there() -> bool:
        children = {pid: Path(f"/proc/{pid}/cmdline").read_bytes() for pid in children_of(os.getpid())}
        found[:] = [pid for pid, command in children.items() if b"spawn_main" in command and pid != other_than]
        return len(found) == 1

    until(there, pause_s=0.005)
    return found[0]


def test_a_machine_without_loopback_is_named_at_once(monkeypatch):
    """As in a network namespace whose loopback is down: an address can be bound, but not reached."""

    def unreachable(*_, **__):
        raise OSError(errno.ENETUNREACH, "Network is unreachable")

    monkeypatch.setattr(dask_runs.socket, "create_connection", unreachable)
    said = r"^127\.0\.0\.1 cannot be reached \(Network is unreachable\).*ip link set lo up$"
    with pytest.raises(StudyError, match=said):
        dask_runs.connect(1, None).__enter__()


@pytest.mark.slow
def test_a_worker_that_restarts_slowly_executes_the_runs(tmp_path: Path):
    """Dask removes a worker that has not restarted after 15 s for good, unless configured otherwise."""
    with dask_runs.connect(1, None) as client:
        killed = worker_process()
        os.kill(killed, signal.SIGKILL)
        restarted = worker_process(other_than=killed)
        os.kill(restarted, signal.SIGSTOP)
        time.sleep(LONGER_THAN_DASK_WAITS_S)
        os.kill(restarted, signal.SIGCONT)
        assert sum(len(batch) for batch in dask_runs.rows_of(client, short_runs(tmp_path), 8)) == 8


@pytest.mark.slow
def test_workers_that_cannot_be_started_again_end_the_sweep(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(dask_runs, "WATCH_S", 0.1)
    with pytest.raises(StudyError, match="all worker processes ended and could not be started again"):
        sweep_without_workers(short_runs(tmp_path))


def sweep_without_workers(pending: list[StudyRun]) -> None:
    """Execute runs on a worker that is killed, and whose start fails from then on."""
    with dask_runs.connect(1, None) as client:
        (nanny,) = client.cluster.workers.values()
        nanny.process.worker_kwargs["nthreads"] = "none"
        os.kill(worker_process(), signal.SIGKILL)
        list(dask_runs.rows_of(client, pending, len(pending)))
