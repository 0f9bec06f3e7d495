"""The search finds a planted bug and reduces it to a scenario file that reproduces it."""

import json
import signal
import tomllib
from pathlib import Path

import pandas as pd
import pytest
from support.optional import need

need("search")

from support import crossing_ids
from support.named_oracles import known_to_workers  # noqa: F401
from support.stub_trackers import Perfect
from support.sweeps import stored

from luxloop.scenarios.cli import main
from luxloop.scenarios.errors import OutputError, StudyError
from luxloop.scenarios.run import device, run_folder
from luxloop.scenarios.search.adversary import RUN, search
from luxloop.scenarios.search.evaluator import TrialOptions
from luxloop.scenarios.study.row_store import ROWS, RowStore, as_text
from luxloop.scenarios.study.study_file import Study

LIMIT = 'metric = "track.id_switches"\nmax = 0\n'


def sound(config):
    """A tracker without the bug, for --tracker."""
    del config
    return Perfect()


class InterruptedOnce:
    """A sound tracker that is interrupted in the third run: each run makes two trackers, one to warm up."""

    made = 0

    def __new__(cls, config):
        InterruptedOnce.made += 1
        if InterruptedOnce.made == 5:
            signal.raise_signal(signal.SIGINT)  # Ctrl-C; a KeyboardInterrupt would be the tracker's own fault
        return sound(config)


@pytest.fixture(autouse=True)
def named_trackers(monkeypatch):
    """Register both under short names, for the tests of this file only."""
    monkeypatch.setitem(device.TRACKERS.core, "sound", sound)
    monkeypatch.setitem(device.TRACKERS.core, "interrupted-once", InterruptedOnce)


def changed(folder: Path, old: str, new: str) -> Path:
    """Write the planted study with a text replaced; return its path."""
    path = crossing_ids.write(folder)
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new))
    return path


@pytest.fixture(scope="module")
def found_in(tmp_path_factory):
    """Output folder of `luxloop search` for the planted bug."""
    folder = tmp_path_factory.mktemp("search")
    study = crossing_ids.write(folder)
    code = main(["search", str(study), "--tracker", crossing_ids.SPEC, "--out", str(folder / "out"), "--workers", "1"])
    assert code == 1
    return folder / "out"


def document(out):
    return tomllib.loads((out / "planted.toml").read_text())


@pytest.mark.slow
def test_a_planted_bug_is_found_in_fewer_than_150_runs_and_needs_two_cars(found_in):
    """Fails for an unguided search, or one that keeps unrelated actors."""
    with RowStore.opened(found_in) as rows:
        evaluations = [row.get("track.id_switches") for row in rows.rows()]
    first = next(n for n, value in enumerate(evaluations) if value and value > 0)
    assert first < 150
    assert len(evaluations) < 150
    traffic = document(found_in)["traffic"]
    assert {actor["name"] for actor in traffic["actor"]} == {"first", "second"}
    assert len(traffic["obstacle"]) == 1  # the wall that hides both


@pytest.mark.slow
def test_unrelated_parameters_and_elements_are_neutral_or_removed(found_in):
    """The bug needs two hidden cars: no noise, no other actor, and no time after the failure."""
    found = document(found_in)
    assert all(kind == {"enabled": False} for kind in found["noise"].values())
    assert found["duration_s"] < 3.0
    (second,) = (actor for actor in found["traffic"]["actor"] if actor["name"] == "second")
    assert -40.0 < second["x_m"] < -22.0  # close enough that both are hidden at once, and no closer than necessary


@pytest.mark.slow
def test_the_scenario_file_reproduces_the_failure_at_its_end(found_in, tmp_path, capsys):
    """A seed, path or default lost in the file would change the trace hash."""
    out = tmp_path / "again"
    options = ["--tracker", crossing_ids.SPEC, "--json", "--no-recording", "--out", str(out)]
    code = main(["run", str(found_in / "planted.toml"), *options])
    result = json.loads(capsys.readouterr().out)
    kept = run_folder.read(found_in / RUN)
    assert code == 0
    assert result["known_failures"] == ["track.id_switches"]
    assert result["trace_hash"] == kept.trace_hash
    assert result["seed"] == document(found_in)["seed"]
    assert run_folder.recording(found_in / RUN).stat().st_size > 0
    truth = kept.tables["truth"]
    before = truth.groupby("actor_id")["track_id"].shift()
    switched = truth[(before != truth["track_id"]) & pd.notna(before) & (before >= 0) & (truth["track_id"] >= 0)]
    assert kept.frames - 1 <= switched["frame"].max() <= kept.frames


@pytest.mark.slow
def test_two_workers_find_the_same_as_one(found_in, tmp_path):
    """Fails if proposals depend on the worker or on the order of completion."""
    search(Study.load(crossing_ids.write(found_in.parent)), crossing_ids.SPEC, tmp_path, print, TrialOptions(workers=2))
    assert (tmp_path / "planted.toml").read_text() == (found_in / "planted.toml").read_text()
    assert sorted(stored(tmp_path).items()) == sorted(stored(found_in).items())
    tables = [pd.read_parquet(folder / "runs.parquet") for folder in (tmp_path, found_in)]
    assert tables[0]["key"].tolist() == tables[1]["key"].tolist()


@pytest.mark.slow
def test_a_second_start_repeats_no_run_and_finds_the_same(found_in, tmp_path):
    """The last row is missing, as after a kill."""
    first = tmp_path / "out"
    with RowStore.opened(found_in) as rows, RowStore.opened(first) as fewer:
        *kept, last = [row | {"why": "kept"} for row in rows.rows()]
        fewer.add([as_text(row) for row in kept])
    study = Study.load(crossing_ids.write(found_in.parent))
    search(study, crossing_ids.SPEC, first, print)
    assert list(stored(first).items()) == list(stored(found_in).items())
    with RowStore.opened(first) as rows:
        assert [row["why"] for row in rows.facts()] == ["kept"] * len(kept) + [""]
        assert rows.keys == {*stored(first)} == {row["key"] for row in (*kept, last)}
    assert (first / "planted.toml").read_text() == (found_in / "planted.toml").read_text()


@pytest.mark.slow
def test_the_table_has_a_row_per_evaluated_scenario_in_their_order(found_in):
    table = pd.read_parquet(found_in / "runs.parquet")
    assert table["key"].tolist() == list(stored(found_in))
    assert table["index"].tolist() == list(range(len(table)))
    assert table["trace_hash"].tolist() == list(stored(found_in).values())
    assert table["track.id_switches"].max() > 0


def test_ctrl_c_reports_the_number_of_evaluations_and_the_next_start_reuses_them(tmp_path, capfd):
    study = changed(tmp_path, "trials = 25", "trials = 4")
    options = ["--tracker", "interrupted-once", "--out", str(tmp_path / "out"), "--workers", "1"]
    assert main(["search", str(study), *options]) == 130
    assert f"interrupted; 2 evaluations are in {tmp_path}/out/{ROWS}; run the same command" in capfd.readouterr().err
    assert main(["search", str(study), *options]) == 0
    assert capfd.readouterr().out.startswith("2 evaluations of an earlier start are reused\nno failure in 4 runs")
    assert not (tmp_path / "out" / "planted.toml").exists()


@pytest.mark.slow
def test_an_undisturbed_failure_is_found_in_the_first_run(tmp_path):
    """The first run has size 0; a random start would report a larger one."""
    study = Study.load(changed(tmp_path, LIMIT, 'metric = "track.hota"\nmax = 0.5\n'))
    lines = []
    search(study, "sound", tmp_path / "out", lines.append)
    assert lines[0] == "the undisturbed scenario fails"
    found = document(tmp_path / "out")
    assert len(found["traffic"]["actor"]) == 1
    assert found["expect"]["track.hota"]["max"] == 0.5


def test_an_invalid_undisturbed_scenario_is_an_error(tmp_path):
    with pytest.raises(StudyError, match=r"with nothing disturbed.*sigma_scale"):
        search_with(tmp_path, "seeds = 2", 'seeds = 2\nfixed = { "noise.range.sigma_scale" = -1.0 }')


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        (f"[search]\n{LIMIT}", "[search]\nmetric = 'track.hato'\nmax = 0\n", "track.hota"),
        (f"[search]\n{LIMIT}", "[search]\nmetric = 'track.hota'\n", "give min, max or both"),
        ("neutral = -15.0", "", "give neutral"),
        ("neutral = -15.0", "neutral = -31.0", "outside the range"),
        ("neutral = -15.0", "neutral = 'none'", "outside the range"),
    ],
)
def test_an_invalid_search_is_refused_with_the_remedy(tmp_path, old, new, message):
    with pytest.raises(StudyError, match=message):
        Study.load(changed(tmp_path, old, new))


def test_a_study_without_a_search_is_refused(tmp_path):
    text = crossing_ids.STUDY
    table = text[text.index("[search]") : text.index("[[vary]]")]
    with pytest.raises(StudyError, match=r"no \[search\] table"):
        search_with(tmp_path, table, "samples = 3\n")


@pytest.mark.parametrize("name", [ROWS, "answers.jsonl"])
def test_an_unrelated_file_of_rows_is_not_overwritten(name, tmp_path):
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / name).write_text('{"a": 1}\n' * 200)
    with pytest.raises(OutputError, match=rf"{name}: .*choose a new --out"):
        search(Study.load(crossing_ids.write(tmp_path)), crossing_ids.SPEC, tmp_path / "out", print)


def search_with(folder, old, new):
    return search(Study.load(changed(folder, old, new)), crossing_ids.SPEC, folder / "out", print)


def test_the_output_ends_with_the_two_useful_lines_and_has_no_tables(tmp_path, capsys):
    study = changed(tmp_path, "trials = 25", "trials = 4\nreduction_runs = 2")
    options = ["--tracker", crossing_ids.SPEC, "--out", str(tmp_path / "out"), "--workers", "1"]
    text = study.read_text().replace("low = -60.0", "low = -30.0").replace("neutral = -60.0", "neutral = -26.0")
    study.write_text(text)
    assert main(["search", str(study), *options]) == 1
    lines = capsys.readouterr().out.splitlines()
    assert lines[-2].startswith(f"{tmp_path / 'out' / 'planted.toml'} fails: ")
    assert lines[-1].startswith("To run it: luxloop run ")
    assert len(lines) < 12
    assert "stopped after 2 runs of reduction ([search] reduction_runs); a smaller case may exist" in lines
    assert len(stored(tmp_path / "out")) <= 4 + 2
    assert (tmp_path / "out" / RUN / "report.txt").is_file()


@pytest.mark.slow
def test_the_objective_may_be_a_metric_of_one_s_own(tmp_path):
    """Id switches of one of the two cars: the file of the finding defines it, and runs on its own."""
    own = '[[metric]]\nname = "own.second_switches"\nof = "track.id_switches"\nactor = "second"\n\n[[vary]]'
    study = changed(tmp_path, LIMIT, 'metric = "own.second_switches"\nmax = 0\n')
    text = study.read_text().replace("[[vary]]", own, 1).replace("trials = 25", "trials = 10\nreduction_runs = 8")
    text = text.replace("low = -60.0", "low = -30.0").replace("neutral = -60.0", "neutral = -26.0")
    study.write_text(text)
    finding = search(Study.load(study), crossing_ids.SPEC, tmp_path / "out", print)
    assert finding is not None
    found = document(tmp_path / "out")
    assert found["metric"] == [{"name": "own.second_switches", "of": "track.id_switches", "actor": "second"}]
    assert found["expect"]["own.second_switches"]["max"] == 0
    assert finding.what.startswith("1: ")
    assert "frame" in finding.what
    assert main(["run", str(finding.file), "--tracker", crossing_ids.SPEC, "--out", str(tmp_path / "again")]) == 0


@pytest.mark.slow
def test_evaluations_with_errors_are_reused_unless_they_are_retried(tmp_path):
    study = Study.load(changed(tmp_path, "trials = 25", "trials = 4"))
    tracker, out = "sound", tmp_path / "out"
    assert search(study, tracker, out, print) is None
    with RowStore.opened(out) as rows:
        rows.add([as_text(row | {"error": "no memory"}) for row in list(rows.rows())[1:]])
    for retry, again, errors in ((False, False, 3), (True, True, 0), (True, False, 0)):
        lines = []
        assert search(study, tracker, out, lines.append, TrialOptions(retry_errors=retry)) is None
        with RowStore.opened(out) as rows:
            assert [row["error"] for row in rows.facts()].count("no memory") == errors
        assert len(stored(out)) == 4
        assert ("3 evaluations ended with an error and are run again" in lines) == again
