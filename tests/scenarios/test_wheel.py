"""The wheel, installed outside the checkout: its files, the commands, the examples and the catalog as tests."""

import json
import os
import shutil
import subprocess
import sys
import sysconfig
import venv
import zipfile
from pathlib import Path

import pytest

pytestmark = pytest.mark.slow

ROOT = Path(__file__).parents[2]
FOLDERS = ("scenarios", "sensor_model", "sim", "tracker")
EXAMPLES = ROOT / "docs" / "examples"
MINE = """\
from luxloop.tracker.tracker import Tracker
class MyTracker(Tracker): ...
"""


@pytest.fixture(scope="module")
def wheel(tmp_path_factory):
    """A wheel of the checkout, built without network."""
    folder = tmp_path_factory.mktemp("dist")
    options = ["--no-deps", "--no-index", "--no-build-isolation", "--wheel-dir", str(folder)]
    run_checked([sys.executable, "-m", "pip", "wheel", str(ROOT), *options], folder)
    (built,) = folder.glob("luxloop-*.whl")
    return built


@pytest.fixture(scope="module")
def binaries(wheel, tmp_path_factory):
    """Programs of a new virtual environment: the wheel, and the installed packages without the editable checkout."""
    folder = tmp_path_factory.mktemp("venv")
    venv.create(folder, with_pip=False)
    python = folder / "bin" / "python"
    options = ["--no-deps", "--no-index", str(wheel)]
    run_checked([sys.executable, "-m", "pip", "--python", str(python), "install", *options], folder)
    # A folder that is named in a .pth file is searched last, and .pth files in it are not read.
    installed = {sysconfig.get_path("purelib"), sysconfig.get_path("platlib")}
    (here,) = folder.glob("lib/python*/site-packages")
    (here / "installed.pth").write_text("\n".join(installed) + "\n", encoding="utf-8")
    return python.parent


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A user's folder, with subfolders named like luxloop's packages."""
    folder = tmp_path_factory.mktemp("user")
    for name in FOLDERS:
        (folder / name).mkdir()
        (folder / name / "__init__.py").write_text("raise AssertionError('not the package of luxloop')")
    (folder / "tracker" / "mine.py").write_text(MINE)
    shutil.copytree(EXAMPLES, folder / "examples", ignore=shutil.ignore_patterns("__pycache__"))
    return folder


def run_checked(command: list[str], folder: Path) -> str:
    """Run a command in a folder, without the Python path of the tests; return its standard output."""
    environment = {name: value for name, value in os.environ.items() if not name.startswith(("PYTEST_", "PYTHON"))}
    run = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, check=False)
    assert run.returncode == 0, f"{command}\n{run.stdout}\n{run.stderr}"
    return run.stdout


def test_the_wheel_has_every_file_of_the_packages(wheel):
    listed = subprocess.run(
        ["git", "ls-files", "luxloop", *FOLDERS], cwd=ROOT, capture_output=True, text=True, check=False
    )
    if listed.returncode:
        pytest.skip("not a git checkout")
    packed = set(zipfile.ZipFile(wheel).namelist())
    files = {name for name in listed.stdout.splitlines() if (ROOT / name).is_file()}
    expected = {name if name.startswith("luxloop/") else f"luxloop/{name}" for name in files}
    assert {name for name in packed if name.startswith("luxloop/")} == expected
    assert {name.partition("/")[0].partition("-")[0] for name in packed} == {"luxloop"}


def test_the_commands_run_outside_the_checkout(binaries, folder):
    luxloop = str(binaries / "luxloop")
    where = run_checked([str(binaries / "python"), "-c", "import luxloop; print(luxloop.__file__)"], folder)
    assert where.startswith(str(binaries.parent))
    assert run_checked([luxloop, "--version"], folder).startswith("luxloop ")
    assert "ring " in run_checked([luxloop, "list"], folder)
    assert "PASSED" in run_checked([luxloop, "run", "ring"], folder)
    run_checked([luxloop, "report", "runs/ring-seed1"], folder)
    assert (folder / "runs" / "ring-seed1.html").stat().st_size > 10_000
    assert json.loads(run_checked([luxloop, "schema"], folder))["title"] == "Scenario"


@pytest.mark.parametrize("tracker", ["tracker/mine.py:MyTracker", "examples/my_tracker.py:PatchTracker"])
def test_the_example_runs_with_a_tracker_from_a_file(binaries, folder, tracker):
    command = [str(binaries / "luxloop"), "run", "examples/my-first.toml", "--out", Path(tracker).stem]
    assert tracker in run_checked([*command, "--tracker", tracker], folder)


def test_the_example_of_the_tracker_alone_runs(binaries, folder):
    command = [str(binaries / "python"), "examples/track_csv.py", "examples/points.csv"]
    assert "confirmed" in run_checked(command, folder)


def test_the_catalog_runs_as_tests(binaries, folder):
    catalog = run_checked([str(binaries / "luxloop"), "list", "--folder"], folder).strip()
    assert catalog.startswith(str(binaries.parent))
    options = ["-m", "full", "-k", "ring-clean", "-q", "-p", "no:cacheprovider"]  # no limit of it is known to fail
    assert "passed" in run_checked([str(binaries / "python"), "-m", "pytest", catalog, *options], folder)
