"""The run folder: atomic write, reading back, replacement and leftovers of killed runs."""

import json
import shutil
import signal
import subprocess
import sys
from contextlib import suppress
from dataclasses import fields

import pandas as pd
import pytest
from support import short_run

from luxloop.scenarios.errors import OutputError
from luxloop.scenarios.files import owner_lock
from luxloop.scenarios.files.expect import Check, Limit
from luxloop.scenarios.result import Metric, Result
from luxloop.scenarios.run import run_folder

RESULT = Result(
    scenario="ring",
    seed=3,
    trace_hash="00ff",
    ended_early="the ego arrived",
    simulator_failed=False,
    frames=12,
    metrics={
        "track.hota": Metric(0.5, "1", 12, interval=(0.25, 0.75)),
        "track.mota": Metric(None, "1", 0, "nothing was graded"),
    },
    tables={"times": pd.DataFrame({"frame": [0, 1], "x_world_m": [0.5, float("nan")]})},
    config={"description": "A ring.", "grading": {}},
    versions={"numpy": "2"},
)
CHECKS = [
    Check("track.hota", Limit(min=0.4), RESULT.metrics["track.hota"]),
    Check("track.mota", Limit(min=0.4), RESULT.metrics["track.mota"]),
]


def names(folder):
    return sorted(path.name for path in folder.iterdir())


def write_run(out, result=RESULT):
    with run_folder.create(out) as folder:
        run_folder.write(folder, result, CHECKS, "the report\n")


def fail(out, error):
    with run_folder.create(out) as folder:
        (folder / "half").write_text("written")
        raise error


def test_a_run_reads_back_as_written(tmp_path):
    write_run(tmp_path / "run")
    back = run_folder.read(tmp_path / "run")
    pd.testing.assert_frame_equal(back.tables["times"], RESULT.tables["times"])
    for field in fields(Result):
        assert field.name in ("tables", "out", "metrics") or getattr(back, field.name) == getattr(RESULT, field.name)
    assert {name: back.metrics[name] for name in RESULT.metrics} == RESULT.metrics
    assert back.out == tmp_path / "run"
    assert names(tmp_path / "run") == ["report.txt", "result.json", "tables"]


def test_the_json_has_the_documented_shape(tmp_path):
    write_run(tmp_path / "run")
    document = json.loads((tmp_path / "run" / "result.json").read_text())
    assert document["verdict"] == "incomplete"
    assert document["failed"] == ["track.mota"]
    assert document["complete"] is False
    assert document["ended_early"] == "the ego arrived"
    assert document["simulator_failed"] is False
    assert document["metrics"] == {
        "track.hota": {"value": 0.5, "unit": "1", "n": 12, "interval": [0.25, 0.75]},
        "track.mota": {"value": None, "unit": "1", "n": 0, "reason": "nothing was graded", "interval": None},
    }


def test_parent_folders_are_made_and_removed_again_if_the_run_fails(tmp_path):
    with pytest.raises(ZeroDivisionError):
        fail(tmp_path / "a" / "b" / "run", ZeroDivisionError)
    assert names(tmp_path) == []
    write_run(tmp_path / "a" / "b" / "run")
    assert names(tmp_path / "a" / "b") == ["run"]


def test_an_interrupted_run_keeps_the_earlier_one(tmp_path):
    write_run(tmp_path / "run")
    with pytest.raises(KeyboardInterrupt):
        fail(tmp_path / "run", KeyboardInterrupt)
    assert names(tmp_path) == ["run"]
    assert run_folder.read(tmp_path / "run").seed == 3


KILLED = """
import os, shutil, signal, sys
from pathlib import Path
from luxloop.scenarios.run import run_folder
with run_folder.create(Path(sys.argv[1])) as folder:
    (folder / "recording.rrd").write_text("half")
    kill = lambda *_, **__: os.kill(os.getpid(), signal.SIGKILL)
    if len(sys.argv) == 2:
        kill()
    (folder / "result.json").write_text("{}")
    shutil.rmtree = kill
"""


def kill_a_run(out, *when):
    assert subprocess.run([sys.executable, "-c", KILLED, out, *when], check=False).returncode == -signal.SIGKILL


def test_the_next_run_removes_the_folder_of_a_killed_one(tmp_path, capsys):
    """The earlier run stays until it is replaced."""
    for _ in range(2):
        kill_a_run(tmp_path / "run")
        left = [name for name in names(tmp_path) if name != "run"]
        assert [name.endswith(".partial") for name in left] == [True]
        with pytest.raises(OutputError, match="incomplete: the run was killed"):
            run_folder.read(tmp_path / left[0])
        write_run(tmp_path / "run")
        assert names(tmp_path) == ["run"]
        (line,) = capsys.readouterr().err.splitlines()
        assert line == f"luxloop: {tmp_path / 'run'}: removed {left[0]}, left by a command that was killed"


def test_a_run_that_is_being_removed_does_not_read_as_one(tmp_path, monkeypatch):
    """The process may be killed before all files are gone, in any order."""
    readable, remove = [], shutil.rmtree

    def try_to_read(folder, **options):
        with suppress(OutputError):
            readable.append(run_folder.read(folder))
        remove(folder, **options)

    write_run(tmp_path / "run")
    monkeypatch.setattr("shutil.rmtree", try_to_read)
    write_run(tmp_path / "run")
    assert names(tmp_path) == ["run"]
    assert readable == []


def test_the_next_run_removes_a_replaced_run_that_a_killed_one_left(tmp_path):
    write_run(tmp_path / "run")
    kill_a_run(tmp_path / "run", "after it was renamed")
    assert len(names(tmp_path)) == 2
    write_run(tmp_path / "run")
    assert names(tmp_path) == ["run"]


def test_an_earlier_run_is_restored_after_a_kill_between_the_two_renames(tmp_path):
    """The next run restores the earlier one, and then fails."""
    write_run(tmp_path / f".run.{owner_lock.machine()}-{dead_process()}-0123abcd.earlier")
    with pytest.raises(ZeroDivisionError):
        fail(tmp_path / "run", ZeroDivisionError)
    assert names(tmp_path) == ["run"]
    assert run_folder.read(tmp_path / "run").seed == 3


@pytest.mark.parametrize(
    "name",
    [
        ".run.elsewhere-{dead}-0123abcd.partial",
        ".other.{machine}-{dead}-0123abcd.partial",
        ".run.{machine}-{dead}-0123abcd.mine",
    ],
)
def test_temporary_folders_of_others_stay(name, tmp_path):
    """Those of another machine with the same file system, of another run, of another program."""
    name = name.format(machine=owner_lock.machine(), dead=dead_process())
    (tmp_path / name).mkdir()
    write_run(tmp_path / "run")
    assert names(tmp_path) == [name, "run"]


OPEN = """
import sys
from pathlib import Path
from luxloop.scenarios.run import run_folder
with run_folder.create(Path(sys.argv[1])) as folder:
    print(folder.name, flush=True)
    sys.stdin.read()
    (folder / "result.json").write_text("{}")
"""


def test_the_folder_of_a_running_process_stays_whatever_its_number(tmp_path):
    """In another container, its process has a number that does not exist here, or that of another process."""
    run = subprocess.Popen(
        [sys.executable, "-c", OPEN, tmp_path / "run"], stdin=subprocess.PIPE, stdout=subprocess.PIPE
    )
    name = run.stdout.readline().decode().strip()
    other = name.replace(f"-{run.pid}-", f"-{dead_process()}-")
    (tmp_path / name).rename(tmp_path / other)
    write_run(tmp_path / "run")
    assert names(tmp_path) == [other, "run"]
    (tmp_path / other).rename(tmp_path / name)
    run.communicate()
    assert run.returncode == 0
    assert names(tmp_path) == ["run"]
    assert names(tmp_path / "run") == ["result.json"]


def dead_process():
    """Return the number of a process that has just ended."""
    process = subprocess.Popen([sys.executable, "-c", ""])
    process.wait()
    return process.pid


def test_an_earlier_run_is_replaced_as_a_whole(tmp_path):
    write_run(tmp_path / "run")
    (tmp_path / "run" / "recording.rrd").write_text("of the earlier run")
    write_run(tmp_path / "run")
    assert names(tmp_path) == ["run"]
    assert "recording.rrd" not in names(tmp_path / "run")


def test_other_files_are_not_replaced(tmp_path):
    (tmp_path / "thesis.tex").write_text("three years of work")
    for out, message in {
        tmp_path: "holds other files than those of a run",
        tmp_path / "thesis.tex": "is a file",
    }.items():
        with pytest.raises(OutputError, match=message), run_folder.create(out):
            pytest.fail("the error must come before the run")
    assert names(tmp_path) == ["thesis.tex"]


def test_a_run_with_a_note_in_it_is_not_replaced(tmp_path):
    write_run(tmp_path / "run")
    (tmp_path / "run" / "note.txt").write_text("why car 7 is lost")
    with pytest.raises(OutputError, match="holds other files than those of a run"):
        write_run(tmp_path / "run")


def test_an_empty_folder_may_become_the_run(tmp_path):
    (tmp_path / "run").mkdir()
    write_run(tmp_path / "run")
    assert run_folder.read(tmp_path / "run").seed == 3


def test_a_folder_that_cannot_be_made_is_an_error_before_the_run(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(OutputError, match="cannot write there"), run_folder.create(tmp_path / "file" / "run"):
        pytest.fail("the error must come before the run")
    assert names(tmp_path) == ["file"]


def test_a_link_to_a_run_stays_a_link(tmp_path):
    write_run(tmp_path / "run")
    (tmp_path / "latest").symlink_to("run")
    write_run(tmp_path / "latest")
    assert (tmp_path / "latest").is_symlink()
    assert names(tmp_path) == ["latest", "run"]


def test_reading_another_folder_is_an_error(tmp_path):
    with pytest.raises(OutputError, match=r"no result\.json of a run in it"):
        run_folder.read(tmp_path)
    (tmp_path / "result.json").write_text('{"another": "tool"}')
    with pytest.raises(OutputError, match="damaged, or of another version"):
        run_folder.read(tmp_path)


@pytest.mark.parametrize(("table", "keys"), run_folder.KEYS.items())
def test_a_row_that_occurs_twice_is_damage(table, keys):
    rows = short_run.result().tables[table]
    run_folder.require_table(table, rows)
    with pytest.raises(ValueError, match=f"two rows of {table} have the same {', '.join(keys)}"):
        run_folder.require_table(table, pd.concat([rows, rows.iloc[-1:]]))


@pytest.mark.parametrize("column", run_folder.MEASURED["fits"])
def test_fits_without_their_errors_are_damage(column):
    with pytest.raises(ValueError, match=f"column {column} of fits is missing"):
        run_folder.require_table("fits", short_run.result().tables["fits"].drop(columns=column))


@pytest.mark.parametrize("name", ["../../street", "/tmp/street", "a/b", "..", "street\0"])
def test_the_name_of_a_scenario_never_leads_out_of_a_folder(name, tmp_path):
    """Exporters and figures of a stranger's run make files of this name."""
    write_run(tmp_path / "run")
    file = tmp_path / "run" / "result.json"
    file.write_text(json.dumps({**json.loads(file.read_text()), "scenario": name}))
    with pytest.raises(OutputError, match="damaged, or of another version"):
        run_folder.read(tmp_path / "run")


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ('"track.hota": {', '"track.hotta": {'),
        ('"track.hota": {', '"track.hota{<;}": {'),
        ('"seed": ', '"limit": 1e999, "seed": '),
    ],
)
def test_unknown_metrics_and_infinite_numbers_are_damage(old, new, tmp_path):
    """They ended the grading of a damaged run with a traceback."""
    write_run(tmp_path / "run")
    file = tmp_path / "run" / "result.json"
    text = file.read_text()
    assert text.count(old) >= 1
    file.write_text(text.replace(old, new))
    with pytest.raises(OutputError, match="damaged, or of another version"):
        run_folder.read(tmp_path / "run")


def test_a_run_without_recording_is_an_error_with_a_remedy(tmp_path):
    write_run(tmp_path / "run")
    with pytest.raises(OutputError, match="without --no-recording"):
        run_folder.recording(tmp_path / "run")


def test_runs_are_found_at_any_depth_without_those_that_were_killed(tmp_path):
    for place in ("street-seed1", "urban/street-seed2", "urban/.street-seed3.host-1-00000000.partial"):
        write_run(tmp_path / place)
    assert run_folder.found_in(tmp_path) == [tmp_path / "street-seed1", tmp_path / "urban" / "street-seed2"]
    assert run_folder.found_in(tmp_path / "street-seed1") == [tmp_path / "street-seed1"]
