"""The adversary finds a planted bug, and shrinks what it found to a file that anybody can run."""

import json
import tomllib
from pathlib import Path

import pandas as pd
import pytest
from support import crossing_ids
from support.stub_trackers import Perfect

from scenarios.cli import main
from scenarios.errors import OutputError, StudyError
from scenarios.run import run_folder
from scenarios.search.adversary import ANSWERS, RUN, search
from scenarios.study.study_file import Study

LIMIT = 'metric = "track.id_switches"\nmax = 0\n'


def sound(config):
    """A tracker without the bug, for --tracker."""
    del config
    return Perfect()


def changed(folder: Path, old: str, new: str) -> Path:
    """The planted study with a change."""
    path = crossing_ids.write(folder)
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new))
    return path


@pytest.fixture(scope="module")
def hunted(tmp_path_factory):
    """The planted bug, looked for by the command line, and the folder."""
    folder = tmp_path_factory.mktemp("hunt")
    study = crossing_ids.write(folder)
    code = main(["search", str(study), "--tracker", crossing_ids.SPEC, "--out", str(folder / "out"), "--workers", "1"])
    assert code == 1
    return folder / "out"


def document(out):
    return tomllib.loads((out / "planted.toml").read_text())


def test_a_planted_bug_is_found_in_fewer_than_150_runs_and_needs_two_cars(hunted):
    """A search without lead, or one that keeps bystanders, would not."""
    answers = [json.loads(line) for line in (hunted / ANSWERS).read_text().splitlines()]
    first = next(n for n, answer in enumerate(answers) if answer["value"] and answer["value"] > 0)
    assert first < 150
    assert len(answers) < 150
    traffic = document(hunted)["traffic"]
    assert {actor["name"] for actor in traffic["actor"]} == {"first", "second"}
    assert len(traffic["obstacle"]) == 1  # the wall behind which both are


def test_what_has_no_part_in_it_is_neutral_or_gone(hunted):
    """The bug takes two hidden cars: no noise, no bystander, and not the time after it."""
    found = document(hunted)
    assert all(kind == {"enabled": False} for kind in found["noise"].values())
    assert found["duration_s"] < 3.0
    (second,) = (actor for actor in found["traffic"]["actor"] if actor["name"] == "second")
    assert -40.0 < second["x_m"] < -22.0  # as near as both are hidden at once, and no nearer than it takes


def test_the_file_reproduces_the_failure_and_the_recording_ends_with_it(hunted, tmp_path, capsys):
    """Another seed, a path, a default that is lost in writing would change the trace."""
    out = tmp_path / "again"
    options = ["--tracker", crossing_ids.SPEC, "--json", "--no-recording", "--out", str(out)]
    code = main(["run", str(hunted / "planted.toml"), *options])
    result = json.loads(capsys.readouterr().out)
    kept = run_folder.read(hunted / RUN)
    assert code == 0
    assert result["known_failures"] == ["track.id_switches"]
    assert result["trace_hash"] == kept.trace_hash
    assert result["seed"] == document(hunted)["seed"]
    assert run_folder.recording(hunted / RUN).stat().st_size > 0
    truth = kept.tables["truth"]
    before = truth.groupby("actor_id")["track_id"].shift()
    switched = truth[(before != truth["track_id"]) & pd.notna(before) & (before >= 0) & (truth["track_id"] >= 0)]
    assert kept.frames - 1 <= switched["frame"].max() <= kept.frames


@pytest.mark.slow
def test_two_workers_find_the_same_as_one(hunted, tmp_path):
    """Proposals that depended on who ran them, or on which ended first, would find another."""
    search(Study.load(crossing_ids.write(hunted.parent)), crossing_ids.SPEC, tmp_path, print, workers=2)
    assert (tmp_path / "planted.toml").read_text() == (hunted / "planted.toml").read_text()
    answers = [sorted((folder / ANSWERS).read_text().splitlines()) for folder in (tmp_path, hunted)]
    assert answers[0] == answers[1]


def test_a_second_start_repeats_no_run_and_finds_the_same(hunted, tmp_path):
    """Also after a kill in the middle of writing an answer: half a line is not one."""
    first = tmp_path / "out"
    lines = (hunted / ANSWERS).read_text().splitlines(keepends=True)
    first.mkdir()
    (first / ANSWERS).write_text("".join(lines[:-1]) + lines[-1][:20])
    study = Study.load(crossing_ids.write(hunted.parent))
    search(study, crossing_ids.SPEC, first, print)
    assert (first / ANSWERS).read_text().splitlines(keepends=True) == lines
    assert (first / "planted.toml").read_text() == (hunted / "planted.toml").read_text()


def test_a_sound_tracker_passes_the_search(tmp_path, capsys):
    study = changed(tmp_path, "trials = 25", "trials = 4")
    options = ["--tracker", "test_search:sound", "--out", str(tmp_path / "out"), "--workers", "1"]
    assert main(["search", str(study), *options]) == 0
    assert "no failure in 4 runs" in capsys.readouterr().out
    assert not (tmp_path / "out" / "planted.toml").exists()


class InterruptedOnce:
    """A sound tracker, but in the third run (each makes two, one to warm up) somebody presses Ctrl-C."""

    made = 0

    def __new__(cls, config):
        InterruptedOnce.made += 1
        if InterruptedOnce.made == 5:
            raise KeyboardInterrupt
        return sound(config)


def test_ctrl_c_tells_how_many_answers_there_are_and_the_next_start_takes_them_up(tmp_path, capfd):
    study = changed(tmp_path, "trials = 25", "trials = 4")
    options = ["--tracker", "test_search:InterruptedOnce", "--out", str(tmp_path / "out"), "--workers", "1"]
    assert main(["search", str(study), *options]) == 130
    assert f"interrupted; 2 answers are in {tmp_path}/out/{ANSWERS}, the same command" in capfd.readouterr().err
    assert main(["search", str(study), *options]) == 0
    assert capfd.readouterr().out.startswith("2 answers of an earlier start are taken up\nno failure in 4 runs")


def test_what_fails_undisturbed_is_found_at_once(tmp_path):
    """The first run has size 0: a hunt that starts at random would report a larger one."""
    study = Study.load(changed(tmp_path, LIMIT, 'metric = "track.hota"\nmax = 0.5\n'))
    story = []
    search(study, "test_search:sound", tmp_path / "out", story.append)
    assert story[0] == "it fails with nothing disturbed"
    found = document(tmp_path / "out")
    assert len(found["traffic"]["actor"]) == 1
    assert found["expect"]["track.hota"]["max"] == 0.5


def test_a_scene_that_cannot_run_is_told_in_one_line(tmp_path):
    with pytest.raises(StudyError, match=r"with nothing disturbed.*sigma_scale"):
        search_with(tmp_path, "seeds = 2", 'seeds = 2\nfixed = { "noise.range.sigma_scale" = -1.0 }')


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        (f"[search]\n{LIMIT}", "[search]\nmetric = 'track.hato'\nmax = 0\n", "track.hota"),
        (f"[search]\n{LIMIT}", "[search]\nmetric = 'track.hota'\n", "give min, max or both"),
        ("neutral = -15.0", "", "give neutral"),
        ("neutral = -15.0", "neutral = -31.0", "outside the range"),
        ("neutral = -15.0", "neutral = 'none'", "outside the range"),
    ],
)
def test_a_wrong_search_is_refused_with_the_remedy(tmp_path, old, new, told):
    with pytest.raises(StudyError, match=told):
        Study.load(changed(tmp_path, old, new))


def test_a_study_without_a_search_is_refused(tmp_path):
    text = crossing_ids.STUDY
    table = text[text.index("[search]") : text.index("[[vary]]")]
    with pytest.raises(StudyError, match=r"no \[search\] table"):
        search_with(tmp_path, table, "samples = 3\n")


def test_answers_of_something_else_are_not_overwritten(tmp_path):
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / ANSWERS).write_text('{"a": 1}\n')
    with pytest.raises(OutputError, match="choose a new folder"):
        search(Study.load(crossing_ids.write(tmp_path)), crossing_ids.SPEC, tmp_path / "out", print)


def search_with(folder, old, new):
    return search(Study.load(changed(folder, old, new)), crossing_ids.SPEC, folder / "out", print)
