"""Parts of the search: sizes, scores, initial trials, bisection, reductions, and paths in the scenario file."""

import tomllib
from pathlib import Path
from types import SimpleNamespace

import pytest
from support.few import few
from support.optional import need

need("search")

from hypothesis import given
from hypothesis import strategies as st
from support.stub_trackers import Forgetful

from luxloop.scenarios.files.expect import Limit
from luxloop.scenarios.files.scenario import Scenario
from luxloop.scenarios.files.shipped import paths, studies
from luxloop.scenarios.run import device
from luxloop.scenarios.search import adversary, reductions
from luxloop.scenarios.search.evaluator import Evaluator, distance, score, size
from luxloop.scenarios.search.optimise import Disturbance, initial_trials
from luxloop.scenarios.search.reductions import HALVINGS, shrink, towards_neutral
from luxloop.scenarios.study.design import source
from luxloop.scenarios.study.parameter import Parameter
from luxloop.scenarios.study.row_store import RowStore
from luxloop.scenarios.study.scenes.hidden_vehicles import hidden_behind_wall
from luxloop.scenarios.study.study_file import Search, Study
from luxloop.sensor_model.noise.noise_config import KINDS

LINEAR = Parameter(key="a", low=-1.0, high=3.0, neutral=0.0)
SPEED = Parameter(key="b", low=0.0, high=100.0, neutral=0.0)
LOG = Parameter(key="b", low=1.0, high=100.0, neutral=100.0, scale="log")
WORDS = Parameter(key="c", values=["keeps", "brakes", "turns"], neutral="keeps")
COUNTS = Parameter(key="d", values=[0, 1, 4], neutral=0)


def test_distances_by_hand():
    """Scaled by the distance to the farther end: 3 for -1 to 3 about 0, log 100 for 1 to 100 about 100."""
    assert distance(LINEAR, -1.0) == pytest.approx(1 / 3)
    assert distance(LINEAR, 3.0) == 1.0
    assert distance(LOG, 10.0) == pytest.approx(0.5)
    assert [distance(WORDS, word) for word in ("keeps", "brakes", "turns")] == [0.0, 1.0, 1.0]
    assert [distance(COUNTS, count) for count in (0, 1, 4)] == [0.0, 0.25, 1.0]
    assert size([LINEAR, WORDS], {"a": 1.5, "c": "brakes"}) == pytest.approx(0.75)


@given(value=st.floats(-1e6, 1e6), other=st.floats(-1e6, 1e6), a=st.floats(0.01, 1.0), b=st.floats(0.01, 1.0))
def test_scores_of_failures_are_below_passes_and_passes_below_missing_values(value, other, a, b):
    limit = Limit(min=-3.0, max=5.0)
    scores = {True: [], False: []}
    for v, disturbance in ((value, a), (other, b)):
        scores[limit.holds(v)].append(score(limit, v, disturbance))
    assert all(s <= 1.0 for s in scores[False])
    assert all(1.0 < s < score(limit, None, a) for s in scores[True] if a < 1.0 and b < 1.0)


def test_a_metric_closer_to_its_limit_has_a_better_score():
    limit = Limit(max=10.0)
    assert score(limit, 9.0, 0.5) < score(limit, 2.0, 0.5)


@given(threshold=st.floats(0.001, 2.9), found=st.floats(0.0, 1.0))
def test_bisection_ends_just_beyond_the_threshold(threshold, found):
    """For a monotonic failure the result fails, within the last bisection step and the rounding to three digits."""
    value = threshold + found * (3.0 - threshold)
    back = towards_neutral(LINEAR, value, lambda tried: tried >= threshold)
    assert threshold <= back <= value + 0.005
    assert back - threshold <= value / 2**HALVINGS + 0.015


def test_neutral_is_preferred_if_it_fails():
    assert towards_neutral(LINEAR, 2.0, always) == 0.0
    assert towards_neutral(WORDS, "turns", lambda tried: tried == "turns") == "turns"


def test_the_listed_value_nearest_to_neutral_that_fails_is_kept():
    assert towards_neutral(COUNTS, 4, lambda tried: tried >= 1) == 1
    assert towards_neutral(COUNTS, 4, lambda tried: tried >= 2) == 4


def always(*tried):
    del tried
    return True


def scene():
    return tomllib.loads(
        """
        description = "x"
        duration_s = 1.0
        [traffic]
        kind = "scripted"
        actor = [{ name = "a", x_m = 9, y_m = 0 }, { x_m = -9, y_m = 0 }, { name = "c", x_m = 0, y_m = 9 }]
        obstacle = [{ corners_m = [[1, 9], [2, 9]] }, { corners_m = [[5, 9], [6, 9]] }]
        [noise.attitude]
        enabled = true
        pitch_deg = 1.0
        """
    )


def test_an_actor_or_obstacle_is_removed_by_index_from_the_end():
    """Removal from the front would shift the indices and remove another item than was tried."""
    applied, left = reduce(scene(), reductions.actors, lambda smaller: {9, 0} <= places(smaller))
    assert [actor.get("name") for actor in left["traffic"]["actor"]] == ["a", "c"]
    assert applied == ["without actor 1"]
    _, left = reduce(left, reductions.obstacles, lambda smaller: smaller["traffic"]["obstacle"][:1] != [])
    assert left["traffic"]["obstacle"] == [{"corners_m": [[1, 9], [2, 9]]}]


def test_only_necessary_noise_stays_enabled():
    _, left = reduce(scene(), reductions.noise, lambda smaller: smaller["noise"].get("attitude", {}).get("enabled"))
    noise = Scenario.of(left, Path("x.toml")).noise
    on = [kind for kind in KINDS if getattr(noise, kind).enabled]
    assert on == ["attitude"]
    assert noise.attitude.pitch_deg == 1.0
    applied, left = reduce(scene(), reductions.noise, always)
    assert applied == ["without any noise"]
    assert left["noise"]["attitude"] == {"enabled": False}


def places(document):
    return {actor["x_m"] for actor in document["traffic"]["actor"]}


def reduce(document, kind, still_fails):
    """Apply every reduction of a kind after which the scenario still fails."""
    applied = []
    for reduction in kind(document):
        smaller = reduction.apply(document)
        if smaller != document and still_fails(smaller):
            document = smaller
            applied.append(reduction.what)
    return applied, document


def test_parameters_are_tried_again_after_the_scene_is_reduced(monkeypatch):
    """With unrelated actors both parameters are needed, without them one: a single pass would keep both."""

    def make(parameters, seed):
        return {**scene(), "duration_s": 2.0 + parameters["a"], "sensor": {"power": parameters["b"]}, "seed": seed}

    def fails(document):
        crowded = len(document["traffic"]["actor"]) == 3
        return document["duration_s"] >= 3.0 and (document["sensor"]["power"] >= 50.0 or not crowded)

    study = Study.model_construct(vary=[LINEAR, SPEED])
    monkeypatch.setattr(reductions, "shorten", lambda document, *_: document)
    monkeypatch.setattr(reductions, "KINDS", (reductions.actors, reductions.obstacles))
    found = shrink(study, Disturbance({"a": 3.0, "b": 80.0}, 1, 1.0), SimpleNamespace(fails=fails), make, print)
    assert 3.0 <= found["duration_s"] < 3.1
    assert found["sensor"]["power"] == 0.0
    assert found["traffic"]["actor"] == []


@pytest.mark.parametrize("name", ["sumo-crossing", "cruise-on-tracks", "replayed-crossing", "highway-v0", "ring"])
def test_paths_are_rewritten_for_another_folder(name, tmp_path):
    """Paths in a scenario are relative to its folder, so they must change with it."""
    before = tomllib.loads(paths()[name].read_text())
    (tmp_path / "found").mkdir()
    adversary.write(before, paths()[name], tmp_path / "found" / "moved.toml")
    moved, here = Scenario.load(tmp_path / "found" / "moved.toml"), Scenario.load(paths()[name])
    assert moved.duration_s == here.duration_s
    assert files(moved) == files(here)
    assert moved.expect == here.expect


def files(scenario):
    traffic = scenario.model_dump(mode="json")["traffic"]
    named = [*traffic.get("routes", []), *traffic.get("additional", []), traffic.get("net"), traffic.get("file")]
    found = [(scenario.folder / name).resolve() for name in named if name]
    assert all(path.is_file() for path in found)
    return found


def test_whole_numbers_of_an_expectation_are_written_without_a_fraction():
    limit = Limit(max=0.0, unit="count")
    written = adversary.expectation("track.id_switches", limit, "it fails")
    assert written == {"track.id_switches": {"max": 0, "unit": "count", "known_failure": "it fails"}}
    assert isinstance(written["track.id_switches"]["max"], int)


def forgetful(config):
    """A tracker that gives a reappearing vehicle a new id, for --tracker."""
    del config
    return Forgetful()


class Losing(Forgetful):
    """Never reports a vehicle again after it was hidden."""

    def estimates(self, index):
        return [e for e in super().estimates(index) if e.id < 10_000]


def losing(config):
    """A tracker that loses hidden vehicles, for --tracker."""
    del config
    return Losing()


device.TRACKERS.core.update({"forgetful": forgetful, "losing": losing})


@pytest.mark.parametrize("tracker", few(["forgetful", "losing"], "losing"))
def test_a_scenario_is_shortened_to_the_failing_frame_and_not_before(tracker, tmp_path):
    """If the run ended between reappearance and reacquisition, every tracker would seem to lose the car."""
    search = Search(metric="track.occlusion_survival", min=1.0)
    document = {**hidden_behind_wall(0.6, 12.0), "seed": 1, "sensor": {"footprint": [1, 1]}}
    with RowStore.opened(tmp_path / "out") as rows:
        evaluator = Evaluator(search, tmp_path / "x.toml", tracker, rows)
        ended = reductions.shorten(document, evaluator, print)
        assert evaluator.fails(ended)
        if tracker == "losing":  # the metric has no value per frame
            assert ended == document
            return
        worst = reductions.worst_frame(ended, evaluator)
    assert "goes from track 1 to track 10001" in worst.what
    assert ended["duration_s"] == pytest.approx(worst.time_s + 0.08)


@pytest.mark.parametrize(
    "study", [s for s in map(Study.load, studies().values()) if s.search], ids=lambda study: study.path.stem
)
def test_shipped_searches_have_a_valid_undisturbed_scenario(study):
    """Fails on a key that does not exist, or a neutral value that the scenario rejects."""
    make, at = source(study)
    neutral = {parameter.key: parameter.neutral for parameter in study.vary}
    scenario = Scenario.of(make({**study.fixed, **neutral}), at)
    assert scenario.duration_s < 10.0


def test_initial_trials_disturb_one_parameter_then_two():
    """By hand: a has the ends -1 and 3, at sizes 1/9 and 1/3; b has one end and c two texts, all at 1/3."""
    study = Study.model_construct(vary=[LINEAR, LOG, WORDS])
    neutral = {"a": 0.0, "b": 100.0, "c": "keeps"}
    singles = [{"a": -1.0}, {"a": 3.0}, {"b": 1.0}, {"c": "brakes"}, {"c": "turns"}]
    pairs = [
        *({"a": -1.0} | other for other in singles[2:]),
        *({"a": 3.0} | other for other in singles[2:]),
        *({"b": 1.0} | other for other in singles[3:]),
    ]
    assert initial_trials(study, 150) == [neutral | some for some in (*singles, *pairs)]
    assert len(initial_trials(study, 150)) == 13
    assert initial_trials(study, 8) == [neutral | one for one in singles[:4]]


def test_ends_of_listed_numbers_are_the_smallest_and_largest():
    study = Study.model_construct(vary=[COUNTS])
    assert initial_trials(study, 150) == [{"d": 4}]
