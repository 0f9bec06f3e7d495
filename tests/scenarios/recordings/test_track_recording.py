"""`luxloop track` and `luxloop grade` on the drive of `support.recorded_drive`."""

import io
import json
import shutil
from contextlib import redirect_stdout

import numpy as np
import pandas as pd
import pytest
from support import recorded_drive as drive
from support.compiling_tracker import SPEC
from support.few import few

from luxloop.scenarios.cli import main
from luxloop.scenarios.run import progress, run_folder

MINE = """
from luxloop.tracker.tracker import Tracker

class Mine(Tracker):
    pass
"""


RULES = """
description = "limits of a recording"
duration_s = 1.0
[traffic]
kind = "highway-env"
env = "highway-v0"
[expect]
"track.hota" = { min = 0.3 }
"track.missed" = { max = 0, need = "no vehicle is missed" }
"""


@pytest.fixture(scope="module")
def recording(tmp_path_factory):
    folder = tmp_path_factory.mktemp("drive")
    drive.write_ros1(folder / "drive.bag")
    assert main(["import", str(folder / "drive.bag"), "--out", str(folder / "recorded"), *drive.OPTIONS]) == 0
    return folder / "recorded"


@pytest.fixture(scope="module")
def printed(recording):
    """Track the recording; return the lines of the first screen."""
    text = io.StringIO()
    with redirect_stdout(text):
        assert main(["track", str(recording), "--out", str(recording.parent / "tracks")]) == 0
    return text.getvalue().splitlines()


@pytest.fixture(scope="module")
def tracked(recording, printed):
    assert printed
    return recording.parent / "tracks"


def graded(capsys, *arguments):
    capsys.readouterr()
    assert main(["grade", *map(str, arguments), "--json"]) == 0
    return json.loads(capsys.readouterr().out)["metrics"]


def test_the_folder_holds_tracks_report_and_recording(tracked):
    names = {path.name for path in tracked.iterdir()}
    assert names == {"tracks.parquet", "report.html", "recording.rrd", "result.json", "report.txt", "tables"}
    assert (tracked / "recording.rrd").stat().st_size > 10_000
    page = (tracked / "report.html").read_text()
    assert "Lives and speeds" in page
    assert "<svg" in page


def test_the_first_screen_is_printed_and_the_whole_report_with_full(recording, printed, tmp_path, capsys):
    lines, out = printed, recording.parent / "tracks"
    assert len(lines) <= 20
    assert lines[0] == "NO LIMITS  recorded: nothing in [expect] to pass or fail"
    assert lines[1].startswith(f"{drive.SCANS} frames, 1 vehicle, tracker ")
    assert lines[2].startswith("1 confirmed track, median life 2.7 s, ")
    assert lines[4].startswith("Main figures")
    commands = [line.partition("   ")[0].strip() for line in lines[-2:]]
    assert commands == [f"luxloop view {out}", str(out / "report.html")]
    out = tmp_path / "tracks"
    assert main(["track", str(recording), "--out", str(out), "--full"]) == 0
    whole = capsys.readouterr().out
    assert whole.startswith((out / "report.txt").read_text())
    assert whole.endswith(f"Results are in {out}; the report is {out / 'report.html'}; to view: luxloop view {out}\n")


def test_a_limit_that_fails_is_on_the_first_screen_and_in_the_report(recording, tmp_path, capsys):
    (tmp_path / "rules.toml").write_text(RULES)
    arguments = ["--scenario", str(tmp_path / "rules.toml"), "--out", str(tmp_path / "out"), "--no-recording"]
    assert main(["track", str(recording), *arguments]) == 1
    lines = capsys.readouterr().out.splitlines()
    assert len(lines) <= 20
    assert lines[0] == "FAILED  recorded: 1 of 2 expectations hold, 1 failed"
    failing = lines[lines.index("1 limit does not hold") + 1]
    assert failing.split()[:4] == ["track.missed", "2", ">", "0"]
    report = (tmp_path / "out" / "report.txt").read_text()
    assert "no vehicle is missed" in report
    assert report.startswith("FAILED: 1 of 2 expectations hold, 1 failed; 1 confirmed track")


@pytest.mark.parametrize("command", few(["track", "grade"], "track"))
def test_a_log_names_the_compilation_of_kernels(command, recording, tmp_path, monkeypatch, capfd):
    monkeypatch.setattr(progress, "SILENCE_S", 0.01)
    assert main([command, str(recording), "--tracker", SPEC, "--out", str(tmp_path / "out"), "--json"]) == 0
    assert capfd.readouterr().err == "luxloop: recorded: compiling numba kernels, up to two minutes, only once\n"


def test_the_car_has_one_track_at_its_speed_and_place(tracked):
    tracks = pd.read_parquet(tracked / "tracks.parquet")
    confirmed = tracks[(tracks["status"] == "confirmed") & (tracks["time_s"] > 1.5)]
    assert confirmed["track_id"].nunique() == 1
    assert confirmed["speed_mps"].median() == pytest.approx(drive.CAR_MPS, abs=0.5)
    centre = drive.CAR_START[0] + drive.CAR_MPS * confirmed["time_s"]
    assert np.abs(confirmed["x_odom_m"] - centre).median() < 0.5


def test_grades_of_tracker_and_file_of_tracks_agree(recording, tracked, capsys):
    by_tracker = graded(capsys, recording)
    by_file = graded(capsys, recording, "--tracks", tracked / "tracks.parquet")
    assert by_tracker["track.hota"]["value"] > 0.3
    assert by_file["track.hota"]["value"] == pytest.approx(by_tracker["track.hota"]["value"])
    assert by_tracker["track.speed_abs_mean_mps"]["value"] < 1.0
    assert by_file["track.speed_abs_mean_mps"]["value"] < 1.0


def test_what_a_recording_does_not_show_is_null_with_the_reason(recording, capsys):
    metrics = graded(capsys, recording)
    for name in ("outliers.recall{cause=mirror}", "track.occlusion_survival", "perf.sim_ms_p50"):
        assert metrics[name]["value"] is None
        assert metrics[name]["reason"]
    assert metrics["perf.tracker_ms_p50"]["value"] > 0


def test_sides_that_a_recording_does_not_show_have_no_figures(tracked):
    figures = run_folder.read(tracked).metrics
    for name in ("fit.iou_mean{view=l_shape}", "track.missed_share{view=none}", "outliers.recall{cause=mirror}"):
        assert figures[name].value is None, name
        assert "not known in a recording" in figures[name].reason


@pytest.mark.slow
def test_another_tracker_runs_on_the_same_scans(recording, tmp_path, capsys):
    (tmp_path / "own_tracker.py").write_text(MINE)
    spec = f"{tmp_path / 'own_tracker.py'}:Mine"
    assert graded(capsys, recording, "--tracker", spec)["track.hota"]["value"] > 0.3
    out = tmp_path / "out"
    assert main(["track", str(recording), "--tracker", spec, "--out", str(out), "--json", "--no-recording"]) == 0
    document = json.loads(capsys.readouterr().out)
    assert document["config"]["device"] == spec
    assert not (out / "recording.rrd").exists()


def test_a_recording_without_truth_is_tracked_but_not_graded(recording, tmp_path, capsys):
    bare = tmp_path / "bare"
    shutil.copytree(recording, bare)
    (bare / "labels.parquet").unlink()
    assert main(["track", str(bare), "--out", str(tmp_path / "out"), "--json", "--no-recording"]) == 0
    metrics = json.loads(capsys.readouterr().out)["metrics"]
    assert metrics["track.false"]["value"] is None
    assert "no true poses" in metrics["track.hota"]["reason"]
    assert main(["grade", str(bare)]) == 2
    assert "no true poses" in capsys.readouterr().err


@pytest.mark.parametrize("damage", ["points.parquet", "scans.parquet", "labels.parquet"])
def test_a_damaged_recording_is_one_line_and_leaves_no_folder(damage, recording, tmp_path, capsys):
    broken = tmp_path / "broken"
    shutil.copytree(recording, broken)
    path = broken / damage
    path.write_bytes(path.read_bytes()[:-20])
    assert main(["track", str(broken), "--out", str(tmp_path / "out")]) == 2
    lines = capsys.readouterr().err.splitlines()
    assert len(lines) == 1
    assert str(broken) in lines[0]
    assert not (tmp_path / "out").exists()


def test_wrong_folders_name_the_remedy(recording, tracked, tmp_path, capsys):
    for arguments, words in (
        (["track", str(tmp_path)], "luxloop import"),
        (["track", str(recording), "--out", str(recording / "inside")], "inside it"),
        (["track", str(recording), "--out", str(recording.parent)], "contains it"),
        (["grade", str(tracked)], "luxloop grade RECORDING --tracks"),
        (["grade", str(recording), "--tracks", str(tmp_path / "none.csv")], "none.csv"),
    ):
        assert main(arguments) == 2
        assert words in capsys.readouterr().err
