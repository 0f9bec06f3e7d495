"""Runs, sweeps, searches, leagues and suites of pytest, ended by KILL, TERM, HUP and INT at random moments.

Nothing that was complete is lost, nothing half-written reads as a result, and the next start goes on.
"""

import os
import random
import re
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from functools import cache
from pathlib import Path

import pandas as pd
import pytest
from support import league_scenes, short_run, warm_process
from support.optional import need_for
from support.processes import children_of, files_of, heed_hangups, is_dead, until
from support.sweeps import stored

from luxloop.scenarios.errors import OutputError
from luxloop.scenarios.run import run_folder

SIGNALS = (signal.SIGKILL, signal.SIGTERM, signal.SIGHUP, signal.SIGINT)
STUDY = """\
description = "Dropout against a car that drives past."
scenario = "short.toml"
{seeds}

[fixed]
duration_s = 0.1

[[vary]]
key = "noise.dropout.random_rate"
{values}
neutral = 0.0
"""
SEARCH = '\n[search]\nmetric = "track.hota"\nmin = -1.0\ntrials = 12\nat_once = 2\n'
PYTEST = ["pytest", "suite", "-q", "-p", "no:cacheprovider", "--luxloop-out", "runs"]
COMMANDS = {
    "run": ["luxloop", "run", "short.toml", "--out", "runs/here", "--record-scans", "--quiet"],
    "sweep": ["luxloop", "sweep", "sweep.toml", "--workers", "1", "--out", "rows", "--quiet"],
    "search": ["luxloop", "search", "search.toml", "--workers", "1", "--out", "found"],
    "league": [
        "luxloop",
        "league",
        "left.toml",
        "right.toml",
        "--seeds",
        "3",
        "--trackers",
        "paper,nearest-neighbour",
        "--workers",
        "2",
        "--out",
        "league",
        "--quiet",
    ],
    "pytest": PYTEST,
}
KILLS = 25
"""Kills of each command: 125 in all."""
PATIENCE_S = 300.0


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A folder with a scenario, a study, a search, the scenarios of a league, and a suite."""
    short_run.write(tmp_path)
    league_scenes.write(tmp_path)
    values = "values = [0.0, 0.1, 0.2]"
    (tmp_path / "sweep.toml").write_text(STUDY.format(seeds="seeds = 4", values=values))
    low_high = "low = 0.0\nhigh = 0.5"
    (tmp_path / "search.toml").write_text(STUDY.format(seeds="seeds = 1", values=low_high) + SEARCH)
    for name in ("one", "two", "three"):
        (tmp_path / "suite").mkdir(exist_ok=True)
        short_run.write(tmp_path / "suite", name=name)
    return tmp_path


@pytest.mark.parametrize(
    ("name", "kills"),
    [
        *(pytest.param(name, len(SIGNALS), marks=pytest.mark.slow) for name in COMMANDS),
        *(pytest.param(name, KILLS, marks=pytest.mark.soak) for name in COMMANDS),
    ],
)
def test_nothing_is_lost_or_half_written(name, kills, folder):
    need_for(name)
    rng = random.Random(f"{name} {kills}")
    whole_s = lasts(name)
    complete: dict[str, object] = {}
    killed = set[int]()
    for number in range(kills):
        number_of = SIGNALS[(number + 1) % len(SIGNALS)]
        code, err, pids = interrupted(name, folder, number_of, whole_s * rng.uniform(0.1, 1.0))
        killed |= set(pids) if number_of == signal.SIGKILL else set()
        assert_ended(name, number_of, code, err)
        now = found(name, folder)
        assert_kept(complete, now)
        assert owners(folder) <= killed, (number_of, pids, temporary(folder))
        complete = now
    last = warm_process.run(*COMMANDS[name], cwd=folder, timeout=PATIENCE_S)
    assert last.returncode in (0, 1), last.stderr
    assert_kept(complete, found(name, folder))
    assert temporary(folder) == []
    assert_whole(name, folder)


@cache
def lasts(name: str) -> float:
    """Return an estimate of the duration of a command on this machine [s]: that of the start, several times."""
    begin = time.monotonic()
    subprocess.run([sys.executable, "-c", "import luxloop.scenarios.execute"], check=True)
    return (time.monotonic() - begin) * {"run": 4.0, "sweep": 10.0, "search": 6.0, "league": 12.0, "pytest": 8.0}[name]


def start(name: str, folder: Path) -> subprocess.Popen[str]:
    """Start a command in a process group of its own, as a terminal does."""
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, sys.path))}
    return subprocess.Popen(
        [sys.executable, "-m", *COMMANDS[name]], cwd=folder, env=environment, start_new_session=True, text=True,
        preexec_fn=heed_hangups,
        stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE,
    )  # fmt: skip


def interrupted(name: str, folder: Path, number: int, delay_s: float) -> tuple[int, str, list[int]]:
    """Start a command, send a signal after some time; return exit code, standard error and the ids of its processes.

    A terminal sends INT and HUP to all processes of a command; KILL and TERM are sent to one. The signal is sent no
    earlier than the command has begun: before, Python handles it.
    """
    with ended(start(name, folder)) as process:
        time.sleep(delay_s)
        if name != "pytest":
            until(lambda: handles(process.pid, signal.SIGTERM) or process.poll() is not None, PATIENCE_S)
        children = children_of(process.pid)
        with suppress(ProcessLookupError):
            (os.kill if number in (signal.SIGKILL, signal.SIGTERM) else os.killpg)(process.pid, number)
        _, err = process.communicate(timeout=PATIENCE_S)
        until(lambda: all(map(is_dead, children)), patience_s=60.0)
    return process.returncode, err, [process.pid, *children]


@contextmanager
def ended(process: subprocess.Popen[str]) -> Iterator[subprocess.Popen[str]]:
    """End all processes of a group at the end."""
    try:
        yield process
    finally:
        with suppress(ProcessLookupError):
            os.killpg(process.pid, signal.SIGKILL)


def handles(pid: int, number: int) -> bool:
    """Return True if a process has a handler of a signal."""
    with suppress(OSError):
        lines = Path(f"/proc/{pid}/status").read_text().splitlines()
        caught = next(line.split()[1] for line in lines if line.startswith("SigCgt"))
        return bool(int(caught, 16) >> (number - 1) & 1)
    return False


def assert_ended(name: str, number: int, code: int, err: str) -> None:
    """Check the exit code, and that standard error is one line."""
    normal = (0, 1)  # the command was faster than the signal
    if name == "pytest":
        # 2 is that of Ctrl-C; a signal between two runs ends pytest at once
        codes = {
            signal.SIGINT: (2, 130, -2),
            signal.SIGTERM: (143, -15),
            signal.SIGHUP: (129, -1),
            signal.SIGKILL: (-9,),
        }
        assert code in (*normal, *codes[signal.Signals(number)]), err
        return
    if number == signal.SIGKILL:
        assert code in (*normal, -9), err
        return
    assert code in (*normal, 128 + number), (code, err)
    if code not in normal:
        assert err.startswith("luxloop: error: interrupted"), err
        assert err.count("\n") == 1, err


def temporary(folder: Path) -> list[Path]:
    """Return the temporary files and folders."""
    return [path for path in folder.rglob("*") if path.name.endswith((".partial", ".earlier"))]


def owners(folder: Path) -> set[int]:
    """Return the ids of the processes that made the temporary files and folders.

    Those of a killed process stay until the next command writes there, which a signal may end before.
    """
    names = [re.fullmatch(r"\..*-(\d+)-[0-9a-f]{8}\.(partial|earlier)", path.name) for path in temporary(folder)]
    assert all(names), temporary(folder)
    return {int(name[1]) for name in names if name}


def found(name: str, folder: Path) -> dict[str, object]:
    """Return the complete results by name."""
    if name == "run":
        return runs_in(folder / "runs")
    if name == "pytest":
        return runs_in(folder / "runs")
    out = folder / {"sweep": "rows", "search": "found", "league": "league"}[name]
    rows = stored(out)
    if (out / "runs.parquet").is_file():  # of this start or an earlier one
        assert rows.items() >= dict(pd.read_parquet(out / "runs.parquet")[["key", "trace_hash"]].values).items()
    return dict(rows)


def runs_in(folder: Path) -> dict[str, object]:
    """Return the trace hashes of the runs; every folder that has a result must be readable."""
    results = [path.parent for path in folder.rglob(run_folder.RESULT)]
    visible = [run for run in results if not run.name.startswith(".")]
    for run in set(results) - set(visible):
        with suppress(OutputError):
            run_folder.read(run)
    assert all((run / run_folder.REPORT).is_file() and files_of(run) for run in visible)
    return {run.name: run_folder.read(run).trace_hash for run in visible}


def assert_kept(before: dict[str, object], now: dict[str, object]) -> None:
    """Check that every result is still there and the same."""
    assert {key: now.get(key) for key in before} == before


def assert_whole(name: str, folder: Path) -> None:
    """Check that the last start, which was not interrupted, completed the command."""
    expected = {"run": 1, "pytest": 3, "sweep": 12, "league": 6}
    results = found(name, folder)
    if name in ("sweep", "search"):
        assert sorted(
            pd.read_parquet(folder / {"sweep": "rows", "search": "found"}[name] / "runs.parquet")["key"]
        ) == sorted(results)
    assert len(results) == expected.get(name, len(results))
    assert results
