"""The wheel, installed outside the checkout: its files, the commands, the examples and the catalog as tests."""

import json
import shutil
import subprocess
import sys
import tarfile
import venv
import zipfile
from pathlib import Path

import pytest
from support.installed import FOLDERS, INSTALLED, copy_kernels, run_checked
from support.paths import EXAMPLES, ROOT

from luxloop import kernel_folder
from luxloop.scenarios.cli import main
from luxloop.scenarios.run import run_folder

pytestmark = pytest.mark.slow

MINE = """\
from luxloop.tracker.tracker import Tracker
class MyTracker(Tracker): ...
"""


@pytest.fixture(scope="module")
def wheel(tmp_path_factory):
    """A wheel of the checkout."""
    return wheel_of(ROOT, tmp_path_factory.mktemp("dist"))


def wheel_of(source: Path, folder: Path) -> Path:
    """Build a wheel of a source tree or archive without network, and return its path."""
    options = ["--no-deps", "--no-build-isolation", "--wheel-dir", str(folder)]
    run_checked([sys.executable, "-m", "pip", "wheel", str(source), *options], folder)
    (built,) = folder.glob("luxloop-*.whl")
    return built


@pytest.fixture(scope="module")
def binaries(wheel, tmp_path_factory):
    """Programs of a new virtual environment: the wheel, and the installed packages without the editable checkout."""
    here = installed(wheel, tmp_path_factory.mktemp("venv"))
    copy_kernels(here)
    return here.parents[2] / "bin"


def installed(wheel: Path, folder: Path) -> Path:
    """Install a wheel in a new virtual environment, and return the folder of its packages."""
    venv.create(folder, with_pip=False)
    python = folder / "bin" / "python"
    (here,) = folder.glob("lib/python*/site-packages")
    assert list(here.iterdir()) == []
    run_checked([sys.executable, "-m", "pip", "--python", str(python), "install", "--no-deps", str(wheel)], folder)
    metadata = f"{wheel.name.partition('-py3')[0]}.dist-info"
    assert {path.name for path in here.iterdir()} == {"luxloop", metadata}
    # A folder that is named in a .pth file is searched last, and .pth files in it are not read.
    (here / "installed.pth").write_text(INSTALLED.replace(":", "\n") + "\n", encoding="utf-8")
    return here


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


def test_a_wheel_of_the_source_archive_has_the_same_files(wheel, tmp_path):
    """The folders in `luxloop/` are links in the checkout, and folders in the archive."""
    program = "import sys, hatchling.build; hatchling.build.build_sdist(sys.argv[1])"
    run_checked([sys.executable, "-c", program, str(tmp_path)], ROOT)
    (archive,) = tmp_path.glob("luxloop-*.tar.gz")
    with tarfile.open(archive) as packed:
        assert not any(member.issym() or member.islnk() for member in packed)
    again = wheel_of(archive, tmp_path)
    first, second = (zipfile.ZipFile(path) for path in (wheel, again))
    assert set(first.namelist()) == set(second.namelist())
    own = [name for name in first.namelist() if name.startswith("luxloop/")]
    assert all(first.read(name) == second.read(name) for name in own)


RUN = ["run", "ring", "--duration", "2", "--no-recording", "--no-ahead", "--out", "ran"]
COUNTED = f"""\
from luxloop.scenarios.cli import main
from luxloop.scenarios.run.warm_up import compilation_reported
compiled = []
with compilation_reported(compiled.append):
    main({RUN})
print(len(compiled), "compiled")
"""


@pytest.mark.skipif(not kernel_folder._flags() >= kernel_folder.FLAGS, reason="an older processor")
def test_a_wheel_with_kernels_runs_without_compiling_and_gives_the_same_trace(wheel, tmp_path, monkeypatch):
    with_kernels = Path(shutil.copy(wheel, tmp_path))
    run_checked([sys.executable, str(ROOT / ".ci" / "wheel_kernels.py"), str(with_kernels)], ROOT, PYTHONPATH=str(ROOT))
    with zipfile.ZipFile(with_kernels) as packed:
        (record,) = [name for name in packed.namelist() if name.endswith(".dist-info/RECORD")]
        assert [line.split(",")[0] for line in packed.read(record).decode().splitlines()] == packed.namelist()
    here = installed(with_kernels, tmp_path / "venv")
    said = run_checked([str(here.parents[2] / "bin" / "python"), "-c", COUNTED], tmp_path)
    assert said.endswith("\n0 compiled\n")
    monkeypatch.chdir(tmp_path)
    main([*RUN[:-1], "checkout"])
    assert run_folder.read(Path("ran")).trace_hash == run_folder.read(Path("checkout")).trace_hash


def test_the_commands_run_outside_the_checkout(binaries, folder):
    luxloop = str(binaries / "luxloop")
    where = run_checked([str(binaries / "python"), "-c", "import luxloop; print(luxloop.__file__)"], folder)
    assert where.startswith(str(binaries.parent))
    assert run_checked([luxloop, "--version"], folder).startswith("luxloop ")
    assert "ring " in run_checked([luxloop, "list"], folder)
    assert "PASSED" in run_checked([luxloop, "run", "ring"], folder)
    run_checked([luxloop, "report", "runs/ring-seed1"], folder)
    assert (folder / "runs" / "ring-seed1.html").stat().st_size > 10_000
    run_checked([luxloop, "new", "roundabout-v0", "--out", "mine.toml", "--duration", "5"], folder)
    assert (folder / "mine.toml").is_file()
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


def test_pytest_runs_in_a_folder_with_packages_of_the_same_names(binaries, folder):
    """pytest's plug-in must not be looked for in the user's `scenarios`."""
    (folder / "cases").mkdir()
    shutil.copy(EXAMPLES / "my-first.toml", folder / "cases")
    options = ["cases", "-q", "-p", "no:cacheprovider", "--luxloop-tracker", "tracker/mine.py:MyTracker"]
    assert "passed" in run_checked([str(binaries / "python"), "-m", "pytest", *options], folder)
