"""Runs killed in any phase: they leave no folder that reads as a run, and the next run removes their files."""

import hashlib
import random
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import AbstractContextManager, contextmanager
from pathlib import Path

import pytest
from support import short_run, warm_process
from support.processes import children_of, is_dead, stop, until

from luxloop.scenarios.errors import OutputError
from luxloop.scenarios.run import run_folder

LUXLOOP = str(Path(sys.executable).with_name("luxloop"))
RUNS, OUT, TEMPORARY = Path("runs"), Path("runs/here"), Path("temporary")
EARLIER, KILLED = 1, 2
"""Seeds of the earlier run and of the runs that are killed while they replace it."""

PHASES = {"starts": "", "drives": ".*-{pid}-*.partial", "writes": ".*-{pid}-*.partial/report.txt"}
"""Phases of a run, with the file that appears when each begins."""
MOMENTS = 2
"""Kills in each phase of each scenario: 12 in all."""


@pytest.fixture(autouse=True)
def _in_a_folder_of_its_own(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    TEMPORARY.mkdir()
    monkeypatch.setenv("TMPDIR", str(TEMPORARY.absolute()))
    short_run.write(Path())


@pytest.mark.parametrize(
    ("scenario", "phases"),
    [
        pytest.param("short.toml", ["writes"], marks=pytest.mark.slow),
        pytest.param("short.toml", [*PHASES] * MOMENTS, marks=pytest.mark.slow),
        pytest.param("sumo-crossing", [*PHASES] * MOMENTS, marks=pytest.mark.slow),
    ],
)
def test_a_killed_run_leaves_no_folder_that_reads_as_a_run(scenario, phases):
    start = installed if "starts" in phases else forked
    with start(scenario, EARLIER) as run:
        lasts = finish(run)
    earlier = files(OUT)
    found = []
    rng = random.Random(len(phases))
    for phase in phases:
        with start(scenario, KILLED) as run:
            kill(run, phase, lasts[phase] * rng.random())
        assert OUT in RUNS.iterdir()
        found += [facts(folder) for folder in RUNS.iterdir() if files(folder) != earlier]
        assert list(TEMPORARY.iterdir()) == []
    with start(scenario, KILLED) as run:
        finish(run)
    assert [folder.name for folder in RUNS.iterdir()] == [OUT.name]
    whole = facts(OUT)
    assert whole is not None
    assert all(run in (None, whole) for run in found)


@contextmanager
def installed(scenario: str, seed: int) -> Iterator[subprocess.Popen]:
    """Start the installed command on ten frames."""
    command, quiet = [LUXLOOP, *arguments(scenario, seed)], subprocess.DEVNULL
    with subprocess.Popen(command, stdout=quiet, stderr=quiet) as run:
        yield run


def forked(scenario: str, seed: int) -> AbstractContextManager[warm_process.Forked]:
    """Start the command in a forked process, where the start itself is of no interest."""
    return warm_process.started("luxloop", *arguments(scenario, seed))


def arguments(scenario: str, seed: int) -> list[str]:
    return ["run", scenario, "--seed", str(seed), "--duration", "0.8", "--out", str(OUT)]


def finish(run) -> dict[str, float]:
    """Wait for the end of a run, and return the duration of each phase [s]."""
    began = []
    for phase in PHASES:
        until(lambda phase=phase: is_at(run, phase), pause_s=0.001)
        began.append(time.monotonic())
    assert run.wait(timeout=60) in (0, 1)  # of ten frames, expectations may fail
    ended = [*began[1:], time.monotonic()]
    return {phase: end - begin for phase, begin, end in zip(PHASES, began, ended, strict=True)}


def kill(run, phase: str, delay_s: float) -> None:
    """Kill a run some time after a phase began, and wait for the end of its simulator."""
    until(lambda: is_at(run, phase), pause_s=0.001)
    time.sleep(delay_s)
    stop(run.pid)  # so that it starts no process before the kill
    simulators = children_of(run.pid)
    run.kill()
    run.wait(timeout=60)
    until(lambda: all(map(is_dead, simulators)), patience_s=20.0)


def is_at(run, phase: str) -> bool:
    """Return True if a run has reached a phase or has ended."""
    sign = PHASES[phase].format(pid=run.pid)
    return not sign or any(RUNS.glob(sign)) or run.poll() is not None


def files(folder: Path) -> dict[str, str]:
    """Return the hash of every file below a folder."""
    found = [path for path in sorted(folder.rglob("*")) if path.is_file()]
    return {str(path.relative_to(folder)): hashlib.sha256(path.read_bytes()).hexdigest() for path in found}


def facts(folder: Path) -> object:
    """Return the content of a run that is bit-identical for the same seed; None if the folder holds no run."""
    try:
        result = run_folder.read(folder)
    except OutputError:
        return None
    metrics = {name: metric for name, metric in result.metrics.items() if not name.startswith("perf.")}
    recorded = run_folder.recording(folder).stat().st_size > 0
    tables = files(folder / run_folder.TABLES)
    return result.seed, result.trace_hash, result.frames, result.ended_early, metrics, tables, recorded
