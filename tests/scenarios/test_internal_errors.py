"""Defects of luxloop end with exit code 70, a traceback and one line, in every process and before every import."""

import json
import signal
import subprocess
import sys
from pathlib import Path

import pytest
from support import crossing_ids, short_run
from support.breaking_traffic import break_at
from support.dask_cluster import worker_thread
from support.defective_drive import DefectiveDrive
from support.few import few
from support.optional import need
from support.sweeps import rows, small_study, sweep

from luxloop.scenarios.cli import main
from luxloop.scenarios.files import shipped
from luxloop.scenarios.league import drive

REPORT = "report it with the traceback above, the command, and the output of luxloop --version (luxloop "
ZERO = "internal error (ZeroDivisionError planted): this is a defect of luxloop: " + REPORT
DEFECT = """\
from luxloop.scenarios.grading.grader import Grader

def fail(*_):
    raise ZeroDivisionError("planted")

Grader.add = fail
"""
"""A module that plants a defect into the grader of each process that imports it at its start, as Python does."""


@pytest.fixture(autouse=True)
def _in_a_folder_of_its_own(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)


@pytest.fixture
def _defect(monkeypatch):
    """Plant a defect into the grader of this process."""

    def fail(*_):
        raise ZeroDivisionError("planted")

    monkeypatch.setattr("luxloop.scenarios.grading.grader.Grader.add", fail)


@pytest.mark.parametrize(
    ("option", "line"),
    [
        ("--no-ahead", ZERO),
        ("--ahead", "internal error (RuntimeError ZeroDivisionError in the traffic process: planted"),
    ],
)
def test_a_run_ends_with_70_its_traceback_and_one_line_and_writes_nothing(option, line, monkeypatch, capfd):
    break_at(3, ZeroDivisionError("planted"), monkeypatch)
    short_run.write(Path())
    assert main(["run", "short.toml", option]) == 70
    out, err = capfd.readouterr()
    *trace, last = err.splitlines()
    assert out == ""
    assert trace[0] == "Traceback (most recent call last):"
    assert any("breaking_traffic.py" in entry for entry in trace)
    assert last.startswith(f"luxloop: error: {line}")
    assert [path.name for path in Path().iterdir()] == ["short.toml"]


@pytest.mark.parametrize(
    ("missing", "arguments"),
    few([("typer", ["list"]), ("numpy", ["run", "ring"]), ("jinja2", ["report", "run"])], "typer"),
)
def test_a_damaged_installation_ends_with_70(missing, arguments):
    """Typer is imported first of all, numpy by the code that explains errors, jinja2 within a command."""
    code = f"import sys; sys.modules[{missing!r}] = None; from luxloop.__main__ import main; sys.exit(main())"
    ended = subprocess.run([sys.executable, "-c", code, *arguments], capture_output=True, text=True, check=False)
    assert (ended.returncode, ended.stdout) == (70, "")
    *trace, last = ended.stderr.splitlines()
    assert trace[0] == "Traceback (most recent call last):"
    assert last.startswith(f"luxloop: error: internal error (ModuleNotFoundError import of {missing}")
    assert "the installation is damaged, or this is a defect of luxloop; install it again, else report it" in last


def test_no_library_chooses_the_exit_code(monkeypatch, capfd):
    def leave(*_, **__):
        sys.exit(1)

    monkeypatch.setattr("luxloop.scenarios.execute.execute", leave)
    short_run.write(Path())
    assert main(["run", "short.toml"]) == 70
    assert "luxloop: error: internal error (SystemExit 1)" in capfd.readouterr().err


def test_output_that_nobody_reads_is_no_error():
    command = [sys.executable, "-m", "luxloop", "schema"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as process:
        process.stdout.close()
        assert process.stderr.read() == b""
    assert process.returncode == 128 + signal.SIGPIPE


@pytest.mark.usefixtures("_defect")
def test_a_sweep_keeps_the_rows_and_ends_with_70(tmp_path, capfd):
    study = small_study(tmp_path)
    with worker_thread() as scheduler:
        assert main(["sweep", study.name, "--out", "out", "--scheduler", scheduler, "--json"]) == 70
    out, err = capfd.readouterr()
    document = json.loads(out)
    assert document["status"] == {"error": 8}
    (error,) = document["errors"]
    assert error.startswith("internal error: ZeroDivisionError: planted (test_internal_errors.py:")
    assert err.count("Traceback (most recent call last):") == 1  # one of eight equal ones
    assert err.splitlines()[-1].startswith(f"luxloop: error: runs ended with an {error}; this is a defect of luxloop: ")


@pytest.mark.slow
def test_worker_processes_of_a_sweep_print_the_traceback(tmp_path, monkeypatch):
    study = small_study(tmp_path)
    (tmp_path / "planted").mkdir()
    (tmp_path / "planted" / "sitecustomize.py").write_text(DEFECT)
    monkeypatch.syspath_prepend(tmp_path / "planted")
    code, _, err = sweep(study, "--workers", "2")
    assert code == 70
    assert err.startswith("Traceback (most recent call last):")
    assert REPORT in err.splitlines()[-1]
    assert all(error.startswith("internal error: ZeroDivisionError") for error in rows(study)["error"])


@pytest.mark.usefixtures("_defect")
def test_a_search_ends_with_70_if_the_undisturbed_run_does(tmp_path, capfd):
    need("search")
    study = crossing_ids.write(tmp_path)
    command = ["search", str(study), "--tracker", crossing_ids.SPEC, "--out", "out", "--workers", "1"]
    assert main(command) == 70
    assert "with nothing disturbed: internal error: ZeroDivisionError" in capfd.readouterr().err


@pytest.mark.parametrize(
    ("kind", "duration", "workers", "place", "error"),
    [
        (drive.Drive, "8.0", "1", "in carry_out", "TypeError "),
        pytest.param(DefectiveDrive, 8.0, "2", "in recorded_scans", ZERO, marks=pytest.mark.slow),
    ],
    ids=["command", "worker"],
)
def test_a_league_ends_with_70_also_by_its_worker_processes(
    kind, duration, workers, place, error, tmp_path, monkeypatch, capfd
):
    """The command fails by a duration that is text, which no option gives."""
    need("league")
    ring = str(shipped.find("ring"))
    broken = [kind(ring, seed, duration, ("shipped",), tmp_path / "league") for seed in range(2)]
    monkeypatch.setattr(drive, "drives", lambda *_: broken)
    assert main(["league", "ring", "--workers", workers, "--quiet"]) == 70
    err = capfd.readouterr().err
    assert place in err
    assert error in err.splitlines()[-1]
