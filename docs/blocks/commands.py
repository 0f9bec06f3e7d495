"""Commands whose output blocks show. They run in the root of the repository, as a reader would type them."""

import json
import os
import shlex
import subprocess
import sys
from functools import cache
from pathlib import Path

from blocks.stamps import baseline

ROOT = Path(__file__).parents[2]
RUNS, SWEEPS = ROOT / "runs", ROOT / "sweeps"
REAL = "LUXLOOP_REAL_DATA"
WIDTH = "110"
"""Columns of what commands print."""


class Missing(Exception):
    """A need of a block is not on this machine."""


@cache
def output(command: str) -> str:
    """Run a command once, and return what it prints. Failed expectations and an exit code of 1 are results."""
    program, *rest = shlex.split(command)
    place = Path(sys.executable) if program == "python" else Path(sys.executable).with_name(program)
    words = [str(place) if place.exists() else program, *rest]
    print(f"    {command}", flush=True)
    environment = {**os.environ, "COLUMNS": WIDTH}
    done = subprocess.run(words, cwd=ROOT, env=environment, stdout=subprocess.PIPE, text=True, check=False)
    if done.returncode not in (0, 1):
        raise Missing(f"{command} ends with {done.returncode}")
    return done.stdout


def run(name: str, *, recording: bool = False) -> Path:
    """Return the folder of a shipped scenario's run with the trace hash of the baseline, and with a recording if asked.

    The scenario runs if there is no such folder. A run that differs from the baseline is `Missing`.
    """
    folder = RUNS / f"{name}-seed1"
    recorded = folder / "recording.rrd"
    if not of_baseline(name) or (recording and not recorded.is_file()):
        output(f"luxloop run {name}")
    if not of_baseline(name):
        raise Missing(f"{folder} has not the trace hash of the baseline; `make catalog` and `make baseline` first")
    if recording and not recorded.is_file():
        raise Missing(f"{folder} has no recording.rrd; luxloop run {name}")
    return folder


def of_baseline(name: str) -> bool:
    """Return whether the run of a shipped scenario is there and has the trace hash of the baseline."""
    path = RUNS / f"{name}-seed1" / "result.json"
    return path.is_file() and json.loads(path.read_text(encoding="utf-8"))["trace_hash"] == baseline()[name].trace_hash


def real(name: str) -> Path:
    """Return a folder of real recordings."""
    folder = Path(os.environ.get(REAL, "/nowhere")) / name
    if not folder.is_dir():
        raise Missing(f"{REAL} does not name a folder with {name}")
    sys.path += map(str, (Path(sys.prefix) / "separate").glob(f"{name}-*"))  # its reader, installed there by the tests
    return folder
