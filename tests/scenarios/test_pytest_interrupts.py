"""Signals while pytest runs a scenario: its exit code, at any place of a tracker."""

import signal
from pathlib import Path

import pytest
from support import short_run, warm_process
from support.few import few

TRACKER = """
import signal
from luxloop.scenarios.run import device

class Tracker:
    def __init__(self, config):
        pass
    def step(self, scan):
        {statement}

device.TRACKERS.core["ended"] = Tracker
"""
PLACES = {
    "directly": "signal.raise_signal(signal.{name})",
    "inside exec": "exec('signal.raise_signal(signal.{name})')",
}

LOADING = """
import signal
from luxloop.scenarios import execute

def loading(*_, **__):
    try:
        signal.raise_signal(signal.{name})
    except KeyboardInterrupt as error:
        raise SystemError("CPUDispatcher") from error

execute.execute = loading
"""
"""Error that numba raises for a signal while it loads a kernel, outside the tracker."""
CODES = [(signal.SIGINT, 2), (signal.SIGTERM, 143), (signal.SIGHUP, 129)]


@pytest.mark.parametrize("place", PLACES)
@pytest.mark.parametrize(("number", "code"), few(CODES, signal.SIGINT))
def test_a_signal_ends_the_session_with_its_exit_code(place, number, code, tmp_path: Path):
    """CPython would end a session by SIGINT if its interrupt left a string given to `exec`."""
    (tmp_path / "ended.py").write_text(TRACKER.format(statement=PLACES[place].format(name=number.name)))
    assert_ends(tmp_path, code, "-p", "ended", "--luxloop-tracker", "ended")


@pytest.mark.parametrize(("number", "code"), few(CODES, signal.SIGTERM))
def test_a_signal_while_a_kernel_loads_ends_the_session(number, code, tmp_path: Path):
    """It would count as a failed scenario, and the session would go on."""
    (tmp_path / "loading.py").write_text(LOADING.format(name=number.name))
    assert_ends(tmp_path, code, "-p", "loading")


def assert_ends(folder: Path, code: int, *options: str) -> None:
    """Check that a suite of two scenarios ends in the first, and leaves nothing."""
    (folder / "suite").mkdir()
    for name in ("first", "second"):
        short_run.write(folder / "suite", name=name)
    command = ["pytest", "suite", "-q", "-p", "no:cacheprovider", *options]
    done = warm_process.run(*command, cwd=folder, delete_modules=True)
    assert done.returncode == code, done.stdout + done.stderr
    assert "failed" not in done.stdout
    assert list((folder / "runs").rglob("*")) == []
