"""Progress of the start: the share of a file that has been read, and a line in a log about a long silence."""

import time

import pytest
from numba import njit

from luxloop.scenarios.run import progress
from luxloop.scenarios.run.progress_bars import _share_read
from luxloop.scenarios.run.warm_up import STATUS, compilation_reported
from luxloop.sim.source import StartStatus


def test_the_share_of_a_file_is_the_position_in_it(tmp_path):
    net = tmp_path / "city.net.xml"
    net.write_bytes(bytes(1_000_000))
    status = StartStatus("SUMO loads it", file=str(net))

    assert _share_read(status) is None  # not open yet
    with net.open("rb", buffering=0) as stream:
        stream.read(250_000)
        assert _share_read(status) == pytest.approx(0.25)


def wait_for_start(activities):
    """Start a run that reports each activity for its time [s]."""
    with progress.start("city") as report:
        for activity, last_s in activities:
            until = time.monotonic() + last_s
            while time.monotonic() < until:
                report(StartStatus(activity))
                time.sleep(0.01)


def test_a_log_has_one_line_about_each_long_activity(monkeypatch, capfd):
    monkeypatch.setattr(progress, "SILENCE_S", 0.2)
    wait_for_start([("SUMO loads city.net.xml", 0.6), ("short", 0.0), ("compiling", 0.6)])
    assert capfd.readouterr() == ("", "luxloop: city: SUMO loads city.net.xml\nluxloop: city: compiling\n")


def test_short_starts_and_quiet_ones_print_nothing(monkeypatch, capfd):
    wait_for_start([("SUMO loads city.net.xml", 0.05)])
    monkeypatch.setattr(progress, "SILENCE_S", 0.01)
    with progress.hidden():
        wait_for_start([("SUMO loads city.net.xml", 0.1)])
    assert capfd.readouterr() == ("", "")


def test_only_compilations_are_reported_and_calls_of_compiled_kernels_are_not():
    found = []

    @njit
    def plus_one(x):
        return x + 1

    with compilation_reported(found.append):
        plus_one(1)
        assert set(found) == {STATUS}
        count = len(found)
        plus_one(2)
    plus_one(1.0)
    assert len(found) == count
