"""Runs, sweeps, searches, leagues and suites of pytest, ended by KILL, TERM, HUP and INT at random moments.

Nothing that was complete is lost, nothing half-written reads as a result, and the next start goes on.
"""

import math
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
PROCESSES = {"judge": "", "tracker": "tracker_server", "metrics": "own_metrics", "world": "sim.process.worker"}
"""Processes of a run, and a part of their command lines."""
OPTIONS = {role: ["--tracker", "own.py:Mine", "--ahead"] for role in PROCESSES}
OPTIONS |= {"tracker": ["--tracker", "own.py:Mine", "--no-ahead"], "metrics": ["--no-ahead"]}
"""Options of the run in which they are killed, with few other processes."""
ENDS = {"judge": (-signal.SIGKILL,), "tracker": (2, 4), "metrics": (2,), "world": (3,)}
"""Exit codes of a run by the process that is killed; 2 is also a tracker that is killed at its import."""
KILLS_OF_EACH = 100
OWN_CODE = """\
import time
from luxloop.tracker.records import Tracks

class Mine:
    def __init__(self, config): ...
    def step(self, scan):
        time.sleep(0.1)
        return Tracks.from_boxes([1], [[9.0, 3.0]], [0.0], (4.5, 1.8))

def one(tables):
    time.sleep(0.3)
    return 1.0
"""
OWN_METRIC = '[[metric]]\nname = "own.one"\nfunction = "own.py:one"\n'


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


@pytest.mark.parametrize(
    ("role", "kills"),
    [
        *(pytest.param(role, len(SIGNALS), marks=pytest.mark.slow) for role in PROCESSES),
        *(pytest.param(role, KILLS_OF_EACH, marks=pytest.mark.soak) for role in PROCESSES),
    ],
)
def test_a_run_ends_in_one_line_if_one_of_its_processes_is_killed(role, kills, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "scratch").mkdir()
    monkeypatch.setenv("TMPDIR", str(tmp_path / "scratch"))
    short_run.write(tmp_path, short_run.TEXT + OWN_METRIC)
    (tmp_path / "own.py").write_text(OWN_CODE)
    begin = time.monotonic()
    assert run_killed(role)[:2] == (0, "")
    whole, whole_s = runs_in(tmp_path), time.monotonic() - begin
    rng, done = random.Random(f"{role} {kills}"), 0
    while done < kills:
        code, err, family, killed = run_killed(role, whole_s * rng.random())
        done += killed
        lines = [line for line in err.splitlines() if not line.endswith("left by a command that was killed")]
        assert code in (ENDS[role] if lines or (role == "judge" and killed) else (0,)), (code, err)
        assert len(lines) <= (role != "judge"), err
        until(lambda family=family: all(map(is_dead, family)))
        until(lambda: not any((tmp_path / "scratch").iterdir()))
        assert role == "judge" or temporary(tmp_path) == []
        assert code in (3, -signal.SIGKILL) or runs_in(tmp_path) == whole
    assert run_killed(role)[0] == 0
    assert (runs_in(tmp_path), temporary(tmp_path)) == (whole, [])


def run_killed(role: str, delay_s: float = math.inf) -> tuple[int, str, list[int], bool]:
    """Run the scenario, and kill one of its processes some time after the start, or when it begins later.

    Return the exit code, standard error, all processes, and whether one was killed.
    """
    command = ["run", "short.toml", "--out", "runs/here", "--no-recording", "--quiet", *OPTIONS[role]]
    family, chosen, due = list[int](), list[int](), time.monotonic() + delay_s
    with warm_process.started("luxloop", *command) as run:
        while not chosen and run.poll() is None:
            time.sleep(0.005)
            if time.monotonic() > due:
                family = descendants(run.pid)
                chosen = [pid for pid in family if PROCESSES[role] in arguments(pid)]
        with suppress(ProcessLookupError, IndexError):
            os.kill(chosen[0], signal.SIGKILL)
        _, err = run.communicate(PATIENCE_S)
    return run.returncode, err, family, bool(chosen)


def descendants(pid: int) -> list[int]:
    """Return the ids of a process and of all that it started."""
    return [pid, *(found for child in children_of(pid) for found in descendants(child))]


def arguments(pid: int) -> str:
    """Return the command line of a process; empty if it has ended."""
    with suppress(OSError):
        return Path(f"/proc/{pid}/cmdline").read_text()
    return ""


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
