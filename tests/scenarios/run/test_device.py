"""Loading the device under test: modules, files, folders with the names of luxloop's packages, and errors."""

import os
import subprocess
import sys
from pathlib import Path

import pytest
from support import short_run
from support.optional import need_for
from support.paths import without_checkouts

from luxloop import former_names
from luxloop.scenarios.errors import DeviceError
from luxloop.scenarios.run import device
from luxloop.tracker.tracker import Tracker, TrackerConfig

MINE = """\
from luxloop.tracker.tracker import Tracker

import my_helper

class MyTracker(Tracker):
    note = my_helper.NOTE
"""


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    """A current folder of the test's own, and the Python path and the imported modules as before afterwards.

    No checkout, whose folders have the former names of luxloop's packages, is on the path.
    """
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "path", without_checkouts(sys.path))
    yield tmp_path
    for name in ("mine", "my_helper"):
        sys.modules.pop(name, None)


@pytest.mark.parametrize(
    ("spec", "message"),
    [
        ("luxloop.tracker.tracker", "should be MODULE:NAME or FILE.py:NAME"),
        (":Tracker", "should be MODULE:NAME or FILE.py:NAME"),
        (".tracker:Tracker", "should be MODULE:NAME or FILE.py:NAME"),
        ("nowhere.tracker:Tracker", "no module nowhere on the Python path or in .*[^E]$"),
        ("tracker.tracker:Tracker", r"no module tracker[ .].*; luxloop's module is luxloop\.tracker\.tracker now"),
        ("luxloop.tracker.tracker:Trucker", r"Trucker is not there in luxloop\.tracker\.tracker"),
        ("luxloop.tracker.records:MODELS", "MODELS is not callable"),
        ("nowhere.py:Tracker", r"no file nowhere\.py; give the path of a Python file"),
        ("mine.py:Trucker", r"Trucker is not there in mine\.py; name a class with step"),
        ("mine.py:", "should be MODULE:NAME or FILE.py:NAME"),
    ],
)
def test_a_tracker_that_cannot_be_loaded_is_bad_input(folder, spec, message):
    (folder / "mine.py").write_text("class MyTracker: ...")
    with pytest.raises(DeviceError, match=f"--tracker {spec.replace('.', '[.]')}: .*{message}"):
        device.load(spec)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("import nowhere_to_be_found", "mine.py, line 1: ModuleNotFoundError: No module named 'nowhere_to_be_found'"),
        ("\n\nclass MyTracker(:\n", "mine.py, line 3: SyntaxError: invalid syntax"),
        ("import numpy\n\nnumpy.zeros(-1)", "mine.py, line 3: ValueError: negative dimensions are not allowed"),
        ("import json\njson.loads('{')", "mine.py, line 2: JSONDecodeError: "),
        ("import sys\nsys.exit(1)", "mine.py, line 2: SystemExit: 1"),
        ("import broken_helper", "broken_helper.py, line 2: ZeroDivisionError: division by zero"),
        ("raise ValueError('two\\n lines')", "mine.py, line 1: ValueError: two lines"),
    ],
)
@pytest.mark.parametrize("spec", ["mine.py:MyTracker", "mine:MyTracker"])
def test_an_error_in_the_users_file_is_one_line_with_file_and_line(folder, monkeypatch, spec, text, message):
    (folder / "mine.py").write_text(text)
    (folder / "broken_helper.py").write_text("# on the second line\n1 / 0\n")
    monkeypatch.delitem(sys.modules, "mine", raising=False)
    with pytest.raises(DeviceError) as error:
        device.load(spec)
    assert f"--tracker {spec}: {folder}/{message}" in str(error.value)
    assert "\n" not in str(error.value)
    assert "mine" not in sys.modules


@pytest.mark.parametrize(
    ("missing", "wanted", "named"),
    [
        ("sim", "sim.highway.motorist", "luxloop.sim.highway.motorist"),
        ("sim.world", "", "luxloop.sim.world"),
        ("tracker", "mine", "luxloop.tracker"),
        ("simulation", "simulation.world", None),
        ("numpy", "", None),
    ],
)
def test_a_former_name_of_a_module_has_the_new_one_as_its_remedy(missing, wanted, named):
    error = ModuleNotFoundError(name=missing)
    assert former_names.remedy(error, wanted) == (f"; luxloop's module is {named} now" if named else "")
    assert former_names.remedy(ImportError(name=missing), wanted) == ""


def test_a_file_is_loaded_once_in_this_process(folder):
    (folder / "deep").mkdir()
    (folder / "deep" / "mine.py").write_text(MINE)
    (folder / "deep" / "my_helper.py").write_text("NOTE = 'beside the file'")
    made = device.load("deep/mine.py:MyTracker", in_process=True)
    assert made.note == "beside the file"
    assert device.load(f"{folder}/deep/mine.py:MyTracker", in_process=True) is made
    assert isinstance(made(TrackerConfig()), Tracker)
    assert device.is_in_process(made)


def test_a_file_names_its_device_and_runs_in_a_process_of_its_own(folder):
    (folder / "deep").mkdir()
    (folder / "deep" / "mine.py").write_text(MINE)
    (folder / "deep" / "my_helper.py").write_text("NOTE = 'beside the file'")
    made = device.load(f"{folder}/deep/mine.py:MyTracker")
    assert device.name_of(made) == "deep/mine.py:MyTracker"
    assert not device.is_in_process(made)
    assert "my_helper" not in sys.modules


def test_files_of_one_name_are_different_modules(folder):
    for place in ("a", "b"):
        (folder / place).mkdir()
        (folder / place / "mine.py").write_text(f"class MyTracker:\n    place = '{place}'")
    assert [device.load(f"{place}/mine.py:MyTracker", in_process=True).place for place in ("a", "b")] == ["a", "b"]


def test_a_path_is_absolute_for_workers_and_a_module_is_unchanged(folder):
    assert device.absolute("deep/mine.py:MyTracker") == f"{folder}/deep/mine.py:MyTracker"
    assert device.absolute(device.SHIPPED) == device.SHIPPED


def test_the_current_folder_does_not_hide_installed_packages(folder):
    """Packages that are imported later, such as `rerun`, must not come from the user's folder."""
    (folder / "mine.py").write_text("class MyTracker: ...")
    (folder / "colorsys.py").write_text("raise AssertionError")
    sys.modules.pop("colorsys", None)
    device.load("mine:MyTracker", in_process=True)
    device.load("mine.py:MyTracker", in_process=True)
    import colorsys

    assert Path(colorsys.__file__).parent != folder


STUDY = """\
description = "Two seeds."
scenario = "short.toml"
seeds = 2
[fixed]
duration_s = 0.1
[[vary]]
key = "noise.dropout.random_rate"
values = [0.1]
"""
COMMANDS = {
    "run": ["-m", "luxloop", "run", "short.toml", "--no-recording", "--out", "ran"],
    "grade": ["-m", "luxloop", "run", "short.toml", "--no-recording", "--record-scans", "--out", "ran"],
    "check": ["-m", "luxloop", "check-tracker"],
    "sweep": ["-m", "luxloop", "sweep", "study.toml", "--workers", "1", "--out", "swept"],
    "pytest": ["-m", "pytest", "short.toml", "-q", "-p", "no:cacheprovider"],
    "xdist": ["-m", "pytest", "short.toml", "-q", "-p", "no:cacheprovider", "-n", "1"],
}


@pytest.fixture
def hostile(folder):
    """A folder with packages and subfolders named like luxloop's, which `python -m` puts first on the path."""
    for name in ("tracker", "sim", "sensor_model"):
        (folder / name).mkdir()
        (folder / name / "__init__.py").write_text("raise AssertionError('not the package of luxloop')")
    (folder / "scenarios").mkdir()
    (folder / "tracker" / "sim").mkdir()
    (folder / "tracker" / "mine.py").write_text(MINE)
    (folder / "tracker" / "my_helper.py").write_text("NOTE = ''")
    (folder / "conftest.py").write_text("")
    (folder / "pytest.ini").write_text("[pytest]\n")
    (folder / "study.toml").write_text(STUDY)
    short_run.write(folder)
    return folder


def python(*arguments: str) -> subprocess.CompletedProcess[str]:
    """Run Python in the current folder, with luxloop last on its path."""
    environment = {name: value for name, value in os.environ.items() if not name.startswith("PYTEST_")}
    environment["PYTHONPATH"] = str(Path(device.__file__).parents[2])
    return subprocess.run([sys.executable, *arguments], env=environment, capture_output=True, text=True, check=False)


@pytest.mark.usefixtures("hostile")
@pytest.mark.parametrize(
    "command", ["run", *(pytest.param(name, marks=pytest.mark.slow) for name in COMMANDS if name != "run")]
)
def test_luxloops_packages_win_over_folders_of_the_same_name(command):
    need_for(command)
    option = {"check": (), "pytest": ("--luxloop-tracker",), "xdist": ("--luxloop-tracker",)}.get(
        command, ("--tracker",)
    )
    run = python(*COMMANDS[command], *option, "tracker/mine.py:MyTracker")
    assert run.returncode == 0, run.stdout + run.stderr
    if command == "grade":
        grade = python("-m", "luxloop", "grade", "ran", "--tracker", "tracker/mine.py:MyTracker", "--json")
        assert (grade.returncode, grade.stderr) == (0, "")


@pytest.mark.slow
def test_a_folder_that_is_itself_called_tracker(hostile, monkeypatch):
    monkeypatch.chdir(hostile / "tracker")
    run = python("-m", "luxloop", "run", "../short.toml", "--no-recording", "--tracker", "mine.py:MyTracker")
    assert run.returncode == 0, run.stdout + run.stderr
    assert "mine.py:MyTracker" in run.stdout
