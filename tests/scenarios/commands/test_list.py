"""`luxloop list`: filters, JSON, and a line per scenario in logs."""

import json
import tomllib
from pathlib import Path

import pytest

from luxloop.scenarios.cli import main
from luxloop.scenarios.files import shipped


def listed(capfd, *arguments):
    assert main(["list", "--json", *arguments]) == 0
    return json.loads(capfd.readouterr().out)


def test_json_has_every_scenario_with_its_file(capfd):
    found = listed(capfd)
    assert [entry["name"] for entry in found] == list(shipped.paths())
    for entry in found:
        document = tomllib.loads(Path(entry["path"]).read_text(encoding="utf-8"))
        assert entry["description"] == document["description"]
        assert (entry["kind"], entry["duration_s"]) == (document["traffic"]["kind"], document["duration_s"])
        assert entry["suite"] == document.get("suite", "full")


def test_filters_of_family_kind_suite_and_words(capfd):
    everything = listed(capfd)
    urban = listed(capfd, "--family", "urban")
    assert urban == [entry for entry in everything if entry["family"] == "urban"]
    scripted = listed(capfd, "--kind", "scripted", "--family", "occlusion")
    assert scripted
    assert {(entry["kind"], entry["family"]) for entry in scripted} == {("scripted", "occlusion")}
    assert {entry["suite"] for entry in listed(capfd, "--suite", "smoke")} == {"smoke"}
    assert {entry["name"] for entry in listed(capfd, "TRUCK", "beside")} >= {"truck-shadow", "truck-shadow-1s"}
    assert listed(capfd, "no such word") == []


def test_studies_have_no_traffic(capfd):
    names = {entry["name"] for entry in listed(capfd, "--studies", "occlusion")}
    assert "occlusion" in names
    assert names < set(shipped.studies())


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--family", "urbn"], "--family urbn: no such family; give one of adversary"),
        (["--kind", "car"], "--kind car: no such kind; give one of highway-env"),
        (["--studies", "--kind", "sumo"], "--kind sumo: studies have none"),
    ],
)
def test_unknown_filter_is_one_line(arguments, message, capfd):
    assert main(["list", *arguments]) == 2
    out, err = capfd.readouterr()
    assert (out, err.count("\n")) == ("", 1)
    assert message in err


def test_log_has_a_line_per_scenario_with_its_whole_description(capfd):
    assert main(["list"]) == 0
    lines = capfd.readouterr().out.splitlines()
    assert len(lines) == 1 + len(shipped.paths())
    for entry, line in zip(shipped.entries(), lines[1:], strict=True):
        assert line.split(maxsplit=2) == [entry.family, entry.name, entry.description]
