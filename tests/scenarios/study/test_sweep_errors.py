"""A failed run is a row with its error; an error of all runs ends the sweep with a one-line message."""

import json
from pathlib import Path

import pytest
from support.dask_cluster import worker_thread
from support.optional import need
from support.sweeps import rows, small_study, sweep

from luxloop.scenarios.cli import main
from luxloop.scenarios.errors import InputError, OutputError, StudyError
from luxloop.scenarios.run import device
from luxloop.scenarios.run.versions import installed
from luxloop.scenarios.study import worker
from luxloop.scenarios.study.design import runs
from luxloop.scenarios.study.study_file import Study
from luxloop.scenarios.study.worker import carry_out

TRACKER = """\
import os, signal
from luxloop.tracker.tracker import Tracker

def failing(config):
    if config.segmentation.points_min == 4:
        raise RuntimeError("four is\\ntoo many")
    if config.segmentation.points_min == 5:  # kills the worker, the parent of the tracker's parent
        with open(f"/proc/{os.getppid()}/stat") as stat:
            os.kill(int(stat.read().rpartition(")")[2].split()[1]), signal.SIGKILL)
    return Tracker(config)
"""

FAILING = """\
description = "A tracker that fails with some settings."
scenario = "short.toml"
fixed = { duration_s = 0.1 }
vary = [{ key = "tracker.segmentation.points_min", values = [%s] }]
"""


@pytest.fixture
def luxloop(tmp_path, monkeypatch, capfd):
    """Return a function that runs `luxloop sweep` in this process; it returns exit code, output and errors."""
    monkeypatch.chdir(tmp_path)

    need("sweeps")

    def run(study: Path, *options: str) -> tuple[int, str, str]:
        code = main(["sweep", study.name, "--out", "out", *options])
        return code, *capfd.readouterr()

    return run


def failing_study(folder: Path, values: str) -> Path:
    study = small_study(folder)
    (folder / "failing_tracker.py").write_text(TRACKER)
    study.write_text(FAILING % values)
    return study


def test_a_run_that_fails_is_a_row_with_its_error(tmp_path: Path, luxloop):
    study = failing_study(tmp_path, "3, 4")
    keep = tmp_path / "kept"
    with worker_thread() as scheduler:
        options = ("--tracker", "failing_tracker.py:failing", "--keep", keep.as_uri(), "--json")
        code, output, error = luxloop(study, "--scheduler", scheduler, *options)
    assert (code, error) == (1, "")
    document = json.loads(output)
    assert document["status"] == {"error": 1, "passed": 1}
    (line,) = document["errors"]
    assert line.startswith("failing_tracker.py:failing: warm-up, start: ")
    assert line.endswith("failing_tracker.py, line 6: raised RuntimeError: four is too many")
    good, bad = rows(study).to_dict("records")
    assert good["trace_hash"]
    assert (bad["status"], bad["trace_hash"], bad["tracker.segmentation.points_min"]) == ("error", "", 4)
    assert (keep / good["key"] / "result.json").is_file()
    assert not (keep / bad["key"]).exists()


@pytest.mark.slow
def test_a_run_that_kills_its_workers_is_an_error_row_and_the_others_complete(tmp_path: Path):
    study = failing_study(tmp_path, "2, 3, 5, 6, 7")
    code, _, error = sweep(study, "--tracker", "failing_tracker:failing", "--workers", "2")
    assert (code, error) == (1, "")
    assert list(rows(study)["status"]) == ["passed", "passed", "error", "passed", "passed"]
    assert rows(study)["error"][2] == "each worker that tried it died: out of memory, or killed by the run"


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("0.3]", "1.3]", r"small.toml: with noise.dropout.random_rate = 1.3: .*short.toml: noise.dropout: random_rate"),
        ("dropout.random_rate", "dropout.loss", r"noise.dropout.loss = 0.0: .* unknown key; known here: enabled"),
        ('"short.toml"', '"shrt.toml"', r"shrt.toml: No such file"),
        ('"short.toml"', '"truck-shadw"', r"truck-shadw: no such scenario; did you mean truck-shadow"),
        ("description", "descripton", r"small.toml: .*descripton"),
    ],
)  # fmt: skip
def test_an_invalid_study_is_refused_before_the_first_run(tmp_path: Path, old: str, new: str, message: str):
    study = small_study(tmp_path)
    study.write_text(study.read_text().replace(old, new))
    with pytest.raises(InputError, match=message) as raised:
        runs(Study.load(study), device.SHIPPED)
    assert "\n" not in str(raised.value)


ANNOUNCED = "8 runs in small (combinations: 4, seeds: 2)\n"


def test_a_missing_tracker_is_reported_once(tmp_path: Path, luxloop):
    code, output, error = luxloop(small_study(tmp_path), "--tracker", "absent_tracker:failing")
    assert (code, output) == (2, ANNOUNCED)
    assert error.startswith("luxloop: error: --tracker absent_tracker:failing: no module absent_tracker")
    assert not (tmp_path / "out").exists()


def test_an_unwritable_keep_folder_ends_the_sweep(tmp_path: Path, luxloop):
    study = small_study(tmp_path)
    (tmp_path / "file").write_text("")
    with worker_thread() as scheduler:
        code, output, error = luxloop(study, "--keep", str(tmp_path / "file" / "kept"), "--scheduler", scheduler)
    assert (code, output) == (2, ANNOUNCED)
    assert error.startswith(f"luxloop: error: --keep {tmp_path}/file/kept/")
    assert error.endswith("; 0 of 8 rows are in out; run the same command to resume\n")
    assert error.count("\n") == 1


def test_a_worker_with_other_versions_is_refused(tmp_path: Path):
    run = runs(Study.load(small_study(tmp_path)), device.SHIPPED)[0]
    with pytest.raises(StudyError, match=r"has numpy 2[.\d]+, this sweep 1\.0; install the same there"):
        carry_out(run, need={**installed(), "numpy": "1.0"})


def test_a_full_disk_ends_the_sweep_instead_of_making_a_row(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    """The run writes to /dev/full, which has no space."""
    monkeypatch.setattr(worker, "_execute", lambda *_: Path("/dev/full").write_text("a"))
    run = runs(Study.load(small_study(tmp_path)), device.SHIPPED)[0]
    with pytest.raises(OutputError, match="No space left on device; free some space"):
        carry_out(run)
