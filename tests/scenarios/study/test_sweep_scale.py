"""Large sweeps: bounded memory, lazy planning, and several seeds per task."""

import json
import os
import resource
import signal
import subprocess
import sys
import time
from itertools import islice
from pathlib import Path

import numpy as np
import pytest
from support.optional import need

need("sweeps")

from support.dask_cluster import cluster, worker_thread
from support.processes import children_of
from support.sweeps import (
    PATIENCE_S,
    end,
    rows,
    rows_so_far,
    sequential_hashes,
    small_study,
    start,
    wait_for_rows,
)

from luxloop.scenarios.cli import main
from luxloop.scenarios.metrics.definitions import standard_names
from luxloop.scenarios.run import device
from luxloop.scenarios.study import dask_runs, design, sweep_runs
from luxloop.scenarios.study.design import runs
from luxloop.scenarios.study.row_store import RowStore, as_text
from luxloop.scenarios.study.study_file import Study
from luxloop.scenarios.study.sweep_runs import SweepPlan, columns

STAGED = """\
description = "Many combinations of a staged scene."
scenario = "luxloop.scenarios.study.staged:hidden_behind_wall"
seeds = {seeds}
fixed = {{ speed_mps = 10.0 }}
vary = [{{ key = "occlusion_s", low = 0.3, high = 3.0, steps = {steps} }}]
curve = [{{ metric = "track.hota", against = "occlusion_s" }}]
"""
GB = 1e9
WORKER_PAGES = 25_000
"""A worker that has loaded its modules has more memory than this; the resource tracker, another child, less."""


def staged(folder: Path, steps: int, seeds: int = 1) -> Path:
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / "staged.toml"
    path.write_text(STAGED.format(steps=steps, seeds=seeds), encoding="utf-8")
    return path


def test_scenes_are_built_when_their_runs_are_due(tmp_path: Path, monkeypatch):
    """The first ten of ten thousand combinations are there before the others are built."""
    built, scene = list[float](), design._staged
    monkeypatch.setattr(design, "_staged", lambda *a: built.append(a[2]["occlusion_s"]) or scene(*a))
    planned = islice(design.plan(Study.load(staged(tmp_path, 10_000)), device.SHIPPED), 10)
    assert [run.index for of_combination in planned for run in of_combination] == list(range(10))
    assert len(built) == 10


def test_a_resumed_sweep_begins_before_the_scenes_of_earlier_rows_are_built(tmp_path: Path, monkeypatch):
    """Of 20 combinations the last one has no row, another one a row with other inputs: that one is found at the end."""
    study, built = Study.load(staged(tmp_path, 20)), list[float]()
    planned = runs(study, device.SHIPPED)
    with RowStore.opened(tmp_path / "out", ["occlusion_s"]) as store:
        store.add([as_text(row_of(run) | ({"key": "old"} if run.index == 14 else {})) for run in planned[:-1]])
    scene = design._staged
    monkeypatch.setattr(design, "_staged", lambda *a: built.append(a[2]["occlusion_s"]) or scene(*a))
    monkeypatch.setattr(sweep_runs, "CHECKED_FIRST", 5)
    with RowStore.opened(tmp_path / "out", ["occlusion_s"]) as store:
        plan = SweepPlan(study, device.SHIPPED, store, retry_errors=False)
        missing = plan.missing()
        assert next(missing).index == 19
        assert built == [run.parameters["occlusion_s"] for run in [planned[19], *planned[:4]]]
        assert plan.unseen == 15
        assert [run.index for run in missing] == [14]
        assert plan.unseen == 0
    assert len(plan.taken_over) == 18
    assert plan.keys == [run.key for run in planned]


def test_combinations_with_an_error_are_built_first_if_they_are_run_again(tmp_path: Path):
    study = Study.load(staged(tmp_path, 3))
    with RowStore.opened(tmp_path / "out", ["occlusion_s"]) as store:
        *passed, failed = [row_of(run) for run in runs(study, device.SHIPPED)]
        store.add([as_text(row) for row in (*passed, failed | {"status": "error"})])
    with RowStore.opened(tmp_path / "out", ["occlusion_s"]) as store:
        plan = SweepPlan(study, device.SHIPPED, store, retry_errors=True)
        missing = plan.missing()
        assert next(missing).index == 2
        assert not plan.taken_over
        assert not list(missing)
        assert len(plan.taken_over) == 2
        assert not list(SweepPlan(study, device.SHIPPED, store, retry_errors=False).missing())


def row_of(run: design.StudyRun) -> dict:
    """A row of a run without metrics."""
    known = {"status": "passed", "error": "", "trace_hash": "0" * 32, "frames": 100, "wall_s": 1.0, "why": "new"}
    inputs = {"key": run.key, "seed": run.seed, "tracker": run.tracker, "inputs": json.dumps(run.inputs)}
    return inputs | run.parameters | known


def test_short_runs_are_grouped_and_long_ones_are_alone(tmp_path: Path):
    short = runs(Study.load(small_study(tmp_path, seeds=3)), device.SHIPPED)
    assert [len(group) for group in dask_runs.grouped(iter(short), 5)] == [5, 5, 2]
    text = (tmp_path / "small.toml").read_text().replace("duration_s = 0.1", "duration_s = 40.0")
    (tmp_path / "small.toml").write_text(text)
    long = runs(Study.load(tmp_path / "small.toml"), device.SHIPPED)
    assert [len(group) for group in dask_runs.grouped(iter(long), 5)] == [1] * 12


def test_the_option_of_parts_is_accepted_with_a_line_that_it_is_no_longer_needed(tmp_path: Path, monkeypatch, capfd):
    study = small_study(tmp_path, seeds=1)
    monkeypatch.chdir(tmp_path)
    with worker_thread() as scheduler:
        options = ["--scheduler", scheduler, "--out", "out", "--parts", str(tmp_path / "parts"), "--json"]
        assert main(["sweep", study.name, *options]) == 0
    output, error = capfd.readouterr()
    assert error == "luxloop: --parts is no longer needed: all rows are in runs.sqlite; leave it out\n"
    assert json.loads(output)["status"] == {"passed": 4}
    assert not (tmp_path / "parts").exists()


@pytest.mark.soak
def test_kills_of_schedulers_and_workers_and_a_full_disk_lose_and_double_no_row(tmp_path: Path):
    """Two schedulers and ten workers are killed, and the disk is full once."""
    study, killed = small_study(tmp_path / "study", seeds=25), 0
    for attempt in range(2):
        (tmp_path / f"cluster{attempt}").mkdir()
        with cluster(tmp_path / f"cluster{attempt}", workers=2) as (address, scheduler):
            process = start(study, "--scheduler", address)
            wait_for_rows(study, rows_so_far(study) + 8, process)
            os.killpg(scheduler.pid, signal.SIGKILL)
            process.communicate(timeout=PATIENCE_S)
            end(process)
            assert process.returncode == 2
    done = len(rows(study))
    assert done >= 16
    process = start(study, "--workers", "2")
    wait_for_rows(study, done + 4, process)
    resource.prlimit(process.pid, resource.RLIMIT_FSIZE, (rows_bytes(study) + 100, resource.RLIM_INFINITY))
    _, error = process.communicate(timeout=PATIENCE_S)
    end(process)
    assert process.returncode == 2
    assert "cannot write there" in error
    process = start(study, "--workers", "2")
    while killed < 10 and process.poll() is None:
        before = rows_so_far(study)
        worker = max(children_of(process.pid), key=memory_pages, default=None)
        if worker is None or memory_pages(worker) < WORKER_PAGES:
            time.sleep(0.1)
            continue
        os.kill(worker, signal.SIGKILL)
        killed += 1
        wait_until_more(study, before, process)
    _, error = process.communicate(timeout=PATIENCE_S)
    end(process)
    assert (process.returncode, error) == (0, "")
    assert killed == 10
    assert list(rows(study)["trace_hash"]) == sequential_hashes(study)
    assert list(rows(study)["index"]) == list(range(100))


def rows_bytes(study: Path) -> int:
    """Size of the larger of the SQLite file and its write-ahead log."""
    return max(path.stat().st_size for path in (study.parent / "out").glob("runs.sqlite*"))


def memory_pages(pid: int) -> int:
    try:
        return int(Path(f"/proc/{pid}/statm").read_text().split()[1])
    except OSError:
        return 0


def wait_until_more(study: Path, count: int, process) -> None:
    deadline = time.monotonic() + PATIENCE_S
    while rows_so_far(study) <= count and process.poll() is None:
        assert time.monotonic() < deadline
        time.sleep(0.02)


@pytest.mark.soak
def test_the_memory_of_a_sweep_of_a_hundred_thousand_runs_is_below_one_gigabyte(tmp_path: Path):
    path = staged(tmp_path, steps=100, seeds=1000)
    study = Study.load(path)
    names = [*standard_names()]
    metrics = dict(
        zip(names, np.random.default_rng(0).random(len(names)).tolist(), strict=True)
    )  # rows of 15 kB: every metric has a value
    with RowStore.opened(tmp_path / "out", ["occlusion_s"]) as store:
        for planned in design.plan(study, device.SHIPPED):
            store.add([as_text(row_of(run) | metrics) for run in planned])
    assert (tmp_path / "out" / "runs.sqlite").stat().st_size > GB
    for _ in range(2):
        command = [sys.executable, "-m", "luxloop", "sweep", path.name, "--out", "out", "--json"]
        environment = {**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, sys.path))}
        process = subprocess.Popen(command, cwd=tmp_path, env=environment, stdout=subprocess.PIPE, text=True)
        output, peak = process.stdout.read(), 0.0
        _, status, usage = os.wait4(process.pid, 0)
        process.returncode, peak = os.waitstatus_to_exitcode(status), usage.ru_maxrss * 1024
        process.stdout.close()
        print(f"peak {peak / 1e6:.0f} MB, {usage.ru_utime:.0f} s")
        assert process.returncode == 0
        assert json.loads(output)["taken_up"] == 100_000
        assert peak < GB


def test_only_the_columns_of_curves_are_read_back(tmp_path: Path):
    study = Study.load(staged(tmp_path, 2))
    assert columns(study)[-1] == "track.hota"
    assert "track.mota" not in columns(study)
