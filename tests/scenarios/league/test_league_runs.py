"""League of two tiny scenarios, one seed and all trackers."""

import json
import shutil
import sqlite3
import sys
from contextlib import closing
from pathlib import Path

import pandas as pd
import pytest
from support.optional import need

need("league")

from support import league_scenes, made_once
from support.paths import ROOT

from luxloop.scenarios.cli import main
from luxloop.scenarios.execute import execute
from luxloop.scenarios.files.scenario import Scenario
from luxloop.scenarios.league import league_runs
from luxloop.scenarios.league.drive import SCANS, drives
from luxloop.scenarios.league.entrants import Entrant, entrants
from luxloop.scenarios.league.league_page import refuse_other_files
from luxloop.scenarios.league.standings import pooled_hota
from luxloop.scenarios.offline.recorded_scans import RecordedRun
from luxloop.scenarios.run import device, run_folder
from luxloop.scenarios.run.device import REFERENCE
from luxloop.scenarios.study.row_store import LOCK, ROWS, RowStore, as_text

SEED = 3


@pytest.fixture(scope="module")
def league(tmp_path_factory):
    """Folder of a league, its scenarios, and its exit code."""
    folder = made_once.folder(tmp_path_factory, "league", run_league)
    return (
        folder / "out",
        [str(folder / f"{name}.toml") for name in ("left", "right")],
        int((folder / "code").read_text()),
    )


def run_league(folder):
    (folder / "code").write_text(str(run(league_scenes.write(folder), folder / "out")))


def run(scenarios, out, *options):
    return main(["league", *scenarios, "--seeds", str(SEED), "--workers", "1", "--out", str(out), "-q", *options])


@pytest.fixture(scope="module")
def rows(league):
    return pd.read_csv(league[0] / "league.csv")


def test_all_trackers_have_a_row_per_scenario(league, rows):
    assert league[2] == 0
    assert set(rows["status"]) == {"finished"}
    assert sorted(zip(rows["tracker"], rows["scenario"], strict=True)) == sorted(
        (name, scenario) for name in entrants() for scenario in ("left", "right")
    )
    assert len(entrants()) >= 7


def test_all_trackers_had_the_same_scans(rows):
    assert rows.groupby("scenario")["scans"].nunique().tolist() == [1, 1]
    assert rows["scans"].nunique() == 2
    # Multi-hypothesis tracking has the nearest neighbour's filter: the same tracks where no assignment is in doubt.
    others = rows[rows["tracker"] != "multi-hypothesis"]
    assert others["trace_hash"].nunique() == len(others)


def test_the_shipped_tracker_has_the_tracks_of_a_run_in_the_loop(league, rows, tmp_path):
    scenario = Scenario.load(league_scenes_path(league, "left"), {"seed": SEED})
    alone = execute(scenario, device.load(device.SHIPPED), tmp_path / "run", record=False)
    row = rows[(rows["tracker"] == REFERENCE) & (rows["scenario"] == "left")].iloc[0]
    assert row["trace_hash"] == alone.trace_hash
    assert row["hota"] == alone.metrics["track.hota"].value


def league_scenes_path(league, name):
    return league[0].parent / f"{name}.toml"


def test_the_document_and_the_page_rank_the_trackers_by_hota(league, rows):
    document = json.loads((league[0] / "league.json").read_text(encoding="utf-8"))
    values = [each["hota"] for each in document["standings"]]
    shipped = next(each for each in document["standings"] if each["tracker"] == REFERENCE)
    assert values == sorted(values, reverse=True)
    first = document["standings"][0]["tracker"]
    page = (league[0] / "league.html").read_text(encoding="utf-8")
    assert (f"not the best: {first}" in page) == (first != REFERENCE)
    for each in document["standings"]:
        own = rows[rows["tracker"] == each["tracker"]].set_index("scenario")
        assert each["counts"] == {name: own[name].sum() for name in ("id_switches", "false", "missed")}
        for scenario, hota in each["hota_by_scenario"].items():  # one seed: pooled sums give the metric of the run
            assert hota == pytest.approx(own.loc[scenario, "hota"], abs=1e-6)
        assert each["hota_interval"][0] < each["hota"] < each["hota_interval"][1]
        if each["tracker"] != REFERENCE:
            gap = each["gospa_m"] - shipped["gospa_m"]
            assert each["differences"]["track.gospa_m"]["difference"] == pytest.approx(gap, abs=1e-9)
    assert (league[0] / "hota.svg").is_file()
    assert (league[0] / "hota.png").is_file()


def test_blame_is_named_exactly_where_another_tracker_has_the_highest_hota(league, rows):
    document = json.loads((league[0] / "league.json").read_text(encoding="utf-8"))
    best = rows.loc[rows.groupby("scenario")["hota"].idxmax()]
    beaten = best[best["tracker"] != REFERENCE]["scenario"].tolist()
    assert [command.split()[:2] for command in document["blame"]] == [["luxloop", "blame"]] * len(beaten)
    assert all(any(f"{name}.toml" in command for command in document["blame"]) for name in beaten)


@pytest.mark.slow
def test_a_second_start_takes_up_finished_runs_and_runs_only_what_is_missing(league, tmp_path):
    out, scenarios = shutil.copytree(league[0], tmp_path / "out"), league[1]
    before, folders = rows_in(out), times_of(out / "runs")
    missing = next(key for key, row in before.items() if (row["tracker"], row["scenario"]) == ("norfair", "left"))
    remove(out, missing)
    assert run(scenarios, out) == 0
    after = rows_in(out)
    assert {path for path, time in times_of(out / "runs").items() if time != folders[path]} == {
        Path("norfair") / f"left-seed{SEED}"
    }
    assert list(after) == [*(key for key in before if key != missing), missing]
    assert all(after[key] == before[key] for key in before if key != missing)
    assert all(after[missing][name] == before[missing][name] for name in before[missing] if "step_ms" not in name)


def rows_in(out):
    with RowStore.opened(out, league_runs.COLUMNS) as rows:
        return {row["key"]: row for row in rows.facts()}


def remove(out, key):
    with closing(sqlite3.connect(out / ROWS)) as database, database:
        database.execute("DELETE FROM runs WHERE key = ?", [key])


def times_of(folder):
    """Return the time of the last change of each run folder."""
    return {path.relative_to(folder): path.stat().st_mtime_ns for path in folder.glob("*/*")}


@pytest.mark.slow
def test_two_processes_give_the_same_rows(league, rows, tmp_path):
    names = "paper,nearest-neighbour"
    options = ["--seeds", str(SEED), "--workers", "2", "--out", str(tmp_path / "out"), "-q", "--trackers", names]
    assert main(["league", *league[1], *options]) == 0
    found = pd.read_csv(tmp_path / "out" / "league.csv")
    timeless = [name for name in found if "step_ms" not in name]
    expected = rows[rows["tracker"].isin(found["tracker"])].reset_index(drop=True)
    pd.testing.assert_frame_equal(found[timeless], expected[timeless])


@pytest.mark.slow
def test_a_tracker_that_breaks_its_contract_is_a_row_and_the_exit_code(league, tmp_path, capsys):
    out, scenarios, _ = league
    drive = drives(scenarios[:1], [SEED], 4.0, [], out)[0]
    recorded = RecordedRun.open(out / SCANS / drive.name)
    row = league_runs.graded(
        drive, Entrant("broken", f"{ROOT}/tests/support/rogue_trackers.py:HasNoStep", "", is_own=True), recorded
    )
    assert row["status"] == "failed"
    assert "HasNoStep" in row["error"] or "step" in row["error"]
    assert row["hota"] is None
    copy = tmp_path / "out"
    shutil.copytree(out, copy)
    stored = rows_in(out).values()
    norfair = next(each for each in stored if (each["tracker"], each["scenario"]) == ("norfair", "left"))
    failed = {**norfair, **row}
    with RowStore.opened(copy, league_runs.COLUMNS) as rows:
        rows.add([as_text(failed)])
    capsys.readouterr()
    assert run(scenarios, copy, "--json") == 1
    document = json.loads(capsys.readouterr().out)
    norfair = next(each for each in document["standings"] if each["tracker"] == "norfair")
    assert (norfair["runs"], norfair["failed"]) == (1, 1)
    assert "left seed 3" in (copy / "league.html").read_text(encoding="utf-8")


EXAMPLES = ROOT / "docs" / "examples"


@pytest.mark.slow
def test_own_trackers_take_part_beside_the_shipped_one(league, tmp_path, capsys):
    """A class in a file and the same tracker as a process have the same tracks, in the standings and on the page."""
    out, own = tmp_path / "out", str(EXAMPLES / "ci" / "my_tracker.py")
    shutil.copytree(league[0] / "scans", out / "scans")
    command = f"process:{sys.executable} {EXAMPLES / 'process' / 'nearest_process.py'}"
    options = ["--trackers", f"{own}:Nearest", "--trackers", command, "--json"]
    assert run(league[1][:1], out, *options) == 0
    document = json.loads(capsys.readouterr().out)
    found = {row["tracker"]: row for row in document["rows"]}
    assert list(found) == [REFERENCE, "Nearest", "nearest_process.py"]
    assert found["Nearest"]["trace_hash"] == found["nearest_process.py"]["trace_hash"] != found[REFERENCE]["trace_hash"]
    assert document["trackers"][1] == f"{own}:Nearest"
    assert "Tracks with a smoothed velocity" in (out / "league.html").read_text(encoding="utf-8")
    assert (out / "runs" / "Nearest" / f"left-seed{SEED}" / "result.json").is_file()


@pytest.mark.parametrize(
    ("spec", "message"),
    [
        ("mine.py:Mine", "--trackers mine.py:Mine: no file mine.py; give the path of a Python file"),
        (
            f"{EXAMPLES / 'ci/my_tracker.py'}:Furthest",
            f"--trackers {EXAMPLES / 'ci/my_tracker.py'}:Furthest: Furthest is not there",
        ),
        ("process:no-such-program", "no-such-program"),
        pytest.param(
            f"{EXAMPLES / 'ci/my_tracker.py'}:Nearest,a.py:Nearest",
            "another tracker is named Nearest, too; rename one of them",
            marks=pytest.mark.slow,
        ),
    ],
)
def test_a_bad_own_tracker_is_one_line_before_anything_runs(spec, message, tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    shutil.copy(EXAMPLES / "ci" / "my_tracker.py", "a.py")
    assert main(["league", "t-junction", "--seeds", "1", "--trackers", spec]) == 2
    error = capsys.readouterr().err
    assert message in error
    assert error.count("\n") == 1
    assert {path.name for path in tmp_path.iterdir()} <= {"a.py", "__pycache__"}


def test_pooled_hota_of_one_run_is_its_metric(league):
    from luxloop.scenarios.compare.digest import read_run

    folder = league[0] / "runs" / REFERENCE / f"left-seed{SEED}"
    assert pooled_hota([read_run(folder)])[0] == pytest.approx(
        run_folder.read(folder).metrics["track.hota"].value, abs=1e-6
    )


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--trackers", "kalman"], "--trackers kalman: no such tracker"),
        (["--trackers", ""], "--trackers of an empty name: no such tracker; give some of shipped"),
        (["--trackers", "paper,"], "--trackers of an empty name: no such tracker; give some of shipped"),
        (["--seeds", "1;2"], "--seeds 1;2: give seeds as 11,12,13"),
        (["cruise-on-tracks"], "control: the ego drives by its tracks"),
        (["truck-shadow", "truck-shadow"], "given twice"),
    ],
)
def test_bad_input_is_one_line(arguments, message, tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert main(["league", *arguments]) == 2
    error = capsys.readouterr().err
    assert message in error
    assert error.count("\n") == 1
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("files", "message"),
    [
        (["out/notes.txt"], "out: holds other files than those of a league; choose another folder with --out"),
        (["out/runs/mine"], "out: holds other files than those of a league; choose another folder with --out"),
        (["out"], "out: is a file; choose another folder with --out"),
        (["out/scans"], "out/scans: is a file, but a league has a folder there; choose another with --out"),
    ],
)
def test_a_folder_of_other_files_is_refused_and_left_as_it_is(files, message, tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for file in files:
        Path(file).parent.mkdir(parents=True, exist_ok=True)
        Path(file).write_text("mine")
    before = sorted(tmp_path.rglob("*"))
    assert main(["league", "sumo-crossing", "--seeds", "1", "--duration", "0.3", "--out", "out", "-q"]) == 2
    assert capsys.readouterr().err == f"luxloop: error: {message}\n"
    assert sorted(tmp_path.rglob("*")) == before


def test_a_league_that_was_killed_while_it_recorded_is_continued(tmp_path):
    refuse_other_files(tmp_path)
    (tmp_path / LOCK).write_text("")
    refuse_other_files(tmp_path)
    (tmp_path / "scans").mkdir()
    refuse_other_files(tmp_path)
    (tmp_path / ROWS).write_text("")
    (tmp_path / "runs").mkdir()
    refuse_other_files(tmp_path)


@pytest.mark.parametrize("begun", ["rows/norfair-left-seed3.json", "study"])
def test_a_folder_of_version_0_1_or_of_a_study_is_one_line(begun, tmp_path, capsys):
    out, scenarios = tmp_path / "out", league_scenes.write(tmp_path)
    if begun == "study":
        with RowStore.opened(out, ["gap_m"]) as rows:
            rows.add([as_text({"key": "a", "seed": 1, "gap_m": 3.0})])
    else:
        (out / begun).parent.mkdir(parents=True)
        (out / begun).write_text("{}")
        (out / "league.json").write_text("{}")
    assert run(scenarios, out) == 2
    message = "holds rows of another study" if begun == "study" else "rows: holds rows that are not in runs.sqlite"
    error = capsys.readouterr().err
    assert message in error
    assert error.count("\n") == 1
