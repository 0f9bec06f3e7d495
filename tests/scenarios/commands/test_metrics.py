"""`luxloop metrics`: words, JSON, and a line per metric in logs."""

import json
import re

from luxloop.scenarios.cli import main
from luxloop.scenarios.commands.list_scenarios import EXAMPLES
from luxloop.scenarios.metrics.definition import FILTERS, filtered
from luxloop.scenarios.metrics.definitions import DEFINITIONS, find_metric


def printed(capfd, *words):
    assert main(["metrics", *words]) == 0
    return capfd.readouterr().out


def test_json_has_every_metric_and_its_names_can_be_built_from_it(capfd):
    found = json.loads(printed(capfd, "--json"))
    assert [one["name"] for one in found] == list(DEFINITIONS)
    for one in found:
        definition = DEFINITIONS[one["name"]]
        assert (one["unit"], one["better"]) == (definition.unit, definition.better)
        assert one["meaning"] == definition.meaning
        last = {key: values[-1] for key, values in one["parameters"].items()}
        chosen = {key: {"class": "truck", "view": "rear", "actor": "car.1"}.get(key, "0-30") for key in one["filters"]}
        selection = find_metric(filtered(one["name"], **last, **{f"{key}_": value for key, value in chosen.items()}))
        assert (dict(selection.parameters), dict(selection.filters)) == (last, {key: chosen[key] for key in chosen})


def test_words_are_of_the_name_or_of_the_sentence(capfd):
    names = [one["name"] for one in json.loads(printed(capfd, "--json", "FLIP", "moving"))]
    assert names == ["track.heading_flip_rate"]
    assert "track.heading_unflipped_mean_deg" in printed(capfd, "flipped")
    assert json.loads(printed(capfd, "--json", "no such word")) == []
    assert printed(capfd, "no such word").split()[:4] == ["name", "unit", "better", "meaning"]


def test_a_log_has_a_line_per_metric_and_a_blank_line_between_families(capfd):
    table = printed(capfd).partition("\n\nmethod= ")[0]
    parts = [part.splitlines() for part in table.partition("\n")[2].split("\n\n")]
    families = [{line.partition(".")[0] for line in part} for part in parts if part]
    assert [len(family) for family in families] == [1] * len(families)
    rows = [line for part in parts for line in part]
    for line, (name, definition) in zip(rows, DEFINITIONS.items(), strict=True):
        assert line.split(maxsplit=2)[:2] == [name, definition.unit]
        assert definition.meaning in line
        assert all(f"{key}=" in line for key in definition.parameters)


def test_values_of_parameters_and_all_filters_are_shown_below(capfd):
    text = printed(capfd, "mma.selected")
    assert text.splitlines()[-4:-2] == [
        "mode= stationary, cv, ca",
        "model= stationary, cv, ca, ctrv, ctra, two-axle",
    ]
    assert "group= target (default), vehicle, bicycle, person" in printed(capfd, "emergence.delay")
    assert all(f"{key}=" in EXAMPLES for key in FILTERS)
    (name,) = re.findall(r"\w+\.\w+\{.*\}", EXAMPLES)
    assert find_metric(name).name == name
