"""Signals whose KeyboardInterrupt is lost before it reaches luxloop."""

import importlib
import signal
import subprocess
import sys
import time
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest
from support import short_run

from luxloop.scenarios.cli import main
from luxloop.scenarios.rerun_log.recorder import NullRecorder
from luxloop.scenarios.run.termination import as_interrupts, raise_lost


class Member(type):
    """Class of an object on whose attributes Python code runs, as on those of an enumeration of Python 3.11."""

    number = 0
    frames = 0

    def __getattr__(cls, name):
        if Member.number:
            number, Member.number = Member.number, 0
            signal.raise_signal(number)
        raise AttributeError(name)


class Compared(metaclass=Member):
    pass


@pytest.mark.parametrize(("number", "code"), [(signal.SIGINT, 130), (signal.SIGTERM, 143), (signal.SIGHUP, 129)])
def test_a_signal_that_numpy_drops_ends_the_run_at_the_next_frame(number, code, tmp_path, monkeypatch, capfd):
    def log(*_records):
        Member.number = number if not Member.frames else 0
        Member.frames += 1
        assert not (np.zeros(2) == Compared()).any()
        assert Member.number == 0, "the comparison must run Python code"

    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(NullRecorder, "log", log)
    monkeypatch.setattr(Member, "frames", 0)
    short_run.write(Path())
    assert main(["run", "short.toml", "--no-recording", "--out", "here"]) == code
    assert Member.frames == 1, "the run goes on after the signal"
    assert capfd.readouterr().err.splitlines()[-1] == "luxloop: error: interrupted; nothing was written"
    assert not Path("here").exists()


INTERRUPTED_MODULE = """\
import signal, time

signal.raise_signal(signal.{name})
began = time.monotonic()
while time.monotonic() < began + 0.2:  # longer than the interrupt waits before it tries again
    pass
complete = True
"""
DONE = list[bool]()


def import_and_wait(module):
    importlib.import_module(module)
    wait_for_interrupt()


def run_and_wait(path):
    exec(compile(path.read_text(), path, "exec"), {"done": DONE})
    wait_for_interrupt()


def wait_for_interrupt():
    """Return after 10 s without one. The system may give a signal to another thread: one long call would not see it."""
    end = time.monotonic() + 10.0
    while time.monotonic() < end:
        time.sleep(0.01)


@pytest.mark.parametrize("name", ["SIGINT", "SIGTERM"])
def test_an_interrupt_inside_llvmlite_waits_for_its_end(name, tmp_path):
    """It frees a module of LLVM twice if it is interrupted while another object becomes the module's owner."""
    file = tmp_path / "llvmlite" / "ffi.py"
    file.parent.mkdir()
    file.write_text(INTERRUPTED_MODULE.format(name=name) + "done.append(complete)\n")
    DONE.clear()
    with as_interrupts(), pytest.raises(KeyboardInterrupt):
        run_and_wait(file)
    assert DONE == [True]


@pytest.mark.parametrize("name", ["SIGINT", "SIGTERM"])
def test_an_interrupt_inside_an_import_waits_for_its_end(name, tmp_path, monkeypatch):
    """An extension module whose start is interrupted crashes the process, or leaves the lock of imports locked."""
    (tmp_path / "interrupted_module.py").write_text(INTERRUPTED_MODULE.format(name=name))
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.delitem(sys.modules, "interrupted_module", raising=False)
    before = signal.getsignal(signal.SIGALRM)
    with as_interrupts() as received, pytest.raises(KeyboardInterrupt):
        import_and_wait("interrupted_module")
    assert sys.modules["interrupted_module"].complete
    assert received.number == getattr(signal, name)
    assert signal.getsignal(signal.SIGALRM) == before
    assert signal.getitimer(signal.ITIMER_REAL)[0] == 0.0


def test_a_signal_after_the_end_of_a_command_leaves_its_exit_code():
    program = "import os, signal; from luxloop.scenarios.run import termination; termination.end_at_once(3); " \
        "os.kill(os.getpid(), signal.SIGTERM); signal.pause()"  # fmt: skip
    assert subprocess.run([sys.executable, "-c", program], check=False, timeout=60).returncode == 3


class Destroyed:
    """Object whose destructor meets an error."""

    def __init__(self, error):
        self.error = error

    def __del__(self):
        if self.error is KeyboardInterrupt:
            signal.raise_signal(signal.SIGTERM)
        raise self.error("lost")


def test_an_interrupt_in_a_destructor_is_raised_later_without_a_report(capfd):
    with as_interrupts():
        Destroyed(KeyboardInterrupt)
        with pytest.raises(KeyboardInterrupt):
            raise_lost()
    assert capfd.readouterr().err == ""


def test_other_errors_in_a_destructor_are_reported(monkeypatch):
    reported = []
    monkeypatch.setattr("sys.unraisablehook", lambda unraisable: reported.append(unraisable.exc_type))
    with as_interrupts():
        Destroyed(ValueError)
        raise_lost()
    Destroyed(ValueError)
    assert reported == [ValueError, ValueError]


def test_a_signal_that_was_lost_before_an_inner_context_ends_the_run_in_it():
    """As of a command that a test calls under the pytest plugin."""
    with as_interrupts():
        with suppress(KeyboardInterrupt):
            signal.raise_signal(signal.SIGTERM)
        with as_interrupts(), pytest.raises(KeyboardInterrupt):
            raise_lost()
