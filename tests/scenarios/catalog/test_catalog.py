"""Properties of all shipped scenarios: reason, needs, units and family; composition of the catalog."""

import tomllib
from collections import Counter
from functools import cache

import pytest

from luxloop.scenarios.files import shipped
from luxloop.scenarios.files.scenario import Scenario
from luxloop.scenarios.metrics.definitions import find_metric

PATHS = shipped.paths()
FAMILIES = {"highway", "urban", "occlusion", "faults", "noise", "fitting", "adversary"}


@cache
def load(name):
    return Scenario.load(PATHS[name])


@pytest.fixture(params=PATHS)
def scenario(request):
    return load(request.param)


def test_description_and_reason_are_sentences(scenario):
    for sentence in (scenario.description, scenario.reason):
        assert sentence.endswith(".")
        assert sentence[0].isupper() or sentence.startswith("highway-env")


def test_every_limit_has_a_unit_and_a_need(scenario):
    assert scenario.expect, "the scenario has no expectations"
    for metric, limit in scenario.expect.items():
        assert limit.unit == find_metric(metric).unit, metric
        assert limit.need, metric


def test_known_failures_explain_the_cause_with_a_number(scenario):
    for metric, limit in scenario.expect.items():
        if limit.known_failure:
            assert any(letter.isdigit() for letter in limit.known_failure), metric


def test_the_composition_of_the_catalog():
    scenarios = [load(name) for name in PATHS]
    assert len(scenarios) >= 36
    assert {scenario.folder.name for scenario in scenarios} == FAMILIES
    simulators = Counter(scenario.traffic.kind for scenario in scenarios)
    assert simulators["sumo"] >= 12
    assert simulators["highway-env"] >= 6
    smoke = {scenario.folder.name for scenario in scenarios if scenario.suite == "smoke"}
    assert smoke == FAMILIES, "the smoke suite should contain every family"


def test_names_are_unique_across_families():
    # `luxloop run NAME` looks up scenarios by name, without the family.
    assert len(PATHS) == len(list(shipped.CATALOG.glob("*/*.toml")))


def test_the_catalog_contains_no_other_toml_files():
    for path in shipped.CATALOG.rglob("*.toml"):
        assert "traffic" in tomllib.loads(path.read_text(encoding="utf-8")), path
