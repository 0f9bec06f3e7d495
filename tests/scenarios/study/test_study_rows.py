"""Row store: killed processes, full disks, other file systems, and folders of other studies."""

import gc
import math
import os
import re
import resource
import sqlite3
import sys
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pandas as pd
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from support.few import few
from support.sweeps import stored

from luxloop.scenarios.errors import OutputError
from luxloop.scenarios.metrics.definitions import is_metric
from luxloop.scenarios.study import row_store
from luxloop.scenarios.study.row_store import ROWS_AT_ONCE, RowStore, as_row, as_text, schema_of

PARAMETERS = {"gap_m": [4.0, 8], "manoeuvre": ["brakes", "keeps speed"]}
SHOWN = ("track.hota", "track.id_switches")
SCHEMA = pa.schema([field for field in schema_of(PARAMETERS) if not is_metric(field.name) or field.name in SHOWN])
"""Columns with two metrics, for speed."""
FILES = [".lock", "runs.parquet", "runs.sqlite"]


def row(key: str, **more: object) -> dict[str, object]:
    return {
        "index": 0, "key": key, "seed": 1, "tracker": "luxloop.tracker.tracker:Tracker", "gap_m": 4,
        "manoeuvre": "brakes",
        "status": "passed", "error": "", "trace_hash": f"hash of {key}", "frames": 10, "wall_s": 0.1,
        "track.hota": 1 / 3, "track.id_switches": None, **more,
    }  # fmt: skip


def texts(*keys: str) -> list[row_store.RowText]:
    return [as_text(row(key)) for key in keys]


def names(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.iterdir())


def table(folder: Path) -> pd.DataFrame:
    return pd.read_parquet(folder / "runs.parquet")


def test_rows_are_read_back_exactly_in_the_order_of_the_study(tmp_path: Path):
    with RowStore.opened(tmp_path, PARAMETERS) as rows:
        rows.add([as_text(row("b", error='message: "no"\nand ü')), as_text(row("a", gap_m=8.0, manoeuvre=True))])
        rows.write_table(SCHEMA, ["a", "b", "c"])
    found = table(tmp_path)
    assert list(found.columns) == SCHEMA.names
    assert list(found["key"]) == ["a", "b"]
    assert list(found["index"]) == [0, 1]
    assert list(found["gap_m"]) == [8.0, 4.0]
    assert list(found["manoeuvre"]) == ["True", "brakes"]
    assert found["error"][1] == 'message: "no"\nand ü'
    assert list(found["track.hota"]) == [1 / 3, 1 / 3]  # exact, although JSON is text
    assert math.isnan(found["track.id_switches"][0])
    assert pq.read_schema(tmp_path / "runs.parquet").remove_metadata().equals(SCHEMA)
    assert names(tmp_path) == FILES


def test_rows_of_an_earlier_start_are_there_in_the_order_of_their_arrival(tmp_path: Path):
    with RowStore.opened(tmp_path, PARAMETERS) as rows:
        rows.add(texts("b", "a"))
    with RowStore.opened(tmp_path, PARAMETERS) as rows:
        assert rows.keys == {"a", "b"}
        assert [facts["key"] for facts in rows.facts()] == ["b", "a"]
        assert "track.hota" not in next(rows.facts())
        assert [one["track.hota"] for one in rows.rows()] == [1 / 3, 1 / 3]


def test_a_row_without_metrics_and_a_metric_that_is_no_column_make_no_difference(tmp_path: Path):
    with RowStore.opened(tmp_path, PARAMETERS) as rows:
        bare = {name: value for name, value in row("a").items() if not name.startswith("track.")}
        rows.add([as_text(bare), as_text(row("b", **{"own.gap_m": 3.5}))])
        rows.write_table(SCHEMA, ["a", "b"])
        assert table(tmp_path)["track.hota"].isna().tolist() == [True, False]
        rows.write_table(schema_of(PARAMETERS, ["own.gap_m"]), ["a", "b"])
    assert table(tmp_path)["own.gap_m"].tolist()[1] == 3.5
    assert as_row(as_text(row("b"))) == {key: value for key, value in row("b").items() if key != "track.id_switches"}


def test_no_rows_are_a_table_without_rows(tmp_path: Path):
    with RowStore.opened(tmp_path, PARAMETERS) as rows:
        rows.write_table(SCHEMA, ["a"])
    assert len(table(tmp_path)) == 0
    assert list(table(tmp_path).columns) == SCHEMA.names


def test_rows_of_other_runs_stay_in_the_sqlite_file_and_are_reused(tmp_path: Path):
    with RowStore.opened(tmp_path, PARAMETERS) as rows:
        rows.add(texts("a", "b"))
        rows.write_table(SCHEMA, ["b"])
    assert list(table(tmp_path)["key"]) == ["b"]
    with RowStore.opened(tmp_path, PARAMETERS) as rows:
        assert rows.keys == {"a", "b"}
        rows.write_table(SCHEMA, ["a", "b"])
    assert list(table(tmp_path)["key"]) == ["a", "b"]


def test_the_last_row_of_a_run_counts_and_rows_that_are_taken_over_get_their_reason(tmp_path: Path):
    with RowStore.opened(tmp_path, PARAMETERS) as rows:
        rows.add([as_text(row("a", why="new")), as_text(row("b", why="new", status="error"))])
        rows.add([as_text(row("b", why="run again", frames=7))])
        rows.write_table(SCHEMA, ["a", "b"], {"a"}, "taken over")
        assert [(one["key"], one["status"]) for one in rows.facts()] == [("a", "passed"), ("b", "passed")]
    assert table(tmp_path)["why"].tolist() == ["taken over", "run again"]
    assert table(tmp_path)["frames"].tolist() == [10, 7]


def test_a_table_of_several_batches_has_the_order_of_the_study(tmp_path: Path):
    """Rows that arrive in a random order, with every tenth twice."""
    count = 2 * ROWS_AT_ONCE + 500
    order = np.random.default_rng(3).permutation(count)
    with RowStore.opened(tmp_path, PARAMETERS) as rows:
        rows.add([as_text(row(f"k{i}", status="error", frames=0)) for i in range(0, count, 10)])
        rows.add([as_text(row(f"k{i}", frames=int(i))) for i in order])
        rows.write_table(SCHEMA, [f"k{i}" for i in range(count)])
        assert table(tmp_path)["frames"].tolist() == table(tmp_path)["index"].tolist() == list(range(count))
        assert set(table(tmp_path)["status"]) == {"passed"}
        rows.write_table(SCHEMA, [f"k{i}" for i in range(0, count, 2)])
    assert table(tmp_path)["frames"].tolist() == list(range(0, count, 2))


def test_the_rows_of_a_running_command_can_be_read(tmp_path: Path):
    with RowStore.opened(tmp_path, PARAMETERS) as rows:
        rows.add(texts("a"))
        with sqlite3.connect(tmp_path / "runs.sqlite") as reader:
            query = "SELECT facts ->> 'status', metrics ->> '$.\"track.hota\"' FROM runs"
            assert reader.execute(query).fetchall() == [("passed", 1 / 3)]
        reader.close()
        rows.add(texts("b"))
    assert stored(tmp_path) == {"a": "hash of a", "b": "hash of b"}


@pytest.mark.parametrize("journal", ["WAL", "DELETE"])
@pytest.mark.parametrize("at", ["add", "commit", "table"])
def test_a_kill_at_any_point_loses_nothing_that_was_stored(journal, at, tmp_path: Path, monkeypatch):
    """The child ends without any handler: before rows are committed, after it, and while the table is written."""
    child = os.fork()
    if child == 0:
        monkeypatch.setattr(row_store, "journal_mode", lambda _: journal)
        with RowStore.opened(tmp_path, PARAMETERS) as rows:
            rows.add(texts("a", "b"))
            rows.write_table(SCHEMA, ["a", "b"])
            if at == "add":
                rows._database.execute("INSERT INTO runs VALUES ('c', '{}', '{}')")
                os._exit(9)
            rows.add(texts("c"))
            if at == "commit":
                os._exit(9)
            monkeypatch.setattr(row_store, "_columns", lambda *_: os._exit(9))
            rows.write_table(SCHEMA, ["a", "b", "c"])
    assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 9
    assert list(table(tmp_path)["key"]) == ["a", "b"]
    with RowStore.opened(tmp_path, PARAMETERS) as rows:
        assert rows.keys == {"a", "b"} | ({"c"} if at != "add" else set())
        rows.write_table(SCHEMA, sorted(rows.keys))
        assert list(table(tmp_path)["key"]) == sorted(rows.keys)
    assert names(tmp_path) == FILES


def test_rows_of_another_study_are_refused(tmp_path: Path):
    with RowStore.opened(tmp_path, PARAMETERS) as rows:
        rows.add(texts("a"))
    before = (tmp_path / "runs.sqlite").read_bytes()
    message = r"runs\.sqlite: holds rows of another study \(gap_m, manoeuvre, speed_mps\); choose a new --out"
    with pytest.raises(OutputError, match=message), RowStore.opened(tmp_path, ["speed_mps"]):
        pass
    assert (tmp_path / "runs.sqlite").read_bytes() == before


@pytest.mark.parametrize("name", ["runs.jsonl", "runs.parquet", "answers.jsonl"])
def test_rows_of_version_0_1_are_refused_in_one_line(name, tmp_path: Path):
    (tmp_path / name).write_text("")
    message = rf"{name}: holds rows that are not in runs\.sqlite, as luxloop 0\.1 wrote them; choose a new --out, or "
    with pytest.raises(OutputError, match=message) as raised, RowStore.opened(tmp_path):
        pass
    assert "\n" not in str(raised.value)


def test_a_file_that_is_not_sqlite_is_named_and_left_as_it_is(tmp_path: Path):
    (tmp_path / "runs.sqlite").write_bytes(b"something else, longer than the header of a database " * 20)
    message = re.escape(str(tmp_path / "runs.sqlite")) + r": cannot be read as rows \(file is not a database\); choose"
    with pytest.raises(OutputError, match=message), RowStore.opened(tmp_path):
        pass
    assert (tmp_path / "runs.sqlite").read_bytes().startswith(b"something else")


def test_a_file_that_is_refused_is_closed(tmp_path: Path, monkeypatch):
    opened, connect = [], sqlite3.connect
    monkeypatch.setattr(
        sqlite3, "connect", lambda *args, **options: opened.append(connect(*args, **options)) or opened[0]
    )
    (tmp_path / "runs.sqlite").write_bytes(b"something else" * 100)
    with pytest.raises(OutputError), RowStore.opened(tmp_path):
        pass
    with pytest.raises(sqlite3.ProgrammingError, match="closed database"):
        opened[0].execute("SELECT 1")


def test_a_table_of_another_program_is_refused(tmp_path: Path):
    with sqlite3.connect(tmp_path / "runs.sqlite") as other:
        other.execute("CREATE TABLE runs (key TEXT, name TEXT)")
        other.execute("INSERT INTO runs VALUES ('a', 'b')")
    other.close()
    message = r"runs\.sqlite: cannot be read as rows \(no such column: facts\); choose a new --out"
    with pytest.raises(OutputError, match=message), RowStore.opened(tmp_path):
        pass


def test_a_damaged_file_is_one_line(tmp_path: Path):
    with RowStore.opened(tmp_path, PARAMETERS) as rows:
        rows.add(texts(*(f"{i}" for i in range(500))))
    content = (tmp_path / "runs.sqlite").read_bytes()
    (tmp_path / "runs.sqlite").write_bytes(content[:8192] + b"\xff" * (len(content) - 8192))
    message = r"runs\.sqlite: cannot be read as rows \(database disk image is malformed\); choose a new --out"
    with pytest.raises(OutputError, match=message), RowStore.opened(tmp_path, PARAMETERS) as rows:
        list(rows.rows())


def test_a_folder_has_one_writer_at_a_time(tmp_path: Path):
    with RowStore.opened(tmp_path, PARAMETERS):
        refused = pytest.raises(OutputError, match="another command is writing to it")
        with refused, RowStore.opened(tmp_path, PARAMETERS):
            pass
    with RowStore.opened(tmp_path, PARAMETERS):
        pass


def test_a_folder_that_cannot_be_created_is_an_error(tmp_path: Path):
    (tmp_path / "file").write_text("")
    with pytest.raises(OutputError, match="cannot write there"), RowStore.opened(tmp_path / "file" / "out", PARAMETERS):
        pass


def test_a_new_folder_without_rows_is_removed_after_an_error(tmp_path: Path):
    with pytest.raises(ValueError, match="no run"), RowStore.opened(tmp_path / "out", PARAMETERS):
        raise ValueError("no run")
    assert names(tmp_path) == []


@pytest.mark.parametrize("journal", few(["WAL", "DELETE"], "WAL"))
def test_a_full_disk_keeps_earlier_rows(journal, tmp_path: Path, monkeypatch):
    monkeypatch.setattr(row_store, "journal_mode", lambda _: journal)
    with RowStore.opened(tmp_path, PARAMETERS) as rows:
        rows.add(texts("a"))
        size = max(path.stat().st_size for path in tmp_path.iterdir())
        message = r"cannot write there \(.*\); the disk may be full: free some space, or choose another --out"
        with file_size_limit(size), pytest.raises(OutputError, match=message):
            rows.add(texts(*(f"{i}" for i in range(500))))
        assert rows.keys == {"a"}
        printed = []
        monkeypatch.setattr(sys, "unraisablehook", lambda found: printed.append(found.exc_value))
        with file_size_limit(500), pytest.raises(OutputError, match=r"cannot write there \(.*File too large\)"):
            rows.write_table(SCHEMA, ["a"])
        gc.collect()  # of a Parquet writer that is still open
        assert not printed
        assert not [name for name in names(tmp_path) if "parquet" in name]
        rows.add(texts("b"))
    with RowStore.opened(tmp_path, PARAMETERS) as rows:
        assert rows.keys == {"a", "b"}


@contextmanager
def file_size_limit(size: int):
    """Make writes beyond a file size fail, as on a full disk."""
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, hard))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))


MOUNTS = """\
22 1 {major}:{minor} / /home rw,relatime shared:1 - {kind} /dev/sda1 rw
23 1 8:99 / / rw,relatime - ext4 /dev/sda2 rw
"""


@pytest.mark.parametrize(
    ("kind", "journal"),
    [("ext4", "WAL"), ("xfs", "WAL"), ("btrfs", "WAL"), ("nfs4", "DELETE"), ("cifs", "DELETE"), ("lustre", "DELETE"),
     ("fuse.sshfs", "DELETE"), ("virtiofs", "DELETE")],
)  # fmt: skip
def test_only_known_local_file_systems_get_a_write_ahead_log(kind, journal, tmp_path: Path, monkeypatch):
    device = tmp_path.stat().st_dev
    mounts = MOUNTS.format(major=os.major(device), minor=os.minor(device), kind=kind)
    monkeypatch.setattr(Path, "read_text", lambda *_, **__: mounts)
    assert row_store.file_system(tmp_path) == kind
    assert row_store.journal_mode(tmp_path) == journal


def test_a_device_that_no_mount_names_gets_a_rollback_journal(tmp_path: Path, monkeypatch):
    """A subvolume of btrfs has a device number of its own."""
    monkeypatch.setattr(Path, "read_text", lambda *_, **__: MOUNTS.format(major=250, minor=250, kind="ext4"))
    assert row_store.file_system(tmp_path) == ""
    assert row_store.journal_mode(tmp_path) == "DELETE"


def test_the_mounts_of_this_machine_name_a_kernel_file_system():
    assert row_store.file_system(Path("/proc")) == "proc"
    assert row_store.journal_mode(Path("/proc")) == "DELETE"


@pytest.mark.parametrize(("before", "after"), [("WAL", "DELETE"), ("DELETE", "WAL")])
def test_a_folder_that_moves_to_another_file_system_changes_its_journal(before, after, tmp_path: Path, monkeypatch):
    for journal in (before, after):
        monkeypatch.setattr(row_store, "journal_mode", lambda _, mode=journal: mode)
        with RowStore.opened(tmp_path, PARAMETERS) as rows:
            rows.add(texts(journal))
            assert ("runs.sqlite-wal" in names(tmp_path)) == (journal == "WAL")
    assert names(tmp_path) == [".lock", "runs.sqlite"]
    assert list(stored(tmp_path)) == [before, after]
