"""Settings of earlier versions: every old key leads to what replaced it."""

import importlib
import re
from dataclasses import fields, is_dataclass

import pytest
from support.paths import ROOT
from support.short_run import TEXT

from luxloop.scenarios.errors import ScenarioError
from luxloop.scenarios.files.scenario import Scenario
from luxloop.tracker.renamed_settings import CONSTANTS, RENAMED, remedy
from luxloop.tracker.tracker import TrackerConfig


def accepts(key):
    """Return True if the settings have a key."""
    table = TrackerConfig()
    for step in key.split(".")[1:]:
        if not is_dataclass(table) or step not in {field.name for field in fields(table)}:
            return False
        table = getattr(table, step)
    return True


@pytest.mark.parametrize(("old", "new"), RENAMED.items())
def test_the_new_key_exists_and_the_old_one_does_not(old, new):
    assert accepts(new)
    assert not accepts(old)


def test_the_page_of_changes_has_every_new_key():
    rows = re.findall(
        r"^\| `(tracker\.\S+)` \| `(\S+)` \|$",
        (ROOT / "docs/command-line.md").read_text(encoding="utf-8"),
        re.MULTILINE,
    )
    assert dict(rows) == RENAMED


@pytest.mark.parametrize("old", CONSTANTS)
def test_the_constant_exists_and_the_old_key_does_not(old):
    constant = CONSTANTS[old]
    module = importlib.import_module("luxloop." + constant.file.removesuffix(".py").replace("/", "."))
    assert isinstance(getattr(module, constant.name), int | float)
    assert not accepts(old)


@pytest.mark.parametrize(
    ("section", "key", "message"),
    [
        ("sweep", 'motion = "ego"', "is tracker.deskew now"),
        ("linkage", "range_std_m = 0.05", "is tracker.lidar.range_std_m now"),
        ("union", "gap_max_m = 5.0", "is tracker.merging now"),
        ("corner", "unseen_share = 0.0", "is tracker.corner.unseen_fraction now"),
        ("extent", "hidden_length_m = 0.2", "has no settings any more, they are constants; leave it out"),
        ("mma", "standing_mps = 0.5", "is a constant now, STANDING_MPS in tracker/tracking/mma.py; leave it out"),
        ("linkage", "gate = 2.0", "is a constant now, GATE in tracker/detection/faces.py; leave it out"),
        ("body", "inside_m = 2.0", "is not used any more: the fitted body is gone; leave it out"),
        ("shadow", "depth_m = 2.0", "has no settings any more, they are constants; leave it out"),
        ("walls", "beam_rad = 0.01", "leave it out; tracker.walls.beam_rad is tracker.lidar.beam_deg now"),
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


ADVICE = re.compile(r"(?:^|[.:] )(?:Change|Raise|Lower|Increase|Decrease|Set) [^.]+")
"""Sentence that says when to change a setting."""


def settings(section, prefix="tracker"):
    """Return name and description of every setting of a section of the schema, and of those in it."""
    tables = Scenario.model_json_schema()["$defs"]
    for name, field in tables[section]["properties"].items():
        key, table = f"{prefix}.{name}", field.get("$ref", "").rpartition("/")[2]
        yield from settings(table, key) if table else [(key, field.get("description", ""))]


def test_the_tracker_has_at_most_sixty_settings_and_each_says_when_to_change_it():
    described = dict(settings("TrackerConfig"))
    assert 40 < len(described) <= 60
    assert [key for key, text in described.items() if not ADVICE.search(" ".join(text.split()))] == []


def test_a_key_that_never_existed_has_no_remedy():
    assert remedy("tracker.filters.jerks") is None
