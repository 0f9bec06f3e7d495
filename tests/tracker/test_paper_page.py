"""From the paper to the code, a chapter of docs/tracker.md: functions, equations and settings are those of the code."""

import importlib
import re
import tomllib
from functools import reduce
from operator import attrgetter
from pathlib import Path

import pytest
from support.pages import chapter

from luxloop.tracker.tracker import TrackerConfig

DOCS = Path(__file__).parents[2] / "docs"
PAGE = chapter("tracker.md", "From the paper to the code")
VARIANT = tomllib.loads((DOCS / "examples" / "paper-variant.toml").read_text(encoding="utf-8"))["tracker"]
ROWS = [[cell.strip() for cell in row.split("|")[1:-1]] for row in re.findall(r"^\| .*\|$", PAGE, re.MULTILINE)]
FUNCTIONS = re.findall(r"\[`([\w.]+)`\]\(\.\./(tracker/[\w/]+)\.py\)", PAGE)


@pytest.mark.parametrize(("name", "file"), sorted(set(FUNCTIONS)))
def test_every_function_is_defined_in_the_file_that_its_link_opens(name, file):
    module = importlib.import_module(f"luxloop.{file.replace('/', '.')}")
    assert attrgetter(name)(module) is not None
    assert re.search(rf"^(?:def |class )?{name.split('.')[0]}\b", Path(module.__file__).read_text(), re.MULTILINE)


def test_every_equation_and_every_line_of_the_algorithm_has_a_row():
    equations = {int(number) for step, _, _ in ROWS for number in re.findall(r"\*\*\((\d+)\)\*\*", step)}
    assert equations == set(range(1, 13))
    lines = " ".join(step for step, _, _ in ROWS)
    for line in ("line 1", "lines 2 to 4", "line 5", "line 6", "line 7"):
        assert f"{line}:" in lines, line


def test_the_settings_of_the_page_are_those_of_the_variant_and_the_defaults():
    for column, value_of in ((1, lambda key: reduce(dict.__getitem__, key.split("."), VARIANT)), (2, default)):
        named = re.findall(r"`(\w+\.\w+) = ([^`]+)`", " ".join(row[column] for row in ROWS))
        assert named, column
        for key, value in named:
            assert tomllib.loads(f"value = {value}")["value"] == value_of(key), key


def default(key):
    """Return the default of a setting."""
    return attrgetter(key)(TrackerConfig())


def test_the_page_names_every_section_that_the_variant_changes():
    for section in VARIANT:
        assert f"`{section}." in PAGE or section == "baselines", section
