"""docs/own-scenario.md: tables, example and commands match the code."""

import re
import shlex

from support.pages import chapter
from support.paths import EXAMPLES, ROOT

from luxloop.scenarios.files.scenario import Scenario
from luxloop.sim.openscenario.action_elements import SUPPORTED
from luxloop.sim.openscenario.catalogs import CATALOGS, KINDS
from luxloop.sim.openscenario.condition_elements import QUANTITIES
from luxloop.sim.openscenario.expressions import _FUNCTIONS
from luxloop.sim.openscenario.openscenario_source import OpenScenarioSource
from luxloop.sim.openscenario.transitions import SHAPES

PAGE = chapter("own-scenario.md", "OpenSCENARIO and OpenDRIVE")


def row(group):
    """Return the names in a row of the table of elements, in both columns."""
    (cells,) = re.findall(rf"^\| {group} \| (.*?) \| (.*?) ?\|$", PAGE, re.MULTILINE)
    return [re.findall(r"`([^`]+)`", cell) for cell in cells]


def test_the_table_lists_what_the_code_supports():
    assert row("conditions by entity")[0] == list(QUANTITIES)
    assert all(action in SUPPORTED for action in row("actions of events")[0])
    assert row("catalogs")[0] == list(CATALOGS)
    assert row("entities") == [list(CATALOGS.values()), list(KINDS)]
    assert row("dynamics")[0][: len(SHAPES)] == list(SHAPES)
    assert set(_FUNCTIONS) <= set(row("parameters")[1])


def test_the_page_shows_the_whole_example():
    (shown,) = re.findall(r"^```toml\n(description.*?)^```", PAGE, re.DOTALL | re.MULTILINE)
    assert shown == (EXAMPLES / "cut-in.toml").read_text(encoding="utf-8")


def test_the_commands_of_the_page_load_and_start():
    typed = [shlex.split(line) for line in re.findall(r"^luxloop run .*$", PAGE, re.MULTILINE)]
    assert len(typed) == 2
    for _, _, path, *options in typed:
        scenario = Scenario.load(ROOT / path, settings=options[1::2])
        source = OpenScenarioSource(scenario.traffic, scenario.folder, 100.0)
        source.reset(1)
        assert source.step().index == 0
