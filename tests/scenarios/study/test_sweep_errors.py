"""Runs that fail are rows; what would fail every run is one line, before anything or at its first sign."""

import json
from pathlib import Path

import pytest
from support.sweeps import rows, small_study, sweep

from scenarios.errors import InputError, OutputError, StudyError
from scenarios.run import device
from scenarios.run.versions import installed
from scenarios.study.design import runs
from scenarios.study.study_file import Study
from scenarios.study.worker import carry_out

TRACKER = """\
import os, signal
from tracker.tracker import Tracker

def moody(config):
    if config.segmentation.points_min == 4:
        raise RuntimeError("four is\\nmy limit")
    if config.segmentation.points_min == 5:
        os.kill(os.getpid(), signal.SIGKILL)
    return Tracker(config)
"""

MOODY = """\
description = "A tracker that dislikes a setting."
scenario = "short.toml"
fixed = { duration_s = 0.1 }
vary = [{ key = "tracker.segmentation.points_min", values = [%s] }]
"""


def moody_study(folder: Path, values: str) -> Path:
    study = small_study(folder)
    (folder / "moody_tracker.py").write_text(TRACKER)
    study.write_text(MOODY % values)
    return study


def test_a_run_that_fails_is_a_row_with_its_error(tmp_path: Path):
    study = moody_study(tmp_path, "3, 4")
    keep = tmp_path / "kept"
    code, output, error = sweep(
        study, "--tracker", "moody_tracker:moody", "--keep", keep.as_uri(), "--json", "--workers", "1"
    )
    assert (code, error) == (1, "")
    told = json.loads(output)
    assert told["status"] == {"error": 1, "passed": 1}
    assert told["errors"] == ["RuntimeError: four is my limit (moody_tracker.py:6)"]
    good, bad = rows(study).to_dict("records")
    assert good["trace_hash"]
    assert (bad["status"], bad["trace_hash"], bad["tracker.segmentation.points_min"]) == ("error", "", 4)
    assert (keep / good["key"] / "result.json").is_file()
    assert not (keep / bad["key"]).exists()


@pytest.mark.slow
def test_a_run_that_kills_its_workers_is_a_row_and_the_others_are_done(tmp_path: Path):
    study = moody_study(tmp_path, "2, 3, 5, 6, 7")
    code, _, error = sweep(study, "--tracker", "moody_tracker:moody", "--workers", "2")
    assert (code, error) == (1, "")
    assert list(rows(study)["status"]) == ["passed", "passed", "error", "passed", "passed"]
    assert rows(study)["error"][2] == "each worker that tried it died: out of memory, or taken down by the run"


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ("0.3]", "1.3]", r"small.toml: with noise.dropout.random_rate = 1.3: .*short.toml: noise.dropout: random_rate"),
        ("dropout.random_rate", "dropout.loss", r"noise.dropout.loss = 0.0: .* unknown key; known here: enabled"),
        ('"short.toml"', '"shrt.toml"', r"shrt.toml: No such file"),
        ('"short.toml"', '"truck-shadw"', r"truck-shadw: no such scenario; did you mean truck-shadow"),
        ("description", "descripton", r"small.toml: .*descripton"),
    ],
)  # fmt: skip
def test_what_cannot_run_is_told_before_anything_runs(tmp_path: Path, old: str, new: str, told: str):
    study = small_study(tmp_path)
    study.write_text(study.read_text().replace(old, new))
    with pytest.raises(InputError, match=told) as raised:
        runs(Study.load(study), device.SHIPPED)
    assert "\n" not in str(raised.value)


def test_no_such_tracker_is_told_once(tmp_path: Path):
    code, output, error = sweep(small_study(tmp_path), "--tracker", "moody_tracker:moody")
    assert (code, output) == (2, "")
    assert error.startswith("luxloop: error: --tracker moody_tracker:moody: no module moody_tracker")
    assert not (tmp_path / "out").exists()


def test_a_place_that_cannot_keep_runs_ends_the_sweep_at_once(tmp_path: Path):
    study = small_study(tmp_path)
    (tmp_path / "file").write_text("")
    code, output, error = sweep(study, "--keep", str(tmp_path / "file" / "kept"), "--workers", "1")
    assert (code, output) == (2, "")
    assert error.startswith(f"luxloop: error: --keep {tmp_path}/file/kept/")
    assert error.endswith("; 0 of 8 rows are in out, the same command goes on from there\n")
    assert error.count("\n") == 1


def test_a_worker_with_other_versions_is_refused(tmp_path: Path):
    run = runs(Study.load(small_study(tmp_path)), device.SHIPPED)[0]
    with pytest.raises(StudyError, match=r"has numpy 2[.\d]+, this sweep 1\.0; install the same there"):
        carry_out(run, need={**installed(), "numpy": "1.0"})


def test_a_full_disk_under_a_run_is_no_row(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    """What a device writes goes to /dev/full, which has no room."""
    (tmp_path / "writing_tracker.py").write_text(
        "def writing(config):\n    with open('/dev/full', 'w') as file:\n        file.write('a')\n"
    )
    monkeypatch.chdir(tmp_path)
    run = runs(Study.load(small_study(tmp_path)), "writing_tracker:writing")[0]
    with pytest.raises(OutputError, match="No space left on device; make room there"):
        carry_out(run)
