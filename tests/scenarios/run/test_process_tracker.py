"""Trackers in their own process: the examples of the documentation, and programs that break the protocol."""

import json
import shutil
import subprocess
import sys

import pytest
from support import short_run
from support.few import few
from support.paths import EXAMPLES, ROOT

from luxloop.scenarios.cli import main
from luxloop.scenarios.run import child_process, process_tracker

ROGUE = ROOT / "tests" / "support" / "rogue_process.py"
FAULTS = {
    "no greeting": "warm-up, start: ended with exit code 0",
    "wrong greeting": "warm-up, start: answered b'Hello!!!' instead of b'LUXLOOP1'; print to standard error only",
    "reads nothing": "took more than",
    "exit 0": "frame 4 at 0.32 s: ended with exit code 0",
    "exit 3": "frame 4 at 0.32 s: ended with exit code 3",
    "crash": "frame 4 at 0.32 s: ended by signal SIGSEGV",
    "hang": "frame 4 at 0.32 s: took more than 0.3 s",
    "print": "frame 4 at 0.32 s: answered 1835102822 bytes; does it print to standard output?",
    "wrong frame": "frame 4 at 0.32 s: answered to frame 5",
    "wrong length": "frame 4 at 0.32 s: answered 73 bytes for 2 tracks",
    "answers twice": "frame 5 at 0.40 s: answered ",
    "nan": "frame 4 at 0.32 s: track 1: mean is not finite (position, heading)",
    "children": "frame 4 at 0.32 s: took more than 0.3 s",
    "exit 5 at the end": "warm-up, frame 2 at 0.16 s: ended with exit code 5",
    "stays": "was still running",
}
"""Part of the line by fault; the exit code is 4. "fram" as a number is 1835102822."""
QUICK = ("no greeting", "exit 0", "crash", "hang", "print", "wrong length", "nan", "stays")
"""Faults of `make test`, one of each kind."""


@pytest.fixture
def folder(tmp_path, monkeypatch):
    (tmp_path / "here").mkdir()
    monkeypatch.chdir(tmp_path / "here")
    short_run.write(tmp_path / "here")
    return tmp_path / "here"


def document(capfd, *arguments):
    """Return the JSON document of a command that succeeds."""
    assert main([*arguments, "--json"]) == 0
    return json.loads(capfd.readouterr().out)


def figures(document):
    """Return the metrics that are not times."""
    return {k: v for k, v in document["metrics"].items() if not k.startswith("perf.") and k != "control"}


def sleepers():
    """Return the command lines of all processes that name the child's odd number of seconds."""
    listing = subprocess.run(["ps", "-eo", "args"], capture_output=True, text=True, check=True).stdout
    return [line for line in listing.splitlines() if line == "sleep 1000.125"]


@pytest.mark.parametrize("fault", few(FAULTS, *QUICK))
def test_a_broken_protocol_is_one_line_with_exit_code_4(fault, folder, capfd, monkeypatch):
    if fault == "stays":
        monkeypatch.setattr(child_process, "END_S", 0.3)
    hangs = "took more than" in FAULTS[fault]
    spec = f"process:{sys.executable} {ROGUE} '{fault}'"
    command = ["run", "short.toml", "--tracker", spec, "--no-recording", "--json", "--out", "ran"]
    assert main([*command, "--step-timeout", "0.3" if hangs else "20"]) == 4
    out, err = capfd.readouterr()
    assert (out, err.count("\n")) == ("", 1)
    assert err.startswith("luxloop: error: process:")
    assert FAULTS[fault] in err
    assert [path.name for path in folder.iterdir()] == ["short.toml"]
    assert sleepers() == []


@pytest.mark.usefixtures("folder")
@pytest.mark.parametrize(
    ("spec", "message"),
    [("process:", "no program"), ("process:./nowhere", "no program ['./nowhere']"), ("process:'", "No closing quot")],
)
def test_a_command_that_cannot_be_started_is_bad_input(spec, message, capfd):
    assert main(["run", "short.toml", "--tracker", spec]) == 2
    assert message in capfd.readouterr().err


def test_an_import_that_does_not_end_is_one_line_and_its_process_ends(folder, capfd, monkeypatch):
    monkeypatch.setattr(process_tracker, "IMPORT_TIMEOUT_S", 0.5)
    (folder / "slow.py").write_text('import subprocess\nsubprocess.run(["sleep", "1000.125"])\n', encoding="utf-8")
    assert main(["run", "short.toml", "--tracker", "slow.py:Tracker"]) == 2
    said = "--tracker slow.py:Tracker: its import took more than 0.5 s; leave slow work to its start"
    assert capfd.readouterr() == ("", f"luxloop: error: {said}\n")
    assert sleepers() == []


@pytest.mark.usefixtures("folder")
def test_the_python_example_gives_the_tracks_of_its_class_in_the_loop(capfd):
    options = ["run", "short.toml", "--no-recording", "--tracker"]
    apart = document(capfd, *options, f"process:{sys.executable} {EXAMPLES / 'process' / 'nearest_process.py'}")
    inside = document(capfd, *options, f"{EXAMPLES / 'ci/my_tracker.py'}:Nearest", "--in-process")
    assert apart["trace_hash"] == inside["trace_hash"]
    assert figures(apart) == figures(inside)
    assert apart["metrics"]["track.hota"]["value"] > 0.1


@pytest.mark.slow
@pytest.mark.skipif(shutil.which("g++") is None, reason="needs g++")
def test_the_cpp_example_gives_the_same_tracks_in_the_loop_and_by_csv(folder, capfd):
    source = str(EXAMPLES / "process" / "nearest.cpp")
    subprocess.run(["g++", "-O2", "-Wall", "-Wextra", "-Werror", "-o", "nearest", source], check=True)
    options = ["--no-recording", "--record-scans", "--out", "ran"]
    live = document(
        capfd,
        "run",
        "short.toml",
        "--tracker",
        "process:./nearest $PWD/tracks.csv".replace("$PWD", str(folder)),
        *options,
    )
    graded = document(capfd, "grade", "ran", "--tracks", "tracks.csv")
    assert graded["trace_hash"] == live["trace_hash"]
    assert live["metrics"]["track.hota"]["value"] > 0.1
    for name, metric in figures(live).items():
        assert graded["metrics"][name]["value"] == metric["value"], name
