"""Processes with code of the user: how they end, what they leave, and that no answer comes too early or never."""

import os
import signal
import sys
import tempfile
import time

import pytest

from luxloop.scenarios.run.child_process import ChildError, ChildProcess, ChildTimeoutError

SPIN = "\nwhile True: os.read(0, 1) or os._exit(0)"
"""Waits for the end of the input."""


@pytest.fixture
def scratch(tmp_path, monkeypatch):
    """Folder for temporary folders."""
    (tmp_path / "scratch").mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path / "scratch"))
    monkeypatch.setenv("TMPDIR", str(tmp_path / "scratch"))
    return tmp_path / "scratch"


def started(script):
    """A child that has run a script, and has written one byte after it."""
    child = ChildProcess([sys.executable, "-I", "-S", "-c", f"import os, signal\n{script}\nos.write(1, b'.'){SPIN}"])
    child.receive(1, time.monotonic() + 20.0)
    return child


def test_a_signal_without_a_name_has_its_number():
    with pytest.raises(ChildError, match="ended by signal 37"):
        started("os.kill(os.getpid(), 37)")


def test_an_answer_before_its_request_is_refused():
    child = ChildProcess([sys.executable, "-I", "-S", "-c", f"import os; os.write(1, b'..'){SPIN}"])
    child.receive(1, time.monotonic() + 20.0)
    with pytest.raises(ChildError, match="answered before it was asked"):
        child.send(b"request", time.monotonic() + 20.0)
    child.close()


def test_an_answer_in_small_parts_has_the_same_time_limit():
    child = started("os.write(1, b'.')\nwhile True: os.write(1, b'a')")
    began = time.monotonic()
    with pytest.raises(ChildTimeoutError):
        child.receive(1 << 28, began + 0.2)
    child.close()


LOCKED = "os.makedirs('a/b'); os.chmod('a', 0); os.chmod('.', 0)"
REPLACED = "here = os.getcwd(); os.chdir('/'); os.rmdir(here); "
LEFT = {
    "temporary": "import tempfile; tempfile.mkdtemp()",
    "locked": LOCKED,
    "link": REPLACED + "os.symlink({kept!r}, here)",
    "file": REPLACED + "os.close(os.open(here, os.O_CREAT))",
}


@pytest.mark.parametrize("script", LEFT.values(), ids=LEFT)
def test_its_folder_is_removed_whatever_is_in_its_place(script, scratch):
    kept = scratch.parent / "kept"
    kept.mkdir()
    (kept / "file").touch()
    child = started(script.format(kept=str(kept)))
    assert len(list(scratch.iterdir())) == 1
    child.close()
    assert list(scratch.iterdir()) == []
    assert (kept / "file").exists()


ORPHAN = """
read, write = os.pipe()
if os.fork() == 0:
    os.setsid()
    if os.fork() == 0:
        os.write(write, str(os.getpid()).encode())
        signal.pause()
    os._exit(0)
os.wait()
orphan = os.read(read, 20).rjust(20)
os.kill(os.getppid(), signal.Signals.{name})
os.write(1, orphan)
"""


@pytest.mark.parametrize("name", ["SIGTERM", "SIGINT", "SIGUSR1", "SIGRTMIN", "SIGSTOP"])
def test_signals_to_its_supervisor_leave_no_grandchild(name, scratch):
    child = ChildProcess([sys.executable, "-I", "-S", "-c", f"import os, signal{ORPHAN.format(name=name)}{SPIN}"])
    orphan = int(child.receive(20, time.monotonic() + 20.0))
    child.close()
    with pytest.raises(ProcessLookupError):
        os.kill(orphan, 0)
    assert list(scratch.iterdir()) == []


def test_a_killed_supervisor_leaves_no_folder(scratch):
    with pytest.raises(ChildError, match="ended by signal SIGKILL"):
        started(f"os.kill(os.getppid(), {int(signal.SIGKILL)}); signal.pause()")
    assert list(scratch.iterdir()) == []


def test_the_standard_error_of_the_judge_keeps_blocking():
    """Node.js sets its own to non-blocking; the judge would lose text when a pipe is full."""
    kept, (read, write) = os.dup(2), os.pipe()
    os.dup2(write, 2)
    try:
        child = started("os.set_blocking(2, False); os.write(2, b'told')")
        assert os.get_blocking(2)
        assert os.read(read, 10) == b"told"
        child.close()
    finally:
        os.dup2(kept, 2)
        for descriptor in (kept, read, write):
            os.close(descriptor)
