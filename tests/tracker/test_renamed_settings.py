"""Settings of earlier versions: every old key leads to what replaced it."""

import importlib
from dataclasses import fields, is_dataclass

import pytest
from support.short_run import TEXT

from luxloop.scenarios.errors import ScenarioError
from luxloop.scenarios.files.scenario import Scenario
from luxloop.tracker.renamed_settings import CONSTANTS, RENAMED, remedy
from luxloop.tracker.tracker import TrackerConfig


def accepts(key):
    """Return True if the settings have a key."""
    _, *steps = key.split(".")
    table = TrackerConfig
    for step in steps:
        types = {field.name: field.type for field in fields(table)} if is_dataclass(table) else {}
        if step not in types:
            return False
        table = types[step]
    return True


@pytest.mark.parametrize(("old", "new"), RENAMED.items())
def test_the_new_key_exists_and_the_old_one_does_not(old, new):
    assert accepts(new)
    assert not accepts(old)


@pytest.mark.parametrize("old", CONSTANTS)
def test_the_constant_exists_and_the_old_key_does_not(old):
    constant = CONSTANTS[old]
    module = importlib.import_module("luxloop." + constant.file.removesuffix(".py").replace("/", "."))
    assert isinstance(getattr(module, constant.name), int | float)
    assert not accepts(old)


@pytest.mark.parametrize(
    ("section", "key", "message"),
    [
        ("life", "confirm_hits = 5", "is tracker.confirmation now"),
        ("association", "oddity_max = 0.0", "is tracker.association.shape_cost_max now"),
        ("filters", "jerk_time_s = 1.0", "is a constant now, JERK_TIME_S in tracker/tracking/filters.py; leave it out"),
        ("orientation.flow", "lane_m = 2.0", "has no settings any more, they are constants; leave it out"),
    ],
)
def test_a_scenario_with_an_old_key_is_refused_in_one_line_that_says_so(tmp_path, section, key, message):
    path = tmp_path / "old.toml"
    path.write_text(f"{TEXT}\n[tracker.{section}]\n{key}\n")
    with pytest.raises(ScenarioError, match=message) as caught:
        Scenario.load(path)
    assert "\n" not in str(caught.value)


def test_a_key_that_never_existed_has_no_remedy():
    assert remedy("tracker.filters.jerks") is None
