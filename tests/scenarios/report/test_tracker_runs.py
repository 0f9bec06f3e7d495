"""`luxloop report RUN RUN`: several trackers of one drive on one page and in one recording."""

import shutil

import numpy as np
import pytest
from support import short_run
from support.paths import EXAMPLES

from luxloop.scenarios.cli import main
from luxloop.scenarios.document import html
from luxloop.scenarios.grading.worst_frames import WorstFrame
from luxloop.scenarios.report.html.reported_run import ReportedRun, apart
from luxloop.scenarios.report.html.shown_frames import frame_points, shown_frames
from luxloop.scenarios.report.html.trackers_page import read_trackers, trackers_page
from luxloop.scenarios.rerun_log.recorded_points import read_points
from luxloop.scenarios.run import run_folder

NEAREST = f"{EXAMPLES / 'ci/my_tracker.py'}:Nearest"


def run(folder, name, *options, text=short_run.TEXT, file="short"):
    scenario = short_run.write(folder, text, file)
    assert main(["run", str(scenario), "--out", str(folder / name), "--quiet", *options]) == 0
    return folder / name


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("trackers")
    run(folder, "one")
    run(folder, "two", "--tracker", NEAREST, "--no-recording")
    return folder


@pytest.fixture(scope="module")
def recording(folder):
    out = folder / "both.rrd"
    runs = [str(folder / "two"), str(folder / "one")]
    assert main(["report", *runs, "--out", str(folder / "both.html"), "--recording", str(out)]) == 0
    return out


def entities(path):
    from rerun.chunk import RrdReader

    found = {}
    for chunk in RrdReader(path).stream():
        if not chunk.is_static:
            for name, values in chunk.to_record_batch().to_pydict().items():
                found.setdefault(chunk.entity_path, {}).setdefault(name, []).extend(values)
    return found


def test_each_tracker_is_an_entity_over_the_same_scans(folder, recording):
    found, alone = entities(recording), entities(folder / "one" / run_folder.RECORDING)
    assert {path for path in found if path.startswith("/world/trackers") and path.count("/") == 3} == {
        "/world/trackers/1-Nearest",
        "/world/trackers/2-Tracker",
    }
    assert found["/world/ego/points"]["Points3D:positions"] == alone["/world/ego/points"]["Points3D:positions"]
    assert found["/world/truth"]["Boxes3D:labels"] == alone["/world/truth"]["Boxes3D:labels"]
    assert not {path for path in found if path.startswith(("/world/odom", "/events"))}


def test_tracks_of_a_tracker_are_where_its_tables_have_them(folder, recording):
    """World coordinates of a recording begin at the ego's start."""
    boxes = entities(recording)["/world/trackers/2-Tracker"]
    table = run_folder.read(folder / "one").tables["tracks"]
    ego = run_folder.read(folder / "one").tables["ego"].iloc[0]
    last = table[(table["frame"] == 9) & table["status"].isin(("confirmed", "coasting"))]
    row = boxes["frame"].index(9)
    shown = np.array(boxes["Boxes3D:centers"][row])[:, :2] if len(last) else np.empty((0, 2))
    expected = last[["x_world_m", "y_world_m"]].to_numpy() - ego[["x_world_m", "y_world_m"]].to_numpy(float)
    assert len(last) > 0
    np.testing.assert_allclose(shown, expected, atol=1e-4)


def test_counts_of_missed_vehicles_are_those_of_the_tables(folder, recording):
    missed = entities(recording)["/plots/missed"]
    for number, name in enumerate(("two", "one")):
        truth = run_folder.read(folder / name).tables["truth"]
        expected = [int((truth["graded"] & (truth["track_id"] < 0) & (truth["frame"] == k)).sum()) for k in range(10)]
        assert [row[number] for row in missed["Scalars:scalars"]] == expected


@pytest.mark.usefixtures("recording")
def test_page_has_both_trackers_side_by_side(folder):
    page = (folder / "both.html").read_text(encoding="utf-8")
    assert "<title>short: 2 trackers</title>" in page
    runs = read_trackers([folder / "two", folder / "one"])
    assert list(runs) == ["Nearest", "Tracker"]
    head, hota = '<th scope="col" class="right">Nearest</th><th scope="col" class="right">Tracker</th>', []
    assert head in page
    for one in runs.values():
        hota.append(f"{one.result.metrics['track.hota'].value:.3f}")
    row = page[page.index('<th scope="row">track.<wbr>hota</th>') :][:200]
    assert row.index(hota[0]) < row.rindex(hota[1])
    assert "track.missed_share" in page
    assert "class car" in page
    assert "range 0-15 m" in page


def test_equal_names_are_replaced_by_folders(folder):
    shutil.copytree(folder / "one", folder / "again", dirs_exist_ok=True)
    assert list(read_trackers([folder / "one", folder / "again"])) == ["one", "again"]
    shown = html.page(trackers_page(read_trackers([folder / "one", folder / "again"])))
    assert '<span class="bold">again</span>' in shown


def test_runs_of_different_traffic_are_refused(folder, tmp_path, capfd):
    other = short_run.TEXT.replace("speed_mps = 5", "speed_mps = 6")
    moved = run(tmp_path, "moved", "--no-recording", text=other)
    assert main(["report", str(folder / "one"), str(moved), "--out", str(tmp_path / "page.html")]) == 2
    assert f"{moved}: its traffic differs from that of {folder / 'one'}" in capfd.readouterr().err
    assert not (tmp_path / "page.html").exists()


@pytest.mark.slow
def test_runs_of_different_scenarios_are_a_suite(folder, tmp_path):
    other = run(tmp_path, "other", "--no-recording", file="other")
    assert main(["report", str(folder / "one"), str(other), "--out", str(tmp_path / "page.html")]) == 0
    assert "<title>passed: 2 runs</title>" in (tmp_path / "page.html").read_text(encoding="utf-8")


def test_default_page_of_several_folders_is_beside_the_first(folder):
    assert main(["report", str(folder / "one"), str(folder / "two")]) == 0
    assert "2 trackers" in (folder / "report.html").read_text(encoding="utf-8")


@pytest.mark.parametrize(
    ("runs", "said"),
    [
        (["two", "copy"], "no recording.rrd in any of the runs; run one of them without --no-recording"),
        (["one"], "--recording {out}: needs runs of one scenario and seed by several trackers"),
    ],
)
def test_recording_without_scans_or_without_several_trackers_is_refused(folder, tmp_path, capfd, runs, said):
    shutil.copytree(folder / "two", folder / "copy", dirs_exist_ok=True)
    out = tmp_path / "both.rrd"
    command = ["report", *(str(folder / name) for name in runs), "--out", str(tmp_path / "page.html")]
    assert main([*command, "--recording", str(out)]) == 2
    assert said.format(out=out) in capfd.readouterr().err
    assert list(tmp_path.iterdir()) == []


def test_points_are_read_from_the_recording_as_the_run_had_them(folder):
    """The points of the kept frames are in the tables, too: both ways give the same."""
    one = ReportedRun.read(folder / "one")
    kept = one.result.tables["snapshot_points"]
    frames = set(kept["frame"])
    assert frames
    read = read_points(folder / "one" / run_folder.RECORDING, frames)
    for frame in frames:
        expected, found = kept[kept["frame"] == frame], read[read["frame"] == frame]
        np.testing.assert_array_equal(found[["x_ego_m", "y_ego_m"]], expected[["x_ego_m", "y_ego_m"]])
        np.testing.assert_array_equal(found["noise"], expected["cause"] != "clean")
        clean = (expected["cause"] == "clean").to_numpy()
        np.testing.assert_array_equal(found["on_actor"][clean], expected["actor_id"][clean] >= 0)
    everything = frame_points(folder / "one", one.result, range(10))
    assert set(everything["frame"]) == set(range(10))
    without = frame_points(folder / "two", run_folder.read(folder / "two"), range(10))
    assert set(without["frame"]) < set(range(10))


def test_damaged_recording_has_no_points(tmp_path):
    (tmp_path / "torn.rrd").write_bytes(b"RRF2 and then nothing")
    assert read_points(tmp_path / "torn.rrd", {0}).empty


def test_worst_frames_of_a_metric_show_different_situations():
    frames = [WorstFrame(number, 0.08 * number, "bad") for number in (50, 51, 49, 63, 62, 10, 90)]
    assert [frame.frame for frame in apart(frames)] == [50, 63, 10]


def test_worst_frames_of_every_failed_metric_come_before_second_ones(folder):
    result = run_folder.read(folder / "one")
    worst = {"a": [WorstFrame(3, 0.24, "a3"), WorstFrame(4, 0.32, "a4")], "b": [WorstFrame(5, 0.4, "b5")]}
    assert list(shown_frames(result, worst, least=0, most=2)) == [3, 5]
    every = shown_frames(result, worst, least=0, most=9)
    assert list(every) == [3, 5, 4]
    assert every[3].titles == ["a"]
    assert len(shown_frames(result, {}, least=2, most=9)) == min(2, len(set(result.tables["snapshots"]["frame"])))


@pytest.mark.slow
def test_results_of_a_run_name_vehicles_as_the_truth_does(folder):
    """The label of a vehicle is its name in worst frames, snapshots, pictures, timelines and the frame player."""
    one = ReportedRun.read(folder / "one")
    names = set(one.result.tables["truth"]["name"])
    assert main(["report", str(folder / "one")]) == 0
    page = (folder / "one.html").read_text(encoding="utf-8")
    graded = set(one.result.tables["truth"].query("graded")["name"])
    assert graded
    for name in graded:
        assert f">{name}</text>" in page
    texts = "; ".join(one.result.tables["snapshots"]["what"])
    assert any(f"vehicle {name} " in texts for name in names)
