"""Full disks: one line that names the remedy, nothing half-written, and earlier results as before."""

import os
import subprocess
from pathlib import Path

import pytest
from support import bad_input_files as valid
from support import bad_traffic_files, warm_process
from support.bad_input import write
from support.few import few
from support.optional import need_for
from support.processes import files_of
from support.small_disk import small_disk

COMMANDS = {
    "run": "run a.toml --out disk/out --record-scans",
    "dataset": "run a.toml --no-recording --out out --dataset disk/out",
    "grade": "grade run --tracks tracks.csv --out disk/out",
    "report": "report run --out disk/out.html",
    "figures": "report run --out disk/out.html --figures svg",
    "baseline": "baseline run --out disk/out.jsonl",
    "compare": "compare base.jsonl head.jsonl --report disk/out.html",
    "mcap": "mcap run disk/out.mcap",
    "import": "import a.bin --mount 0,0,1 --out disk/out",
    "track": "track rec --out disk/out",
    "sweep": "sweep study.toml --workers 1 --out disk/out",
}
SIZES_KB = few((4, 8, 16, 32, 64, 128, 256), 8, 64)
RESUMED = ("sweep",)
"""Commands whose folder stays, to continue in it."""
FAST = ("run", "baseline", "import")


@pytest.mark.parametrize("kilobytes", SIZES_KB)
@pytest.mark.parametrize("name", [pytest.param(n, marks=[] if n in FAST else pytest.mark.soak) for n in COMMANDS])
def test_a_full_disk_is_one_line(name, kilobytes, tmp_path):
    need_for(name)
    write(valid.all_files() | valid.recording() | bad_traffic_files.small_study(), tmp_path)
    with small_disk(tmp_path / "disk", kilobytes) as disk:
        (disk / "earlier.txt").write_text("earlier")
        done = warm_process.luxloop(*COMMANDS[name].split(), cwd=tmp_path)
        left = sorted(path.name for path in disk.iterdir())
        if done.returncode in (0, 1):
            assert "out" in {Path(entry).stem for entry in left}
        else:
            assert_one_line(done)
            assert left == (["earlier.txt", "out"] if name in RESUMED and "out" in left else ["earlier.txt"])
        assert (disk / "earlier.txt").read_text() == "earlier"
    assert not [path for path in tmp_path.rglob("*") if path.name.endswith((".partial", ".earlier"))]


@pytest.mark.parametrize("kilobytes", [1000])
def test_a_run_on_a_full_disk_keeps_the_earlier_one(kilobytes, tmp_path):
    write(bad_traffic_files.scenario(), tmp_path)
    with small_disk(tmp_path / "disk", kilobytes) as disk:
        command = ["run", "a.toml", "--no-recording", "--out", "disk/out"]
        first = warm_process.luxloop(*command, cwd=tmp_path)
        assert first.returncode in (0, 1), first.stderr
        before = files_of(disk / "out")
        with (disk / "filler").open("wb") as filler:
            fill(filler)
        done = warm_process.luxloop(*command, cwd=tmp_path)
        assert done.returncode == 2
        assert_one_line(done)
        assert files_of(disk / "out") == before
        assert sorted(path.name for path in disk.iterdir()) == ["filler", "out"]


def test_standard_output_on_a_full_disk_is_one_line(tmp_path):
    done = warm_process.luxloop("list", cwd=tmp_path, stdout="/dev/full")
    assert done.returncode == 2
    assert_one_line(done)


def assert_one_line(done: "subprocess.CompletedProcess[str]") -> None:
    """Check that standard error is one line on a disk that is full."""
    assert done.stderr.startswith("luxloop: error: "), done.stderr
    assert done.stderr.count("\n") == 1, done.stderr
    assert "No space left on device" in done.stderr or "the disk may be full" in done.stderr


def fill(file) -> None:
    """Write until the disk is full."""
    try:
        while True:
            os.write(file.fileno(), b"x" * 4096)
    except OSError:
        return
