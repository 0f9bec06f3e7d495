"""Rows on disk: what a killed process leaves, a full disk, another study's folder."""

import json
import math
import re
import resource
from contextlib import contextmanager
from pathlib import Path

import pandas as pd
import pytest

from scenarios.errors import OutputError
from scenarios.study.row_store import Rows

PARAMETERS = {"gap_m": [4.0, 8], "manoeuvre": ["brakes", "keeps speed"]}


def row(key: str, **more: object) -> dict[str, object]:
    return {
        "index": 0, "key": key, "seed": 1, "tracker": "tracker.tracker:Tracker", "gap_m": 4, "manoeuvre": "brakes",
        "status": "passed", "error": "", "trace_hash": f"hash of {key}", "frames": 10, "wall_s": 0.1,
        "track.hota": 1 / 3, "track.id_switches": None, **more,
    }  # fmt: skip


def test_rows_come_back_as_they_were_in_the_order_of_the_study(tmp_path: Path):
    with Rows.opened(tmp_path, PARAMETERS) as rows:
        rows.add([row("b", error='it said: "no"\nand ü'), row("a", gap_m=8.0)])
        table = rows.join(["a", "b", "c"])
    assert list(table["key"]) == ["a", "b"]
    assert list(table["index"]) == [0, 1]
    assert list(table["gap_m"]) == [8.0, 4.0]
    assert table["error"][1] == 'it said: "no"\nand ü'
    assert list(table["track.hota"]) == [1 / 3, 1 / 3]  # to the last bit, though it went through a text
    assert math.isnan(table["track.id_switches"][0])
    pd.testing.assert_frame_equal(table, pd.read_parquet(tmp_path / "runs.parquet"))
    with Rows.opened(tmp_path, PARAMETERS) as again:
        assert again.keys == {"a", "b"}


def test_the_row_that_a_killed_process_was_writing_is_left_out(tmp_path: Path):
    with Rows.opened(tmp_path, PARAMETERS) as rows:
        rows.add([row("a")])
    with (tmp_path / "runs.jsonl").open("ab") as journal:
        journal.write(json.dumps(row("b")).encode()[:50])
    with Rows.opened(tmp_path, PARAMETERS) as rows:
        assert rows.keys == {"a"}
        rows.add([row("b")])  # must not be glued to the torn one
        assert list(rows.join(["a", "b"])["key"]) == ["a", "b"]


def test_one_that_was_killed_before_it_emptied_the_journal_has_no_row_twice(tmp_path: Path):
    with Rows.opened(tmp_path, PARAMETERS) as rows:
        rows.add([row("a")])
        journal = (tmp_path / "runs.jsonl").read_bytes()
        rows.join(["a"])
    (tmp_path / "runs.jsonl").write_bytes(journal)
    with Rows.opened(tmp_path, PARAMETERS) as rows:
        assert len(rows.join(["a"])) == 1


def test_rows_of_other_runs_are_kept_apart_and_found_again(tmp_path: Path):
    with Rows.opened(tmp_path, PARAMETERS) as rows:
        rows.add([row("a"), row("b")])
        assert list(rows.join(["b"])["key"]) == ["b"]
    assert list(pd.read_parquet(tmp_path / "runs.parquet")["key"]) == ["b"]
    with Rows.opened(tmp_path, PARAMETERS) as rows:
        assert rows.keys == {"a", "b"}
        assert list(rows.join(["a", "b"])["key"]) == ["a", "b"]
    assert len(pd.read_parquet(tmp_path / "earlier.parquet")) == 0


def test_another_study_is_refused(tmp_path: Path):
    with Rows.opened(tmp_path, PARAMETERS) as rows:
        rows.add([row("a")])
    with pytest.raises(OutputError, match=r"runs\.jsonl: cannot be read as rows of this study .*choose a new --out"):
        Rows(tmp_path, {"speed_mps": [1.0]})
    with Rows.opened(tmp_path, PARAMETERS) as rows:
        rows.join(["a"])
    with pytest.raises(OutputError, match=r"holds rows of another study or version \(gap_m, manoeuvre, speed_mps\)"):
        Rows(tmp_path, {"speed_mps": [1.0]})


def test_a_file_that_is_no_parquet_is_named(tmp_path: Path):
    (tmp_path / "runs.parquet").write_bytes(b"PAR1 something else")
    with pytest.raises(OutputError, match=re.escape(str(tmp_path / "runs.parquet"))):
        Rows(tmp_path, PARAMETERS)


def test_only_one_at_a_time(tmp_path: Path):
    with Rows.opened(tmp_path, PARAMETERS):
        refused = pytest.raises(OutputError, match="another sweep writes there now")
        with refused, Rows.opened(tmp_path, PARAMETERS):
            pass
    with Rows.opened(tmp_path, PARAMETERS):
        pass


def test_no_folder_can_be_made(tmp_path: Path):
    (tmp_path / "file").write_text("")
    with pytest.raises(OutputError, match="cannot write there"), Rows.opened(tmp_path / "file" / "out", PARAMETERS):
        pass


def test_a_full_disk_keeps_what_was_written(tmp_path: Path):
    with Rows.opened(tmp_path, PARAMETERS) as rows:
        rows.add([row("a")])
        with no_file_larger_than(500), pytest.raises(OutputError, match=r"cannot write there \(File too large\); make"):
            rows.add([row(f"{i}") for i in range(50)])
        assert rows.keys == {"a"}
        with no_file_larger_than(500), pytest.raises(OutputError, match="cannot write there"):
            rows.join(["a"])
    assert sorted(path.name for path in tmp_path.iterdir()) == [".lock", "runs.jsonl"]
    with Rows.opened(tmp_path, PARAMETERS) as rows:
        assert "a" in rows.keys
        assert list(rows.join(["a"])["trace_hash"]) == ["hash of a"]


@contextmanager
def no_file_larger_than(size: int):
    """The kernel refuses to write more, as on a full disk."""
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, hard))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))
