"""A small study, `luxloop sweep` as a subprocess, and the expected rows."""

import os
import signal
import sqlite3
import subprocess
import sys
import time
from contextlib import closing, suppress
from pathlib import Path

import pandas as pd
from support.optional import need
from support.short_run import write

from luxloop.scenarios.run import device
from luxloop.scenarios.study.design import runs
from luxloop.scenarios.study.study_file import Study
from luxloop.scenarios.study.worker import carry_out

STUDY = """\
description = "Dropout against a car that drives past."
scenario = "short.toml"
seeds = {seeds}

[fixed]
duration_s = 0.1

[[vary]]
key = "noise.dropout.random_rate"
values = [0.0, 0.1, 0.2, 0.3]
"""
PATIENCE_S = 600
"""[s] Timeout of a sweep, and of a hundred runs of one: other jobs of the machine may slow it down."""


def small_study(folder: Path, seeds: int = 2, more: str = "") -> Path:
    """Write a study of four values and `seeds` seeds, and its scenario; return its path."""
    folder.mkdir(parents=True, exist_ok=True)
    write(folder)
    path = folder / "small.toml"
    path.write_text(STUDY.format(seeds=seeds) + more, encoding="utf-8")
    return path


def sequential_hashes(study: Path) -> list[str]:
    """Return the trace hashes of all runs, executed sequentially in this process, without Dask."""
    return [carry_out(run)["trace_hash"] for run in runs(Study.load(study), device.SHIPPED)]


def start(study: Path, *options: str) -> subprocess.Popen[str]:
    """Start `luxloop sweep` in a new process group, as a terminal does."""
    need("sweeps")
    command = [sys.executable, "-m", "luxloop", "sweep", study.name, "--out", "out", *options]
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, sys.path)), "NO_COLOR": "1"}
    return subprocess.Popen(
        command, cwd=study.parent, env=environment, start_new_session=True, text=True,
        stdout=subprocess.PIPE, stderr=subprocess.PIPE,
    )  # fmt: skip


def sweep(study: Path, *options: str) -> tuple[int, str, str]:
    """Run `luxloop sweep`; return exit code, standard output and standard error."""
    process = start(study, *options)
    try:
        output, error = process.communicate(timeout=PATIENCE_S)
    finally:
        end(process)
    return process.returncode, output, error


def end(process: subprocess.Popen[str]) -> None:
    """Kill the remaining processes of a process group."""
    with process, suppress(ProcessLookupError):
        os.killpg(process.pid, signal.SIGKILL)


def rows_so_far(study: Path) -> int:
    """Return the number of rows of a sweep, also while it runs."""
    return len(stored(study.parent / "out"))


def stored(folder: Path) -> dict[str, str]:
    """Return the trace hashes of the rows in the SQLite file of a folder by key, in the order of their arrival."""
    if not (folder / "runs.sqlite").is_file():
        return {}
    with closing(sqlite3.connect(f"file:{folder / 'runs.sqlite'}?mode=ro", uri=True, timeout=PATIENCE_S)) as database:
        if not database.execute("SELECT 1 FROM sqlite_master WHERE name = 'runs'").fetchone():
            return {}  # a command has just begun
        return dict(database.execute("SELECT key, facts ->> 'trace_hash' FROM runs ORDER BY rowid"))


def wait_for_rows(study: Path, count: int, process: subprocess.Popen[str]) -> None:
    """Wait until a sweep has `count` rows."""
    deadline = time.monotonic() + PATIENCE_S
    while rows_so_far(study) < count:
        assert process.poll() is None, f"the sweep ended: {process.communicate()}"
        assert time.monotonic() < deadline, "timeout: too few rows"
        time.sleep(0.02)


def rows(study: Path) -> pd.DataFrame:
    """Return the rows of a completed sweep."""
    return pd.read_parquet(study.parent / "out" / "runs.parquet")
