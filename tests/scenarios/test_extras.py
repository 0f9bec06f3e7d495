"""Extras: commands without their optional packages, and the base installation."""

import subprocess
import sys
import tomllib
from functools import cache
from importlib.metadata import packages_distributions
from importlib.util import find_spec
from pathlib import Path

import pytest
from support import short_run
from support.few import few
from support.optional import need

from luxloop.scenarios.commands.arguments import EXTRAS
from luxloop.sim.optional_packages import install_command

PROJECT = tomllib.loads((Path(__file__).parents[2] / "pyproject.toml").read_text(encoding="utf-8"))["project"]
OPTIONAL = {
    *(package for packages in EXTRAS.values() for package in packages),
    *("commonroad", "pytest", "_pytest", "xdist", "mkdocs", "material", "hypothesis", "trackeval", "cv2", "shapely"),
}
"""Modules that the base dependencies do not install."""
COMMANDS = {
    "sweeps": ["sweep", "occlusion"],
    "search": ["search", "lost-behind-wall"],
    "mcap": ["mcap", "run", "run.mcap"],
    "osi": ["export", "run", "--format", "osi", "--out", "osi"],
    "recordings": ["import", "drive.bag", "--mount", "0,0,1", "--out", "recorded"],
    "league": ["league", "truck-shadow"],
}
REPLAY = """\
description = "A CommonRoad file."
duration_s = 1
[traffic]
kind = "replay"
file = "a.xml"
ego = "1"
"""


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


def luxloop(absent: set[str], *commands: list[str]) -> subprocess.CompletedProcess[str]:
    """Run commands in one process in which some packages cannot be imported; exit with the last one's code."""
    code = f"""
import sys
sys.modules.update(dict.fromkeys({sorted(absent)}))
from luxloop.scenarios.cli import main
codes = [main(command) for command in {[*commands]!r}]
sys.exit(max(codes))
"""
    return subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)


@pytest.mark.parametrize(
    ("extra", "absent"), few([(extra, name) for extra in COMMANDS for name in EXTRAS[extra]], "mcap")
)
def test_a_command_names_the_extra_that_it_needs(folder, extra, absent):
    run = luxloop({absent}, COMMANDS[extra])
    first = next(name for name in EXTRAS[extra] if name == absent or find_spec(name) is None)
    missing = f"luxloop {COMMANDS[extra][0]} needs {first}, which is not installed"
    line = f"luxloop: error: {missing}: {install_command(extra)}\n"
    assert (run.returncode, run.stdout, run.stderr) == (2, "", line)
    assert list(folder.iterdir()) == []


def test_a_commonroad_file_names_the_extra_that_it_needs(folder):
    (folder / "a.toml").write_text(REPLAY)
    (folder / "a.xml").write_text("<commonRoad/>")
    run = luxloop({"commonroad"}, ["run", "a.toml", "--no-ahead"])  # a traffic process has the package
    assert (run.returncode, run.stdout) == (2, "")
    assert run.stderr.startswith("luxloop: error: a.toml: traffic: ")
    assert f"which is not installed: {install_command('commonroad')}" in run.stderr
    assert run.stderr.count("\n") == 1


@pytest.mark.slow
def test_the_base_installation_runs_grades_reports_and_compares(folder):
    short_run.write(folder)
    run = luxloop(
        OPTIONAL,
        ["--version"],
        ["list"],
        ["list", "--studies"],
        ["schema", "--study"],
        ["run", "short.toml", "--out", "run", "--record-scans"],
        ["grade", "run", "--tracker", "luxloop.tracker.tracker:Tracker"],
        ["report", "run"],
        ["compare", "run", "run"],
        ["baseline", "run", "--out", "base.jsonl"],
    )
    assert (run.returncode, run.stderr) == (0, "")
    assert (folder / "run.html").is_file()


@pytest.mark.slow
def test_a_scripted_run_without_recording_needs_no_viewer_and_no_simulator(folder):
    short_run.write(folder)
    run = luxloop(
        {"rerun", "libsumo", "traci", "highway_env", "gymnasium", "pygame", "matplotlib"},
        ["list"],
        ["run", "short.toml", "--out", "run", "--no-recording", "--record-scans"],
        ["grade", "run", "--tracker", "luxloop.tracker.tracker:Tracker"],
    )
    assert (run.returncode, run.stderr) == (0, "")
    assert not list(folder.glob("run/*.rrd"))


distributions = cache(packages_distributions)


@pytest.mark.parametrize("extra", EXTRAS)
def test_the_checked_packages_are_those_of_the_extra(extra):
    need(extra)
    listed = PROJECT["optional-dependencies"][extra]
    if extra == "search":
        assert listed[0] == "luxloop[sweeps]"
        listed = [*PROJECT["optional-dependencies"]["sweeps"], *listed[1:]]
    installed_by = distributions()
    assert [requirement.partition(">=")[0] for requirement in listed] == [
        installed_by[package][0].replace("_", "-") for package in EXTRAS[extra]
    ]


def test_version_names_luxloop_first_and_every_package_that_can_change_a_result():
    run = luxloop(set(), ["--version"])
    lines = run.stdout.splitlines()
    assert lines[0] == f"luxloop {PROJECT['version']}"
    assert [line.split()[0] for line in lines[1:3]] == ["python", "numpy"]
    assert {"numba", "scipy", "filterpy", "libsumo", "highway-env"} <= {line.split()[0] for line in lines}
