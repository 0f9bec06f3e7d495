"""Row store: killed processes, a full disk, and folders of other studies."""

import json
import math
import re
import resource
from contextlib import contextmanager
from pathlib import Path

import pandas as pd
import pytest

from luxloop.scenarios.errors import OutputError
from luxloop.scenarios.study.row_store import RowStore

PARAMETERS = {"gap_m": [4.0, 8], "manoeuvre": ["brakes", "keeps speed"]}


def row(key: str, **more: object) -> dict[str, object]:
    return {
        "index": 0, "key": key, "seed": 1, "tracker": "luxloop.tracker.tracker:Tracker", "gap_m": 4,
        "manoeuvre": "brakes",
        "status": "passed", "error": "", "trace_hash": f"hash of {key}", "frames": 10, "wall_s": 0.1,
        "track.hota": 1 / 3, "track.id_switches": None, **more,
    }  # fmt: skip


def test_rows_are_read_back_exactly_in_the_order_of_the_study(tmp_path: Path):
    with RowStore.opened(tmp_path, PARAMETERS) as rows:
        rows.add([row("b", error='message: "no"\nand ü'), row("a", gap_m=8.0)])
        table = rows.merge(["a", "b", "c"])
    assert list(table["key"]) == ["a", "b"]
    assert list(table["index"]) == [0, 1]
    assert list(table["gap_m"]) == [8.0, 4.0]
    assert table["error"][1] == 'message: "no"\nand ü'
    assert list(table["track.hota"]) == [1 / 3, 1 / 3]  # exact, although JSON is text
    assert math.isnan(table["track.id_switches"][0])
    pd.testing.assert_frame_equal(table, pd.read_parquet(tmp_path / "runs.parquet"))
    with RowStore.opened(tmp_path, PARAMETERS) as again:
        assert again.keys == {"a", "b"}


def test_a_partial_line_of_a_killed_process_is_dropped(tmp_path: Path):
    with RowStore.opened(tmp_path, PARAMETERS) as rows:
        rows.add([row("a")])
    with (tmp_path / "runs.jsonl").open("ab") as log:
        log.write(json.dumps(row("b")).encode()[:50])
    with RowStore.opened(tmp_path, PARAMETERS) as rows:
        assert rows.keys == {"a"}
        rows.add([row("b")])  # must not be appended to the partial line
        assert list(rows.merge(["a", "b"])["key"]) == ["a", "b"]


def test_a_kill_before_the_log_is_removed_leaves_no_duplicate_rows(tmp_path: Path):
    with RowStore.opened(tmp_path, PARAMETERS) as rows:
        rows.add([row("a")])
        log = (tmp_path / "runs.jsonl").read_bytes()
        rows.merge(["a"])
    (tmp_path / "runs.jsonl").write_bytes(log)
    with RowStore.opened(tmp_path, PARAMETERS) as rows:
        assert len(rows.merge(["a"])) == 1


def test_rows_of_other_runs_are_stored_separately_and_reused(tmp_path: Path):
    with RowStore.opened(tmp_path, PARAMETERS) as rows:
        rows.add([row("a"), row("b")])
        assert list(rows.merge(["b"])["key"]) == ["b"]
    assert list(pd.read_parquet(tmp_path / "runs.parquet")["key"]) == ["b"]
    with RowStore.opened(tmp_path, PARAMETERS) as rows:
        assert rows.keys == {"a", "b"}
        assert list(rows.merge(["a", "b"])["key"]) == ["a", "b"]
    assert len(pd.read_parquet(tmp_path / "earlier.parquet")) == 0


def test_rows_of_another_study_are_refused(tmp_path: Path):
    with RowStore.opened(tmp_path, PARAMETERS) as rows:
        rows.add([row("a")])
    with pytest.raises(OutputError, match=r"runs\.jsonl: cannot be read as rows of this study .*choose a new --out"):
        RowStore(tmp_path, {"speed_mps": [1.0]})
    with RowStore.opened(tmp_path, PARAMETERS) as rows:
        rows.merge(["a"])
    with pytest.raises(OutputError, match=r"holds rows of another study or version \(gap_m, manoeuvre, speed_mps\)"):
        RowStore(tmp_path, {"speed_mps": [1.0]})


def test_an_invalid_parquet_file_is_named(tmp_path: Path):
    (tmp_path / "runs.parquet").write_bytes(b"PAR1 something else")
    with pytest.raises(OutputError, match=re.escape(str(tmp_path / "runs.parquet"))):
        RowStore(tmp_path, PARAMETERS)


def test_a_folder_has_one_writer_at_a_time(tmp_path: Path):
    with RowStore.opened(tmp_path, PARAMETERS):
        refused = pytest.raises(OutputError, match="another sweep is writing to it")
        with refused, RowStore.opened(tmp_path, PARAMETERS):
            pass
    with RowStore.opened(tmp_path, PARAMETERS):
        pass


def test_a_folder_that_cannot_be_created_is_an_error(tmp_path: Path):
    (tmp_path / "file").write_text("")
    with pytest.raises(OutputError, match="cannot write there"), RowStore.opened(tmp_path / "file" / "out", PARAMETERS):
        pass


def test_a_full_disk_keeps_earlier_rows(tmp_path: Path):
    with RowStore.opened(tmp_path, PARAMETERS) as rows:
        rows.add([row("a")])
        with file_size_limit(500), pytest.raises(OutputError, match=r"cannot write there \(File too large\); free"):
            rows.add([row(f"{i}") for i in range(50)])
        assert rows.keys == {"a"}
        with file_size_limit(500), pytest.raises(OutputError, match="cannot write there"):
            rows.merge(["a"])
    assert sorted(path.name for path in tmp_path.iterdir()) == [".lock", "runs.jsonl"]
    with RowStore.opened(tmp_path, PARAMETERS) as rows:
        assert "a" in rows.keys
        assert list(rows.merge(["a"])["trace_hash"]) == ["hash of a"]


@contextmanager
def file_size_limit(size: int):
    """Make writes beyond a file size fail, as on a full disk."""
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, hard))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))


def test_rows_that_are_taken_over_get_their_reason_and_the_last_row_of_a_run_counts(tmp_path: Path):
    with RowStore.opened(tmp_path, PARAMETERS) as rows:
        assert len(rows.merge(["a"])) == 0
        rows.add([row("a", why="new"), row("b", why="new", status="error"), row("b", why="run again", frames=7)])
        merged = rows.merge(["a", "b"], {"a"}, "taken over")
    assert merged["why"].tolist() == ["taken over", "run again"]
    assert merged["frames"].tolist() == [10, 7]
    with RowStore.opened(tmp_path, PARAMETERS) as rows:
        assert rows.earlier["b"]["status"] == "passed"
