"""Scenario files: shipped files load, errors are one line, the committed schema is current."""

import json
from pathlib import Path

import pytest
from support.paths import ROOT

from luxloop.scenarios.errors import ScenarioError
from luxloop.scenarios.files import shipped
from luxloop.scenarios.files.scenario import DEFAULT_SEED, Scenario, schema_text

SCHEMA = ROOT / "scenarios" / "schema" / "scenario.schema.json"

VALID = """\
description = "Nothing happens."
duration_s = 3
[traffic]
kind = "sumo"
net = "a.net.xml"
routes = ["a.rou.xml"]
"""

SCRIPTED = """\
description = "A car drives on."
duration_s = 3
[traffic]
kind = "scripted"
[[traffic.actor]]
x_m = 12
y_m = 3
motion = [{kind = "straight", speed_mps = 5}]
"""


def load(folder: Path, text: str, **overrides: object) -> Scenario:
    path = folder / "written.toml"
    path.write_text(text, encoding="utf-8")
    return Scenario.load(path, overrides)


def test_defaults_are_filled_in_and_integers_are_accepted_as_floats(tmp_path):
    scenario = load(tmp_path, VALID)
    assert (scenario.name, scenario.folder) == ("written", tmp_path)
    assert (scenario.seed, scenario.duration_s, str(scenario.rig)) == (DEFAULT_SEED, 3.0, "srx_six_lux")
    assert scenario.noise.range.enabled
    assert scenario.traffic.routes == ["a.rou.xml"]


def test_overrides_replace_keys_of_the_file_and_are_validated(tmp_path):
    assert load(tmp_path, "seed = 5\n" + VALID, seed=7, duration_s=2.5).seed == 7
    with pytest.raises(ScenarioError, match=r"duration_s = -1\.0: should be greater than 0"):
        load(tmp_path, VALID, duration_s=-1.0)


def test_stage_settings_reach_their_stage(tmp_path):
    scenario = load(tmp_path, VALID + "[noise]\nrange = {enabled = false}\n[grading]\npoints_min = 3")
    assert not scenario.noise.range.enabled
    assert scenario.noise.dropout.enabled
    assert scenario.grading.points_min == 3


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (VALID.replace("= 3", '= "3"'), 'duration_s = "3": should be a valid number'),
        (VALID.replace("= 3", "= true"), "duration_s = true: should be a valid number"),
        (VALID.replace("= 3", "= -3"), "duration_s = -3: should be greater than 0"),
        (VALID.replace("= 3", "= 0"), "duration_s = 0: should be greater than 0"),
        (VALID.replace("= 3", "= inf"), "duration_s = Infinity: should be a finite number"),
        (VALID.replace("= 3", "= 1979-05-27"), 'duration_s = "1979-05-27": should be a valid number'),
        (VALID.replace('"Nothing happens."', '""'), 'description = "": String should have at least 1 character'),
        (VALID.replace("duration_s = 3", ""), "duration_s is missing; add it"),
        ("seed = -1\n" + VALID, "seed = -1: should be greater than or equal to 0"),
        ("seed = 1.5\n" + VALID, "seed = 1.5: should be a valid integer"),
        ("durations_s = 3\n" + VALID, "durations_s = 3: unknown key; did you mean duration_s?"),
        (VALID.replace("net =", "nett ="), 'traffic.nett = "a.net.xml": unknown key; did you mean net?'),
        (VALID + "zzz = 1", "traffic.zzz = 1: unknown key; known here: additional, begin_s, building_height_m, config"),
        (VALID.replace('"sumo"', '"suumo"'), "traffic.kind = \"suumo\": should be one of 'sumo', 'highway-env'"),
        (VALID.replace('kind = "sumo"', ""), 'traffic.kind is missing; add it: one of "sumo", "highway-env"'),
        (VALID.replace("[traffic]", "[[traffic]]"), "traffic = [{"),
        (VALID + "[noise]\nrange.sigma = 1", "noise.range.sigma = 1: unknown key; did you mean sigma_scale?"),
        (
            VALID + "[noise]\nrange.sigma_scale = -1",
            "noise.range: sigma_scale = -1.0: must not be negative; use 0 for none",
        ),
        (VALID + "[rig]\nname = 'a'\nfile = 'b'", "rig: give either name (a shipped rig) or file"),
        (VALID + "[expect]\n'fit.best.headin' = {max = 1}", 'expect."fit.best.headin": unknown metric; did you mean'),
        (VALID + "[expect]\n'track.hota' = {}", 'expect."track.hota": no limit: give min, max or both'),
        (VALID + "[expect]\n'track.hota' = {min = 2, max = 1}", 'expect."track.hota": min = 2.0 is above max = 1.0'),
        (VALID + "[expect]\n'track.hota' = {mx = 1}", 'expect."track.hota".mx = 1: unknown key; did you mean max?'),
        (VALID + "[expect]\n'track.hota' = 1", 'expect."track.hota" = 1: should be a table'),
        (SCRIPTED + "kind = 'tram'", "traffic.actor[0].kind = \"tram\": should be 'car', 'suv'"),
        (SCRIPTED + "size_m = [1, 2]", "traffic.actor[0].size_m[2] is missing; add it"),
        (SCRIPTED + "size_m = [1, 2, -1]", "traffic.actor[0]: size_m needs a positive length, width and height"),
        # the alternatives of a union must not be mixed up
        (SCRIPTED.replace("= 5", "= ''"), 'traffic.actor[0].motion[0].speed_mps = "": should be a valid number'),
        (SCRIPTED.replace("speed_mps", "speed"), "traffic.actor[0].motion[0].speed = 5: unknown key; did you mean sp"),
        (
            SCRIPTED.replace('"straight"', '"strait"'),
            "traffic.actor[0].motion[0].kind = \"strait\": should be 'static' or",
        ),
        # the kind of a motion is not guessed from its keys
        (
            SCRIPTED.replace('kind = "straight", ', ""),
            'traffic.actor[0].motion[0].kind is missing; add it: one of "static", "spin", "straight", "arc"',
        ),
        (SCRIPTED.replace('kind = "straight", speed_mps = 5', ""), "traffic.actor[0].motion[0].kind is missing"),
        (VALID + "[rig", "not TOML: Expected ']' at the end of a table declaration"),
        ("a\n", "not TOML: Expected '=' after a key in a key/value pair (at line 1, column 2)"),
    ],
)
def test_an_error_is_one_line_with_file_key_value_and_remedy(tmp_path, text, message):
    with pytest.raises(ScenarioError) as raised:
        load(tmp_path, text)
    printed = str(raised.value)
    assert printed.startswith(f"{tmp_path / 'written.toml'}: {message}")
    assert "\n" not in printed


def test_a_long_value_is_cut_in_the_message(tmp_path):
    with pytest.raises(ScenarioError) as raised:
        load(tmp_path, VALID.replace("= 3", f"= {list(range(1000))}"))
    assert len(str(raised.value)) < len(str(tmp_path)) + 150


def test_a_file_that_cannot_be_read_is_an_error(tmp_path):
    (tmp_path / "latin.toml").write_bytes(b'description = "caf\xe9"')
    for name, message in {
        "missing.toml": "No such file",
        ".": "Is a directory",
        "latin.toml": "not UTF-8",
    }.items():
        with pytest.raises(ScenarioError, match=message):
            Scenario.load(tmp_path / name)


@pytest.mark.parametrize("name", shipped.paths())
def test_every_shipped_scenario_loads_and_has_a_description(name):
    scenario = Scenario.load(shipped.find(name))
    assert scenario.description.endswith(".")


def test_every_shipped_scenario_has_expectations():
    assert [name for name, path in shipped.paths().items() if not Scenario.load(path).expect] == []


def test_no_two_shipped_scenarios_share_a_name():
    assert len(shipped.paths()) == len(list(shipped.CATALOG.glob("*/*.toml"))) >= 6


def test_an_unknown_name_suggests_close_ones_and_a_path_is_kept():
    with pytest.raises(ScenarioError, match="sumo-crosing: no such scenario; did you mean sumo-crossing"):
        shipped.find("sumo-crosing")
    assert shipped.find("elsewhere/own.toml") == Path("elsewhere/own.toml")


def test_the_committed_schema_is_current():
    """To update it: `luxloop schema > scenarios/schema/scenario.schema.json`."""
    assert SCHEMA.read_text(encoding="utf-8") == schema_text()


def test_the_schema_forbids_unknown_keys_everywhere():
    schema = json.loads(schema_text())
    tables = [schema, *schema["$defs"].values()]
    assert all(table["additionalProperties"] is False for table in tables if "properties" in table)


def test_all_errors_of_a_file_are_in_one_message(tmp_path):
    path = tmp_path / "a.toml"
    path.write_text(
        'sead = 1\ndescription = "x"\nduration_s = -1\n[traffic]\nkind = "scripted"\n'
        'actor = [{ x_m = "a", y_m = 0, motion = [{ kind = "strait" }, { kind = "straight", speed_mps = "q" }] }]\n'
    )
    with pytest.raises(ScenarioError) as caught:
        Scenario.load(path)
    assert str(caught.value) == (
        f"{path}: 5 errors: (1) sead = 1: unknown key; did you mean seed? "
        "(2) duration_s = -1: should be greater than 0 "
        '(3) traffic.actor[0].x_m = "a": should be a valid number '
        "(4) traffic.actor[0].motion[0].kind = \"strait\": should be 'static' or 'spin' or 'straight' or 'arc' or "
        "'stop-and-go' or 'lane-change' "
        '(5) traffic.actor[0].motion[1].speed_mps = "q": should be a valid number'
    )


def test_a_message_of_many_errors_ends_with_their_number(tmp_path):
    path = tmp_path / "a.toml"
    path.write_text("\n".join(f"key_{number} = {number}" for number in range(20)))
    with pytest.raises(ScenarioError, match=r"23 errors: \(1\) key_0 = 0: unknown key; .* and 17 more$"):
        Scenario.load(path)
