"""A run that is killed leaves nothing that passes for a run, whatever it was at, and nothing in the way of the next."""

import hashlib
import os
import random
import subprocess
import sys
import time
from pathlib import Path

import pytest
from support import short_run
from support.processes import children_of, is_dead, until

from scenarios.errors import OutputError
from scenarios.run import run_folder

LUXLOOP = str(Path(sys.executable).with_name("luxloop"))
RUNS, OUT, TEMPORARY = Path("runs"), Path("runs/here"), Path("temporary")
EARLIER, KILLED = 1, 2
"""Seeds of the run that is there already and of those that are killed over it."""

PHASES = {"starts": "", "drives": ".*-{pid}-*.partial", "writes": ".*-{pid}-*.partial/report.txt"}
"""What a run is at, with what appears when it begins to."""
MOMENTS = 4
"""In each phase, of each scenario: 24 in all."""


@pytest.fixture(autouse=True)
def _in_an_own_folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    TEMPORARY.mkdir()
    short_run.write(Path())


@pytest.mark.parametrize(
    ("scenario", "phases"),
    [
        ("short.toml", ["writes"]),
        pytest.param("short.toml", [*PHASES] * MOMENTS, marks=pytest.mark.slow),
        pytest.param("sumo-crossing", [*PHASES] * MOMENTS, marks=pytest.mark.slow),
    ],
)
def test_a_killed_run_leaves_no_folder_that_passes_for_a_run(scenario, phases):
    lasts = finish(start(scenario, EARLIER))
    earlier = files(OUT)
    found = []
    rng = random.Random(len(phases))
    for phase in phases:
        kill(start(scenario, KILLED), phase, lasts[phase] * rng.random())
        assert OUT in RUNS.iterdir()
        found += [facts(folder) for folder in RUNS.iterdir() if files(folder) != earlier]
        assert list(TEMPORARY.iterdir()) == []
    finish(start(scenario, KILLED))
    assert [folder.name for folder in RUNS.iterdir()] == [OUT.name]
    whole = facts(OUT)
    assert whole is not None
    assert all(run in (None, whole) for run in found)


def start(scenario: str, seed: int) -> subprocess.Popen:
    """Start the real command on ten frames."""
    command = [LUXLOOP, "run", scenario, "--seed", str(seed), "--duration", "0.8", "--out", str(OUT)]
    environment = {**os.environ, "TMPDIR": str(TEMPORARY.absolute())}
    return subprocess.Popen(command, env=environment, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)


def finish(run: subprocess.Popen) -> dict[str, float]:
    """Let it end by itself, and return how long it was at what [s]."""
    began = []
    for phase in PHASES:
        until(lambda phase=phase: is_at(run, phase), pause_s=0.001)
        began.append(time.monotonic())
    assert run.wait(timeout=60) in (0, 1)  # of ten frames, expectations may fail
    ended = [*began[1:], time.monotonic()]
    return {phase: end - begin for phase, begin, end in zip(PHASES, began, ended, strict=True)}


def kill(run: subprocess.Popen, phase: str, delay_s: float) -> None:
    """Kill it so long after it began with something; its simulator dies with it."""
    until(lambda: is_at(run, phase), pause_s=0.001)
    time.sleep(delay_s)
    simulators = children_of(run.pid)
    run.kill()
    run.wait()
    until(lambda: all(map(is_dead, simulators)), patience_s=20.0)


def is_at(run: subprocess.Popen, phase: str) -> bool:
    """Whether a run has come to a phase, or is past it all."""
    sign = PHASES[phase].format(pid=run.pid)
    return not sign or any(RUNS.glob(sign)) or run.poll() is not None


def files(folder: Path) -> dict[str, str]:
    """What is in every file below a folder, byte for byte."""
    found = [path for path in sorted(folder.rglob("*")) if path.is_file()]
    return {str(path.relative_to(folder)): hashlib.sha256(path.read_bytes()).hexdigest() for path in found}


def facts(folder: Path) -> object:
    """What two runs of the same seed have in common to the last bit; nothing if it is no run."""
    try:
        result = run_folder.read(folder)
    except OutputError:
        return None
    metrics = {name: metric for name, metric in result.metrics.items() if not name.startswith("perf.")}
    recorded = run_folder.recording(folder).stat().st_size > 0
    tables = files(folder / run_folder.TABLES)
    return result.seed, result.trace_hash, result.frames, result.ended_early, metrics, tables, recorded
