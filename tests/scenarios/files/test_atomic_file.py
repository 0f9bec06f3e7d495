"""Atomic file writes."""

import signal
import subprocess
import sys

import pytest

from luxloop.scenarios.files import atomic_file


def test_the_file_is_replaced_at_the_end_only(tmp_path):
    path = tmp_path / "page.html"
    path.write_text("before")
    with atomic_file.create(path) as temporary:
        temporary.write_text("half")
        assert path.read_text() == "before"
    assert [entry.name for entry in tmp_path.iterdir()] == ["page.html"]
    assert path.read_text() == "half"


def fail(path):
    with atomic_file.create(path) as temporary:
        temporary.write_text("half")
        raise KeyError


def test_an_error_keeps_the_earlier_file_and_leaves_no_other(tmp_path):
    path = tmp_path / "page.html"
    path.write_text("before")
    with pytest.raises(KeyError):
        fail(path)
    assert [(entry.name, entry.read_text()) for entry in tmp_path.iterdir()] == [("page.html", "before")]


KILLED = """
import os, signal, sys
from pathlib import Path
from luxloop.scenarios.files import atomic_file
with atomic_file.create(Path(sys.argv[1])) as temporary:
    temporary.write_text("half")
    os.kill(os.getpid(), signal.SIGKILL)
"""


def test_the_file_of_a_killed_process_is_removed_by_the_next_write(tmp_path):
    path = tmp_path / "page.html"
    assert subprocess.run([sys.executable, "-c", KILLED, path], check=False).returncode == -signal.SIGKILL
    (left,) = tmp_path.iterdir()
    with atomic_file.create(path) as temporary:
        assert not left.exists()
        temporary.write_text("whole")
    assert list(tmp_path.iterdir()) == [path]


def test_the_file_of_a_running_process_stays(tmp_path):
    path = tmp_path / "page.html"
    with atomic_file.create(path) as temporary:
        temporary.write_text("first")
        with atomic_file.create(path) as other:
            other.write_text("second")
        assert (temporary.read_text(), path.read_text()) == ("first", "second")
    assert path.read_text() == "first"


def write_together(folder, error=None):
    with atomic_file.together():
        for name in ("a", "b"):
            with atomic_file.create(folder / name) as temporary:
                temporary.write_text("new")
        assert not (folder / "b").exists()
        if error:
            raise error


def test_files_written_together_appear_at_the_end(tmp_path):
    (tmp_path / "a").write_text("before")
    write_together(tmp_path)
    assert {path.name: path.read_text() for path in tmp_path.iterdir()} == {"a": "new", "b": "new"}


@pytest.mark.parametrize("error", [OSError(28, "full"), KeyboardInterrupt()])
def test_of_files_written_together_none_appears_after_an_error(error, tmp_path):
    (tmp_path / "a").write_text("before")
    with pytest.raises(type(error)):
        write_together(tmp_path, error)
    assert {path.name: path.read_text() for path in tmp_path.iterdir()} == {"a": "before"}
    with atomic_file.create(tmp_path / "c") as temporary:
        temporary.write_text("alone again")
    assert (tmp_path / "c").exists()
