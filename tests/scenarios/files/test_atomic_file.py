"""Atomic file writes."""

import pytest

from scenarios.files import atomic_file


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
