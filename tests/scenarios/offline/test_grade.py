"""Regrading without simulation: same metrics from the run's files, and validation of track files."""

import json
import re
import shutil
from dataclasses import fields, replace
from pathlib import Path

import numpy as np
import pandas as pd
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from support import compiling_tracker, short_run
from support.few import few

from luxloop.scenarios.cli import main
from luxloop.scenarios.errors import TracksError
from luxloop.scenarios.grading.grader import PER_FRAME
from luxloop.scenarios.grading.grading_config import GradingConfig
from luxloop.scenarios.metrics.definitions import OF_LOOP, find_metric
from luxloop.scenarios.offline import track_file
from luxloop.scenarios.offline.recorded_scans import RecordedRun
from luxloop.scenarios.offline.regrade import Regrader
from luxloop.scenarios.report import first_screen
from luxloop.scenarios.report.html.reported_run import ReportedRun
from luxloop.scenarios.run import device, progress, run_folder
from luxloop.tracker.records import Status
from luxloop.tracker.tracker import Tracker

SHIPPED = "luxloop.tracker.tracker:Tracker"
TEXT = short_run.TEXT + '\n[expect]\n"track.hota" = { min = 0.01 }\n'


@pytest.fixture(scope="module")
def home(tmp_path_factory):
    """A folder with a scenario of ten frames and its run, scans included."""
    folder = tmp_path_factory.mktemp("home")
    path = short_run.write(folder, TEXT)
    assert main(["run", str(path), "--out", str(folder / "run"), "--no-recording", "--record-scans"]) == 0
    return folder


@pytest.fixture
def run(home, tmp_path, monkeypatch):
    """A copy of the run that a test can change; its parent is the current folder."""
    shutil.copytree(home, tmp_path, dirs_exist_ok=True)
    monkeypatch.chdir(tmp_path)
    return Path("run")


in_run_folder = pytest.mark.usefixtures("run")


def grade(capfd, *arguments, code=0):
    """Run `luxloop grade`; return the JSON document."""
    assert main(["grade", "run", "--json", *arguments]) == code
    out, err = capfd.readouterr()
    assert err == ""
    return json.loads(out)


def error_line(capfd, *arguments):
    """Run `luxloop grade` with invalid input; return the error line."""
    assert main(["grade", *arguments]) == 2
    out, err = capfd.readouterr()
    assert out == ""
    assert err.startswith("luxloop: error: ")
    assert err.count("\n") == 1
    return err


def written(folder="run"):
    return json.loads((Path(folder) / run_folder.RESULT).read_text())


def untimed(document):
    return {name: metric for name, metric in document["metrics"].items() if not name.startswith("perf.")}


def own_tracks(run):
    """Return the shipped tracker's tracks of the recorded scans, in the layout of track files."""
    recorded, rows = RecordedRun.open(run), []
    tracker = Tracker(recorded.scenario.tracker)
    for frame, scan, _ in recorded.scans():
        tracks, _ = tracker.step(scan)
        for t, (x, y) in enumerate(tracks.center_odom):
            box = (x, y, tracks.mean[t, 6], *tracks.size[t])
            label = "small" if tracks.small[t] else "vehicle"
            rows.append((frame.index, frame.time, tracks.id[t], *box, Status(tracks.status[t]).name.lower(), label))
    names = [column.name for column in (*track_file.WHEN, *track_file.REQUIRED, *track_file.OPTIONAL)]
    return pd.DataFrame(rows, columns=names)


# --- same run


@in_run_folder
def test_regrading_gives_exactly_the_same_metrics(capfd):
    """Fails if a table on disk loses a type, a category or precision."""
    assert grade(capfd)["metrics"] == written()["metrics"]


@in_run_folder
def test_the_shipped_tracker_on_recorded_scans_gives_exactly_the_live_run(capfd):
    """Same scans, truth and tracks (trace hash), and same metrics, including fits and their bound."""
    again = grade(capfd, "--tracker", SHIPPED)
    assert again["trace_hash"] == written()["trace_hash"]
    assert untimed(again) == untimed(written())
    assert again["metrics"]["perf.tracker_ms_p50"]["value"] > 0
    assert again["metrics"]["perf.sim_ms_p50"]["value"] is None


@in_run_folder
def test_other_limits_apply_without_simulation(capfd):
    """A stricter expectation fails, and a higher overlap limit gives more misses."""
    Path("strict.toml").write_text(TEXT.replace("0.01", "1.01") + "\n[grading]\nhit_iou_min = 0.99\n")
    strict = grade(capfd, "--scenario", "strict.toml", code=1)
    assert strict["failed"] == ["track.hota"]
    assert strict["metrics"]["track.missed"]["value"] > written()["metrics"]["track.missed"]["value"]
    assert strict["config"]["grading"]["hit_iou_min"] == 0.99


CHANGED = {
    "memory_s": 0.1,
    "hidden_fraction_max": 0.9,
    "hit_iou_min": 0.95,
    "gospa_cutoff_m": 0.5,
    "match_distance_m": 0.5,
    "nees_confidence": 0.5,
    "target": "car.1",
}
"""Limits that apply at the end of a run, with other values."""


@pytest.mark.parametrize("limit", CHANGED)
def test_limits_that_apply_at_the_end_act_equally_on_the_tables(limit, run):
    """Fails if a limit applies frame by frame but is missing in `PER_FRAME`."""
    recorded = RecordedRun.open(run)
    grading = replace(recorded.scenario.grading, **{limit: CHANGED[limit]})
    regrader = Regrader(recorded, recorded.scenario.model_copy(update={"grading": grading}))
    tables, frames = regrader.tables().metrics, regrader.tracker(Tracker, "shipped").metrics
    graded = [name for name in frames if find_metric(name).definition.kind not in OF_LOOP]
    assert {name: tables[name] for name in graded} == {name: frames[name] for name in graded}


def test_every_limit_applies_per_frame_or_at_the_end():
    assert {*PER_FRAME, *CHANGED} == {field.name for field in fields(GradingConfig)}


@in_run_folder
def test_limits_per_frame_need_recorded_scans(capfd):
    Path("near.toml").write_text(TEXT + "\n[grading]\nrange_max_m = 10\n")
    error = error_line(capfd, "run", "--scenario", "near.toml")
    assert "grading.range_max_m = 10: the tables of run were made with 50; grade its recorded scans" in error
    near = grade(capfd, "--scenario", "near.toml", "--tracker", SHIPPED, code=1)
    assert near["metrics"]["dataset.observations"]["value"] < written()["metrics"]["dataset.observations"]["value"]


@in_run_folder
def test_a_log_names_the_compilation_of_the_kernels_of_a_tracker(monkeypatch, capfd):
    monkeypatch.setattr(progress, "SILENCE_S", 0.01)
    assert main(["grade", "run", "--tracker", compiling_tracker.SPEC]) == 0
    assert capfd.readouterr().err == "luxloop: short: compiling numba kernels, up to two minutes, only once\n"


def test_the_report_equals_that_of_the_run(run, capfd):
    assert main(["grade", "run", "--full"]) == 0
    out, err = capfd.readouterr()
    assert out == (run / "report.txt").read_text() + "Nothing was written; to keep it, give --out\n"
    assert err == ""


def test_the_first_screen_equals_that_of_the_run(run, capfd):
    assert main(["grade", "run"]) == 0
    screen = capfd.readouterr().out.splitlines()
    found = ReportedRun.read(run)
    of_run = first_screen.screen(found.result, found.checks, {"": ""}, "", 80)
    assert screen[:-1] == [line.plain for line in of_run[:-1]]
    assert screen[-1] == "luxloop grade run --out DIR   nothing was written; this keeps it"


def test_results_are_written_to_out_and_the_run_is_unchanged(run, capfd):
    before = {path: path.read_bytes() for path in run.rglob("*") if path.is_file()}
    grade(capfd, "--tracker", SHIPPED, "--out", "graded")
    assert run_folder.read(Path("graded")).trace_hash == written()["trace_hash"]
    for out in ("run", "run/graded", "."):
        assert "is the folder of the graded run, inside it, or contains it" in error_line(capfd, "run", "--out", out)
    assert before == {path: path.read_bytes() for path in run.rglob("*") if path.is_file()}
    assert sorted(path.name for path in Path().iterdir()) == ["graded", "run", "short.toml"]


def test_a_run_that_ended_early_stays_incomplete(run, capfd):
    document = written()
    document["ended_early"], document["complete"] = "the ego arrived", False
    (run / run_folder.RESULT).write_text(json.dumps(document))
    assert grade(capfd, code=1)["verdict"] == "incomplete"


# --- invalid runs


@pytest.mark.parametrize(
    ("damage", "message"),
    [
        (lambda run: (run / "result.json").unlink(), "no result.json of a run in it"),
        (lambda run: (run / "result.json").write_text((run / "result.json").read_text()[:-9]), "damaged"),
        (lambda run: (run / "tables" / "tracks.parquet").unlink(), "tracks is missing in its tables"),
        (lambda run: (run / "tables" / "tracks.parquet").write_bytes(b"PAR1"), "damaged"),
        (lambda run: shutil.rmtree(run), "no result.json of a run in it"),
    ],
    ids=["no result", "truncated result", "missing table", "truncated table", "no folder"],
)
def test_an_incomplete_run_is_a_one_line_error(damage, message, run, capfd):
    damage(run)
    assert message in error_line(capfd, "run")


def test_the_temporary_folder_of_a_killed_run_is_refused(run, capfd):
    """Killed after the last write and before the rename."""
    left = run.rename(f".run.{'host'}-123-0123abcd.partial")
    assert "incomplete: the run was killed" in error_line(capfd, str(left))


def test_a_run_without_scans_can_only_be_graded_from_its_tables(run, capfd):
    shutil.rmtree(run / "scans")
    grade(capfd)
    assert "has no recorded scans; run the scenario again with --record-scans" in error_line(
        capfd, "run", "--tracker", SHIPPED
    )


def test_settings_of_another_version_are_a_one_line_error(run, capfd):
    document = written()
    document["config"]["tracker"]["gone"] = 1
    (run / run_folder.RESULT).write_text(json.dumps(document))
    assert "whose settings differ from this version's" in error_line(capfd, "run")


# --- tracks of other programs


OF_BOXES = ("people.", "riders.", "track.", "dataset.", "mma.x_abs", "mma.y_abs", "emergence.")
NOT_IN_FILE = (".prediction_", "velocity", "speed", "acceleration")


@pytest.mark.parametrize("ending", ["csv", "parquet"])
@pytest.mark.parametrize("when", ["frame", "time_s"])
def test_tracks_from_a_file_are_graded_as_in_the_live_run(ending, when, run, capfd):
    """Metrics of boxes and ids are equal; metrics of fields that are not in the file have no value."""
    table = own_tracks(run).drop(columns={"frame": "time_s", "time_s": "frame"}[when])
    table = table.sample(frac=1.0, random_state=0)  # the order of rows is arbitrary
    if ending == "csv":
        table.to_csv("tracks.csv", index=False, float_format="%.17g")
    else:
        table.to_parquet("tracks.parquet")
    graded, live = grade(capfd, "--tracks", f"tracks.{ending}")["metrics"], written()["metrics"]
    for name, metric in live.items():
        of_boxes = name.startswith(OF_BOXES) and not any(word in name for word in NOT_IN_FILE)
        of_boxes |= name.startswith("sim.")  # of the recorded truth
        if of_boxes and metric["value"] is not None:
            assert graded[name]["value"] == pytest.approx(metric["value"], abs=1e-9), name
        elif not of_boxes:
            assert graded[name]["value"] is None, name
            assert graded[name]["reason"]
    assert written()["metrics"]["track.hota"]["value"] > 0.1


def test_optional_columns_can_be_omitted_and_unknown_ones_are_ignored(run, capfd):
    """Without a status all tracks are reported, including tentative ones."""
    table = own_tracks(run).assign(score=0.5).drop(columns=["status", "time_s"])
    table.to_csv("tracks.csv", index=False)
    assert (
        grade(capfd, "--tracks", "tracks.csv")["metrics"]["track.missed"]["value"]
        <= (written()["metrics"]["track.missed"]["value"])
    )


def test_tracks_of_every_third_scan_are_told(run, capfd):
    table = own_tracks(run)
    table[table["frame"] % 3 == 0].to_csv("third.csv", index=False)
    table.to_csv("tracks.csv", index=False)
    known = table.loc[table["frame"] % 3 == 0, "frame"]
    after = written()["frames"] - known.min()
    (warning,) = grade(capfd, "--tracks", "third.csv")["warnings"]
    assert warning.startswith(
        f"third.csv: {after - known.nunique()} of the {after} scans from frame {known.min()} on have no tracks"
    )
    assert grade(capfd, "--tracks", "tracks.csv")["warnings"] == []


def test_an_empty_track_file_scores_zero(run, capfd):
    own_tracks(run).iloc[:0].to_csv("tracks.csv", index=False)
    assert grade(capfd, "--tracks", "tracks.csv", code=1)["metrics"]["track.hota"]["value"] == 0.0


GOOD = {
    "frame": [0, 1],
    "track_id": [3, 3],
    "x_odom_m": [9.0, 9.4],
    "y_odom_m": [3.0, 3.0],
    "heading_odom_rad": [0.0, 0.0],
    "length_m": [4.5, 4.5],
    "width_m": [1.8, 1.8],
}


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"x_odom_m": [9.0, "far"]}, "column x_odom_m, row 2: far: should be a number"),
        ({"x_odom_m": [9.0, np.inf]}, "column x_odom_m, row 2: inf: should be a number"),
        ({"y_odom_m": [None, 3.0]}, "column y_odom_m, row 1: an empty cell: should be a number"),
        ({"track_id": [3, 3.5]}, "column track_id, row 2: 3.5: should be an integer"),
        ({"track_id": [-1, 3]}, "column track_id, row 1: -1: should be 0 or more"),
        ({"frame": [0, 10]}, "column frame, row 2: 10: the run has frames 0 to 9"),
        ({"frame": [0, 0]}, "column track_id, row 2: 3: occurs twice in frame 0; give each track one row per frame"),
        ({"frame": None}, "no column frame or time_s; add one that gives the scan of each row"),
        ({"frame": None, "time_s": [0.0, 0.1]}, "column time_s, row 2: 0.1: no scan is within 1 ms of it"),
        ({"width_m": [1.8, 0.0]}, "column width_m, row 2: 0.0: should be more than 0"),
        ({"length_m": None}, "no column length_m; found frame, track_id, x_odom_m"),
        ({"status": ["confirmed", "lost"]}, "column status, row 2: lost: should be one of tentative, confirmed"),
    ],
    ids=lambda value: value.partition(":")[0] if isinstance(value, str) else "",
)
@pytest.mark.parametrize("ending", few(["csv", "parquet"], "csv"))
@in_run_folder
def test_an_invalid_cell_is_reported_with_file_row_column_and_remedy(changes, message, ending, capfd):
    table = pd.DataFrame({name: cells for name, cells in (GOOD | changes).items() if cells is not None})
    if ending == "csv":
        table.to_csv("bad.csv", index=False)
    elif any(isinstance(cell, str) for cell in table.get("x_odom_m", [])):
        return  # a Parquet column has one type
    else:
        table.to_parquet("bad.parquet")
    assert f"bad.{ending}: {message}" in error_line(capfd, "run", "--tracks", f"bad.{ending}")


def test_a_column_of_parquet_that_occurs_twice_is_refused(tmp_path):
    pq.write_table(pa.table([[1], [2]], names=["frame", "frame"]), tmp_path / "a.parquet")
    with pytest.raises(TracksError, match=r"a\.parquet: column frame occurs twice"):
        track_file.read_table(tmp_path / "a.parquet", parquet=True)


@pytest.mark.parametrize(
    ("name", "content", "message"),
    [
        ("missing.csv", None, "missing.csv: cannot be read (No such file or directory)"),
        ("empty.csv", b"", "cannot be read (No columns to parse from file)"),
        ("no.csv", b"\xff\xfe\x00", "cannot be read ("),
        ("no.parquet", b"frame,track_id", "cannot be read ("),
        ("ragged.csv", b"frame,track_id\n1,2\n1,2,3,4\n", "cannot be read ("),
        (
            "twice.csv",
            b"frame,track_id,track_id \n1,2,3\n",
            "twice.csv: column track_id occurs twice; give each column once",
        ),
    ],
)
@in_run_folder
def test_an_unreadable_track_file_is_a_one_line_error(name, content, message, capfd):
    if content is not None:
        Path(name).write_bytes(content)
    assert message in error_line(capfd, "run", "--tracks", name)


@in_run_folder
def test_tracks_and_tracker_together_are_refused(capfd):
    error = error_line(capfd, "run", "--tracks", "a.csv", "--tracker", SHIPPED)
    assert "--tracks and --tracker are both given; give one" in error


@in_run_folder
def test_a_missing_tracker_is_an_error(capfd):
    assert "--tracker absent:Tracker: no module absent" in error_line(capfd, "run", "--tracker", "absent:Tracker")


@in_run_folder
def test_a_tracker_with_duplicate_ids_is_refused(monkeypatch, capfd):
    """Live and on recorded scans: trackeval's metrics of such tracks are undefined."""
    monkeypatch.syspath_prepend(Path.cwd())
    Path("twice.py").write_text(TWICE)
    for command in (["grade", "run"], ["run", "short.toml", "--in-process"]):
        assert main([*command, "--tracker", "twice:Twice"]) == 4
        error = capfd.readouterr().err
        assert re.search(r"twice:Twice\.step: .*frame \d at 0\.\d\d s: id 0 occurs 2 times", error)
        assert error.count("\n") == 1


TWICE = """
from dataclasses import replace

from luxloop.tracker.tracker import Tracker


class Twice(Tracker):
    def step(self, scan):
        tracks, trace = super().step(scan)
        return replace(tracks, id=0 * tracks.id), trace
"""


def test_an_oracle_receives_the_recorded_truth(run, monkeypatch):
    """As in a live run, the truth of a scan is passed before the scan."""
    received = []

    class Listener(Tracker):
        def see_truth(self, frame, truth):
            received.append((frame.index, len(truth.actor_id)))

        def step(self, scan):
            assert len(scan) == received[-1][1]
            return super().step(scan)

    monkeypatch.setattr(device, "ORACLES", {Listener})
    recorded = RecordedRun.open(run)
    Regrader(recorded, recorded.scenario).tracker(Listener, "listener")
    assert [index for index, _ in received[-short_run.FRAMES :]] == list(range(short_run.FRAMES))
