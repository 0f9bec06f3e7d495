"""Files that appear as a whole or not at all."""

import pytest

from scenarios.files import atomic_file


def test_it_is_there_at_the_end_only_and_replaces_what_was(tmp_path):
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


def test_an_error_leaves_what_was_and_nothing_else(tmp_path):
    path = tmp_path / "page.html"
    path.write_text("before")
    with pytest.raises(KeyError):
        fail(path)
    assert [(entry.name, entry.read_text()) for entry in tmp_path.iterdir()] == [("page.html", "before")]
