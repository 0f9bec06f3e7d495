"""Runs of a study: grids, samples, seeds and keys."""

import pickle
import sys
from pathlib import Path

import numpy as np
import pytest
from support.paths import without_checkouts
from support.sweeps import small_study

from luxloop.scenarios.errors import StudyError
from luxloop.scenarios.files.shipped import CATALOG
from luxloop.scenarios.run import device
from luxloop.scenarios.study.design import combinations, parse, runs, with_values
from luxloop.scenarios.study.study_file import Study, find

GRID = """
[[vary]]
key = "a"
low = 0
high = 1
steps = 5

[[vary]]
key = "b"
low = 1
high = 100
steps = 3
scale = "log"
"""
HYPERCUBE = """
samples = 10
vary = [{ key = "a", low = 0, high = 10 }, { key = "b", low = 1, high = 1024, scale = "log" }]
"""
ONE = 'vary = [{ key = "a", values = [1] }]\n'
HEAD = 'description = "A study."\nscenario = "truck-shadow"\n'


def study(folder: Path, text: str) -> Study:
    path = folder / "study.toml"
    path.write_text(HEAD + text)
    return Study.load(path)


def test_runs_are_ordered_by_combination_then_seed(tmp_path: Path):
    found = runs(Study.load(small_study(tmp_path, seeds=3)), device.SHIPPED)
    assert [run.seed for run in found] == [1, 2, 3] * 4
    assert [run.parameters["noise.dropout.random_rate"] for run in found] == [0.0] * 3 + [0.1] * 3 + [0.2] * 3 + [
        0.3
    ] * 3
    assert [run.index for run in found] == list(range(12))
    assert len({run.key for run in found}) == 12
    assert {run.document["seed"] for run in found} == {1, 2, 3}


def test_ranges_are_spaced_linearly_or_logarithmically(tmp_path: Path):
    points = combinations(study(tmp_path, GRID))
    assert sorted({point["a"] for point in points}) == [0.0, 0.25, 0.5, 0.75, 1.0]
    assert sorted({point["b"] for point in points}) == [1.0, 10.0, 100.0]
    assert len(points) == 15


def test_a_latin_hypercube_has_one_sample_per_stratum_and_is_reproducible(tmp_path: Path):
    sampled = study(tmp_path, HYPERCUBE)
    points = combinations(sampled)
    assert sorted(int(point["a"]) for point in points) == list(range(10))
    assert sorted(int(np.log2(point["b"])) for point in points) == list(range(10))
    assert combinations(sampled) == points


def test_sampled_combinations_are_unique(tmp_path: Path):
    points = combinations(study(tmp_path, 'samples = 20\nvary = [{ key = "a", values = [1, 2] }]'))
    assert sorted(point["a"] for point in points) == [1, 2]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ('seeds = [1, 1]\nvary = [{ key = "a", values = [1] }]', r"\[1, 1\]: contains a duplicate"),
        ('vary = [{ key = "a", values = [1, 1] }]', "duplicate"),
        ('vary = [{ key = "a", values = [] }]', "at least one"),
        ('vary = [{ key = "a", values = [1] }, { key = "a", values = [2] }]', "a key is varied twice"),
        ('fixed = { a = 1 }\nvary = [{ key = "a", values = [1] }]', "a is both varied and fixed"),
        ('vary = [{ key = "seed", values = [1] }]', "seed cannot be varied"),
        ('vary = [{ key = "a", low = 1, high = 2 }]', "a: a range without steps"),
        ('vary = [{ key = "a", low = 2, high = 1, steps = 2 }]', "low below high"),
        ('vary = [{ key = "a", low = 0, high = 1, steps = 2, scale = "log" }]', "must be above 0"),
        ('vary = [{ key = "a", low = 0, high = 1, values = [1] }]', "not both"),
        (ONE + 'curve = [{ metric = "track.hota", against = "b" }]', "b: neither a varied parameter nor a metric"),
        (ONE + 'curve = [{ metric = "track.hot", against = "a" }]', "metric.*track.hot"),
        ("vary = []", "vary"),
    ],
)  # fmt: skip
def test_an_invalid_study_is_a_one_line_error(tmp_path: Path, text: str, message: str):
    with pytest.raises(StudyError, match=message) as raised:
        study(tmp_path, text)
    assert "\n" not in str(raised.value)
    assert "study.toml" in str(raised.value)


def test_a_study_is_found_by_name_or_path():
    assert find("fits").name == "fits.toml"
    assert find("my/study.toml") == Path("my/study.toml")
    with pytest.raises(StudyError, match="fitss: no such study; did you mean fits"):
        find("fitss")
    with pytest.raises(StudyError, match="xyz: no such study; see luxloop list --studies"):
        find("xyz")


def test_too_many_runs_are_refused_before_they_are_created(tmp_path: Path):
    vast = study(tmp_path, 'seeds = 1000000\nvary = [{ key = "duration_s", low = 1, high = 2, steps = 1000000 }]')
    with pytest.raises(StudyError, match="1000000000000 runs, more than 1000000; give fewer"):
        runs(vast, device.SHIPPED)


def test_a_portable_run_contains_no_local_path(tmp_path: Path):
    shadow = study(tmp_path, 'vary = [{ key = "duration_s", values = [1.0] }]')
    run = runs(shadow, device.SHIPPED)[0]
    assert run.path == CATALOG / "occlusion" / "truck-shadow.toml"
    task = pickle.dumps(run.portable())
    assert str(CATALOG).encode() not in task
    assert len(task) < 5000
    assert CATALOG / run.portable().path == run.path
    assert run.portable().key == run.key


def test_the_key_of_a_run_depends_on_every_input(tmp_path: Path):
    text = 'seeds = [{seed}]\nvary = [{{ key = "duration_s", values = [{duration}] }}]'
    first, other_seed, other_value = (
        runs(study(tmp_path, text.format(seed=seed, duration=duration)), device.SHIPPED)[0].key
        for seed, duration in ((1, 1.0), (2, 1.0), (1, 2.0))
    )
    other_tracker = runs(study(tmp_path, text.format(seed=1, duration=1.0)), "my:Tracker")[0].key
    assert len({first, other_seed, other_value, other_tracker}) == 4


def test_a_custom_scene_function_gets_its_parameters(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    (tmp_path / "my_scene.py").write_text(
        "def scene(gap_m):\n    return {'description': 'A gap.', 'duration_s': 1.0, 'traffic': {'kind': 'scripted', "
        "'actor': [{'x_m': gap_m, 'y_m': 3.0}]}}\n"
    )
    monkeypatch.chdir(tmp_path)
    path = tmp_path / "study.toml"
    text = 'description = "."\nscenario = "my_scene:scene"\nvary = [{ key = "gap_m", values = [8.0, 9.0] }]\n'
    path.write_text(text + 'fixed = { "noise.dropout.random_rate" = 0.2 }')
    found = runs(Study.load(path), device.SHIPPED)
    assert [run.document["traffic"]["actor"][0]["x_m"] for run in found] == [8.0, 9.0]
    assert found[0].document["noise"] == {"dropout": {"random_rate": 0.2}}
    path.write_text(text.replace('"gap_m"', '"gap"'))
    with pytest.raises(StudyError, match=r"my_scene:scene: .*; it takes \(gap_m\)"):
        runs(Study.load(path), device.SHIPPED)
    path.write_text(text.replace("my_scene:scene", "my_scene:scne"))
    with pytest.raises(StudyError, match="has no attribute 'scne'; name a module and a function in it"):
        runs(Study.load(path), device.SHIPPED)


def test_a_scene_of_a_former_module_names_the_new_one(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "path", without_checkouts(sys.path))
    path = tmp_path / "study.toml"
    scene = "scenarios.study.staged:hidden_behind_wall"
    path.write_text(f'description = "."\nscenario = "{scene}"\nvary = [{{ key = "gap_m", values = [8.0] }}]\n')
    message = r"No module named 'scenarios.*; luxloop's module is luxloop\.scenarios\.study\.staged now; name a module"
    with pytest.raises(StudyError, match=message):
        runs(Study.load(path), device.SHIPPED)


def test_a_scene_whose_module_fails_to_import_is_one_line(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "renamed_scenes.py").write_text("raise ImportError('renamed_scenes is scenes now')")
    path = tmp_path / "study.toml"
    path.write_text('description = "."\nscenario = "renamed_scenes:f"\nvary = [{ key = "gap_m", values = [8.0] }]\n')
    with pytest.raises(StudyError, match="scenario = renamed_scenes:f: renamed_scenes is scenes now; name a module"):
        runs(Study.load(path), device.SHIPPED)


DOCUMENT = {"seed": 1, "traffic": {"actor": [{"name": "car", "motion": [{"speed_mps": 3}]}, {"name": "bus"}]}}


@pytest.mark.parametrize(
    ("key", "steps"),
    [
        ("noise.dropout.random_rate", ("noise", "dropout", "random_rate")),
        ("traffic.actor[hidden car].motion[0].x_m", ("traffic", "actor", "[hidden car]", "motion", "[0]", "x_m")),
        ('expect."track.id_switches".max', ("expect", "track.id_switches", "max")),
    ],
)
def test_keys_are_split_into_steps(key: str, steps: tuple[str, ...]):
    assert parse(key) == steps


def test_values_are_set_in_a_copy():
    changed = with_values(DOCUMENT, {"traffic.actor[car].motion[0].speed_mps": 5, "noise.dropout.enabled": True})
    assert changed["traffic"]["actor"][0]["motion"] == [{"speed_mps": 5}]
    assert changed["noise"] == {"dropout": {"enabled": True}}
    assert DOCUMENT["traffic"]["actor"][0]["motion"] == [{"speed_mps": 3}]


@pytest.mark.parametrize(
    "key",
    [
        "",
        ".",
        "a..b",
        "a]b",
        "traffic.actor[2].x_m",
        "traffic.actor[tram].x_m",
        "traffic[0]",
        "seed.x",
        "traffic.actor.x",
    ],
)
def test_a_key_that_does_not_exist_is_an_error(key: str):
    with pytest.raises(StudyError, match=r"not a valid key|no item|is not inside a table"):
        with_values(DOCUMENT, {key: 1})
