"""`--set KEY=VALUE`: keys as in error messages, TOML values, and errors on one line."""

import pytest
from support import short_run

from luxloop.scenarios.errors import ScenarioError
from luxloop.scenarios.files.scenario import Scenario
from luxloop.scenarios.files.settings import applied, parse


@pytest.mark.parametrize(
    ("text", "key", "value"),
    [
        ("seed=7", ["seed"], 7),
        ("noise.rain.rate_mm_per_h=2.5", ["noise", "rain", "rate_mm_per_h"], 2.5),
        ("noise.ideal=true", ["noise", "ideal"], True),
        ("traffic.actor[1].x_m=-3", ["traffic", "actor", 1, "x_m"], -3),
        ('expect."track.hota".min=0.5', ["expect", "track.hota", "min"], 0.5),
        ("tracker.filters.models=['cv', 'ca']", ["tracker", "filters", "models"], ["cv", "ca"]),
        ("rig.name=front-four", ["rig", "name"], "front-four"),
        ('rig.name="12"', ["rig", "name"], "12"),
        ("description=a = b", ["description"], "a = b"),
        ("description=", ["description"], ""),
        ("seed=1\nduration_s=2", ["seed"], "1\nduration_s=2"),
        ("rig={name = 'x'}", ["rig"], {"name": "x"}),
    ],
)
def test_key_and_value(text, key, value):
    assert parse(text) == (key, value)


@pytest.mark.parametrize("text", ["", "seed", "=3", ".seed=3", "a..b=1", "[0]=1", "a[x]=1", "a b=1", 'a."b=1', "a[1=2"])
def test_text_that_is_no_setting_is_refused(text):
    with pytest.raises(ScenarioError, match=r"^--set .*: should be KEY=VALUE, as in --set noise\.rain"):
        parse(text)


def test_keys_are_set_in_order_and_missing_tables_are_made():
    document = {"traffic": {"actor": [{"x_m": 1}, {"x_m": 2}]}}
    changed = applied(document, ["traffic.actor[1].x_m=5", "noise.rain.enabled=true", "noise.rain.enabled=false"])
    assert changed == {"traffic": {"actor": [{"x_m": 1}, {"x_m": 5}]}, "noise": {"rain": {"enabled": False}}}
    assert document == {"traffic": {"actor": [{"x_m": 1}, {"x_m": 2}]}}


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("seed.x=1", "seed is a single value; give a key"),
        ("actor.x_m=1", r"actor is a list; give the number of an item, actor\[0\]"),
        ("actor[2].x_m=1", "actor has 2 items; give a number below that"),
        ("traffic[0]=1", "traffic is a table"),
    ],
)
def test_key_that_does_not_fit_the_document_is_refused(text, message):
    document = {"seed": 1, "actor": [{}, {}], "traffic": {}}
    with pytest.raises(ScenarioError, match=f"^--set .*: {message}"):
        applied(document, [text])


def test_scenario_has_the_set_values_and_validates_them(tmp_path):
    path = short_run.write(tmp_path)
    scenario = Scenario.load(path, {"seed": 9}, ["traffic.actor[0].x_m=11", "noise.ideal=true", "seed=5"])
    assert (scenario.seed, scenario.traffic.actor[0].x_m, scenario.noise.ideal) == (9, 11.0, True)
    assert scenario.settings == ("traffic.actor[0].x_m=11", "noise.ideal=true", "seed=5")
    with pytest.raises(
        ScenarioError, match=r"short\.toml: noise\.rain\.rat = 1: unknown key; known here: .*rate_mm_per_h"
    ):
        Scenario.load(path, {}, ["noise.rain.rat=1"])


def test_known_failures_have_no_figures_in_a_changed_scenario(tmp_path):
    limit = '[expect]\n"track.hota" = { min = 0.99, known_failure = "0.5: too few frames" }\n'
    path = short_run.write(tmp_path, short_run.TEXT + limit)

    def figure(*settings):
        return Scenario.load(path, {}, settings).expect["track.hota"].known_failure

    assert figure() == figure("seed=4") == "0.5: too few frames"
    assert figure("noise.ideal=true") != figure()
