"""Adaptive estimates of a threshold: a tracker with a known memory, restarts, and mistakes of the study."""

import json

import pytest
from support.optional import need

need("sweeps")

from support import short_memory
from support.named_oracles import known_to_workers  # noqa: F401
from support.sweeps import stored

from luxloop.scenarios.cli import main
from luxloop.scenarios.run import device
from luxloop.scenarios.search.evaluator import TrialOptions
from luxloop.scenarios.search.thresholds import thresholds
from luxloop.scenarios.study.row_store import RowStore, as_text
from luxloop.scenarios.study.study_file import Study

MEMORY_S = 0.08 * (short_memory.MEMORY_FRAMES + 0.5)


def command(study, out, *options):
    own = ["--tracker", short_memory.SPEC, "--out", str(out), "--workers", "1"]
    return main(["thresholds", str(study), *own, *options])


@pytest.fixture(scope="module")
def found(tmp_path_factory):
    folder = tmp_path_factory.mktemp("thresholds")
    study = short_memory.write(folder)
    assert command(study, folder / "out", "--json") == 0
    return study, folder / "out"


def document(out):
    return json.loads((out / "thresholds.json").read_text())


@pytest.mark.slow
def test_the_memory_of_a_tracker_is_found_in_eight_runs_of_each_setting(found):
    """The time without a beam is that of the scene within 0.3 s (`test_staged_scenes.py`)."""
    shown = document(found[1])
    assert shown["runs"] == 16
    assert [setting["parameters"] for setting in shown["settings"]] == [{"speed_mps": 10.0}, {"speed_mps": 20.0}]
    for setting in shown["settings"]:
        half, most = setting["thresholds"]
        assert half["value"] == pytest.approx(MEMORY_S, abs=0.3)
        assert half["low"] < half["value"] < half["high"]
        assert most["value"] < half["value"]
        survivors = [trial["value"] for trial in setting["trials"] if trial["outcome"] == 1.0]
        lost = [trial["value"] for trial in setting["trials"] if trial["outcome"] == 0.0]
        assert max(survivors) < min(lost) + 0.3
    assert (found[1] / "thresholds.png").stat().st_size > 0


@pytest.mark.slow
def test_a_restart_repeats_no_run_and_gives_the_same(found, tmp_path):
    """Rows of half of the runs, as after a kill."""
    study, out = found
    again = tmp_path / "out"
    with RowStore.opened(out) as rows, RowStore.opened(again) as half:
        half.add([as_text(row | {"why": "kept"}) for row in list(rows.rows())[:9]])
    assert command(study, again, "--json") == 0
    assert list(stored(again).items()) == list(stored(out).items())
    with RowStore.opened(again) as rows:
        assert [row["why"] for row in rows.facts()] == ["kept"] * 9 + [""] * (len(stored(out)) - 9)
    assert document(again) == document(out)


@pytest.mark.slow
def test_runs_with_errors_are_run_again_only_if_asked(found, tmp_path):
    study, out = found
    with RowStore.opened(out) as rows, RowStore.opened(tmp_path) as copy:
        first = list(rows.rows())
        died = {"track.occlusion_survival": None, "status": "error", "error": "worker died"}
        copy.add([as_text(row | died if n < 2 else row) for n, row in enumerate(first)])
    loaded = Study.load(study)
    settings = thresholds(loaded, short_memory.SPEC, tmp_path, lambda _: None, TrialOptions(retry_errors=True))
    assert [setting.trials[0].outcome for setting in settings] == [row["track.occlusion_survival"] for row in first[:2]]
    assert stored(tmp_path) == stored(out)


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ('key = "occlusion_s"\nmetric', 'key = "speed_mps"\nmetric', "threshold.key = speed_mps: not a [[vary]] table"),
        ("track.occlusion_survival", "track.survival", "track.survival"),
        ("runs = 8", "runs = 8\nshares = [0.5, 0.99]", "shares"),
        ("[threshold]", "[treshold]", "treshold"),
        ("track.occlusion_survival", "dataset.points_per_observation", "name a metric from 0 to 1"),
    ],
)
def test_mistakes_are_one_line(old, new, words, tmp_path, capsys):
    study = short_memory.write(tmp_path)
    text = study.read_text()
    assert old in text
    study.write_text(text.replace(old, new))
    assert command(study, tmp_path / "out") == 2
    message = capsys.readouterr().err
    assert words in message
    assert message.count("\n") == 1


def test_a_study_without_the_table_is_refused(capsys):
    assert main(["thresholds", "occlusion", "--tracker", device.SHIPPED]) == 2
    assert "no [threshold] table" in capsys.readouterr().err
