"""What every scenario that ships has: a reason, needs and units, and a place in a family; the mix of the whole."""

import tomllib
from collections import Counter

import pytest

from scenarios.files import shipped
from scenarios.files.expect import METRICS
from scenarios.files.scenario import Scenario

SHIPPED = {name: Scenario.load(path) for name, path in shipped.paths().items()}
FAMILIES = {"highway", "urban", "occlusion", "faults", "noise", "fitting", "adversary"}

each = pytest.mark.parametrize("scenario", SHIPPED.values(), ids=SHIPPED)


@each
def test_it_says_what_happens_and_why(scenario):
    for sentence in (scenario.description, scenario.reason):
        assert sentence.endswith(".")
        assert sentence[0].isupper() or sentence.startswith("highway-env")


@each
def test_every_limit_has_its_unit_and_the_need_behind_it(scenario):
    assert scenario.expect, "a scenario that expects nothing tests nothing"
    for metric, limit in scenario.expect.items():
        assert limit.unit == METRICS[metric], metric
        assert limit.need, metric


@each
def test_a_known_failure_tells_its_cause_with_a_figure(scenario):
    for metric, limit in scenario.expect.items():
        if limit.known_failure:
            assert any(letter.isdigit() for letter in limit.known_failure), metric


def test_the_mix():
    assert len(SHIPPED) >= 36
    assert {scenario.folder.name for scenario in SHIPPED.values()} == FAMILIES
    simulators = Counter(scenario.traffic.kind for scenario in SHIPPED.values())
    assert simulators["sumo"] >= 12
    assert simulators["highway-env"] >= 6
    smoke = {scenario.folder.name for scenario in SHIPPED.values() if scenario.suite == "smoke"}
    assert smoke == FAMILIES, "the smoke set has one of each family at least"


def test_names_are_unlike_in_all_families():
    # `luxloop run NAME` finds a scenario by its name alone.
    assert len(SHIPPED) == len(list(shipped.CATALOG.glob("*/*.toml")))


def test_the_readers_of_the_catalog_find_no_other_toml():
    for path in shipped.CATALOG.rglob("*.toml"):
        assert "traffic" in tomllib.loads(path.read_text(encoding="utf-8")), path
