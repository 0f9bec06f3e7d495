"""Signals while pytest runs a scenario: its exit code, at whatever place of a tracker they arrive."""

import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest
from support import short_run

TRACKER = """
import signal

class Tracker:
    def __init__(self, config):
        pass
    def step(self, scan):
        {statement}
"""
PLACES = {
    "directly": "signal.raise_signal(signal.{name})",
    "inside exec": "exec('signal.raise_signal(signal.{name})')",
    "while numba loads": (
        "try:\n            signal.raise_signal(signal.{name})\n"
        "        except KeyboardInterrupt as error:\n            raise SystemError from error"
    ),
}


@pytest.mark.parametrize("place", PLACES)
@pytest.mark.parametrize(("number", "code"), [(signal.SIGINT, 2), (signal.SIGTERM, 143), (signal.SIGHUP, 129)])
def test_a_signal_ends_the_session_with_its_exit_code(place, number, code, tmp_path: Path):
    """CPython would end a session by SIGINT if its interrupt left a string given to `exec`."""
    (tmp_path / "suite").mkdir()
    for name in ("first", "second"):
        short_run.write(tmp_path / "suite", name=name)
    (tmp_path / "ended.py").write_text(TRACKER.format(statement=PLACES[place].format(name=number.name)))
    command = [sys.executable, "-m", "pytest", "suite", "-q", "-p", "no:cacheprovider"]
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(["", *filter(None, sys.path)])}
    done = subprocess.run(
        [*command, "--luxloop-tracker", "ended:Tracker"],
        cwd=tmp_path, env=environment, capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == code, done.stdout + done.stderr
    assert "failed" not in done.stdout
    assert list((tmp_path / "runs").rglob("*")) == []
