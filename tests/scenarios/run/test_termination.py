"""Signals whose KeyboardInterrupt is lost before it reaches luxloop."""

import signal
from pathlib import Path

import numpy as np
import pytest
from support import short_run

from scenarios.cli import main
from scenarios.recording.recorder import NullRecorder


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
