"""Several keys of a scenario tied to one parameter of a study."""

from pathlib import Path

import pytest

from luxloop.scenarios.errors import StudyError
from luxloop.scenarios.run import device
from luxloop.scenarios.study.design import runs, source
from luxloop.scenarios.study.parameter import TiedKey
from luxloop.scenarios.study.row_store import schema_of
from luxloop.scenarios.study.study_file import Study
from luxloop.scenarios.study.worker import carry_out

SCENE = """\
description = "Two vans, one behind the other."
seed = 1
duration_s = 0.4

[traffic]
kind = "scripted"

[[traffic.actor]]
name = "first van"
kind = "van"
x_m = {first_m}
y_m = 3.5
motion = [{{ kind = "straight", speed_mps = {speed_mps} }}]

[[traffic.actor]]
name = "second van"
kind = "van"
x_m = {second_m}
y_m = 3.5
motion = [{{ kind = "straight", speed_mps = {speed_mps} }}]
"""
STUDY = """\
description = "Gap and speed of two vans."
scenario = "{scenario}"
{more}
[[vary]]
key = "gap_m"
values = [6, 9.5]
sets = [{{ key = "traffic.actor[second van].x_m", offset = 20.0 }}]

[[vary]]
key = "speed_mps"
values = [8.0]
sets = [
    {{ key = "traffic.actor[first van].motion[0].speed_mps" }},
    {{ key = "traffic.actor[second van].motion[0].speed_mps" }},
]
"""


def scene(folder: Path, name: str, first_m: float, second_m: float, speed_mps: float) -> None:
    text = SCENE.format(first_m=first_m, second_m=second_m, speed_mps=speed_mps)
    (folder / f"{name}.toml").write_text(text)


def study(folder: Path, old: str = "", new: str = "", more: str = "", scenario: str = "vans.toml") -> Study:
    scene(folder, "vans", 14.0, 99.0, 1.0)
    text = STUDY.format(scenario=scenario, more=more)
    assert old in text
    (folder / "gap.toml").write_text(text.replace(old, new, 1))
    return Study.load(folder / "gap.toml")


def test_a_run_with_tied_keys_is_the_run_of_the_scenario_that_is_written_by_hand(tmp_path: Path):
    first, second = runs(study(tmp_path), device.SHIPPED)
    assert [run.parameters for run in (first, second)] == [{"gap_m": gap, "speed_mps": 8.0} for gap in (6, 9.5)]
    scene(tmp_path, "by-hand", 14.0, 29.5, 8.0)
    one = 'description = "By hand."\nscenario = "by-hand.toml"\nvary = [{ key = "duration_s", values = [0.4] }]\n'
    (tmp_path / "by-hand-study.toml").write_text(one)
    (by_hand,) = runs(Study.load(tmp_path / "by-hand-study.toml"), device.SHIPPED)
    assert carry_out(second)["trace_hash"] == carry_out(by_hand)["trace_hash"] != carry_out(first)["trace_hash"]
    row = carry_out(first)
    assert (row["gap_m"], row["speed_mps"]) == (6, 8.0)
    assert "traffic.actor[second van].x_m" not in row


def test_the_keys_of_each_combination_have_the_value_times_the_factor_plus_the_offset(tmp_path: Path):
    changed = study(tmp_path, "offset = 20.0", "factor = -0.5, offset = 20.0")
    found = [run.document["traffic"]["actor"] for run in runs(changed, device.SHIPPED)]
    assert [actors[1]["x_m"] for actors in found] == [17, 15.25]
    assert {actor["motion"][0]["speed_mps"] for actors in found for actor in actors} == {8.0}


@pytest.mark.parametrize(
    ("value", "factor", "offset", "expected"),
    [(3, 1.0, 2.0, 5), (3, 0.5, 0.0, 1.5), (3.0, 1.0, 2.0, 5.0), (0.1, 1.0, 0.2, 0.3), ("car", 1.0, 0.0, "car"),
     (True, 1.0, 0.0, True)],
)  # fmt: skip
def test_whole_numbers_stay_whole_and_texts_stay_as_they_are(value, factor, offset, expected):
    found = TiedKey(key="a", factor=factor, offset=offset).value(value)
    assert (found, type(found)) == (expected, type(expected))


def test_parameters_of_a_staged_scene_can_be_tied(tmp_path: Path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(tmp_path)
    (tmp_path / "tied_scene.py").write_text("def scene(ahead_m, behind_m):\n    return {'at': [ahead_m, behind_m]}\n")
    tied = '{ key = "ahead_m" }, { key = "behind_m", factor = -1.0 }, { key = "sensor.sweep", offset = 1 }'
    loaded = study(tmp_path, '{ key = "traffic.actor[second van].x_m", offset = 20.0 }', tied)
    text = (tmp_path / "gap.toml").read_text().replace('"vans.toml"', '"tied_scene:scene"')
    (tmp_path / "gap.toml").write_text(text[: text.rindex("[[vary]]")])
    loaded = Study.load(tmp_path / "gap.toml")
    assert source(loaded)[0]({"gap_m": 6}) == {"at": [6, -6], "sensor": {"sweep": 7}}


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('"gap_m"', '"traffic.gap_m"', r"key = traffic\.gap_m: is only a name beside sets, and sets nothing; give one"),
        ("[6, 9.5]", '["near", "far"]', r"sets traffic\.actor\[second van\]\.x_m: factor and offset need numbers"),
        ("[6, 9.5]", "[true, false]", r"factor and offset need numbers"),
        ("[first van].motion", "[second van].motion", r"speed_mps is set twice by \[\[vary\]\] tables; take it out"),
        ('sets = [{ key = "traffic.actor[second van].x_m"', 'sets = [{ key = "seed"', "seed cannot be varied or fixed"),
        ("offset", "ofset", r"ofset.*unknown key"),
        ("20.0", '"20 m"', r"offset"),
    ],
)  # fmt: skip
def test_mistakes_are_one_line_with_the_remedy(tmp_path: Path, old: str, new: str, message: str):
    with pytest.raises(StudyError, match=message) as raised:
        study(tmp_path, old, new)
    assert "\n" not in str(raised.value)


def test_a_tied_key_cannot_be_fixed(tmp_path: Path):
    with pytest.raises(StudyError, match=r"traffic\.actor\[second van\]\.x_m is both varied and fixed; take it out of"):
        study(tmp_path, more='fixed = { "traffic.actor[second van].x_m" = 3.0 }\n')


@pytest.mark.parametrize("name", ["status", "key", "track.hota"])
def test_a_parameter_with_the_name_of_another_column_is_refused(name):
    with pytest.raises(StudyError, match=f"{name}: rows have a column of this name; give the parameter another key"):
        schema_of({name: [1.0]})
