"""Where to look: the frames that are kept with their points, those that a metric is worst in, and the viewer at one."""

import os
import signal
import socket
import subprocess
import sys
import time
from dataclasses import replace

import pandas as pd
import pytest
from support import short_run

from scenarios import viewer
from scenarios.cli import main
from scenarios.errors import InputError
from scenarios.grading.snapshots import APART_S, PATIENCE_S, PER_KIND, SNAPSHOT_KINDS
from scenarios.worst import worst_frames
from tracker.scan import Scan
from tracker.tracker import Tracker

START_S = 90.0


class Forgetful(Tracker):
    """Sees nothing in the first two seconds and for one second after four, and then gives its tracks other names."""

    def step(self, scan):
        blind = scan.time < 2.0 or 4.0 <= scan.time < 5.0
        tracks, trace = super().step(Scan.from_points(scan.time, [], scan.ego_pose_odom) if blind else scan)
        return replace(tracks, id=tracks.id + 1000 * (scan.time >= 5.0)), trace


@pytest.fixture(scope="module")
def result():
    """Six seconds; the car that drives is slow, so that both stay near."""
    return short_run.run(short_run.TEXT.replace("speed_mps = 5", "speed_mps = 2"), Forgetful, duration_s=6.0)


def test_few_frames_are_kept_of_each_kind_and_apart(result):
    kept = result.tables["snapshots"]
    assert set(kept["kind"]) >= {"detection", "fit_heading"}
    for _, of_kind in kept.groupby("kind", observed=True):
        assert len(of_kind) <= PER_KIND
        assert of_kind["time_s"].sort_values().diff().dropna().ge(APART_S).all()
        assert of_kind["badness"].is_monotonic_decreasing
    assert kept["kind"].cat.categories.tolist() == list(SNAPSHOT_KINDS)


def test_a_kept_frame_is_the_worst_there_is(result):
    truth, fits = result.tables["truth"], result.tables["fits"]
    lost = truth[truth["graded"] & (truth["track_id"] < 0) & (truth["time_s"] >= PATIENCE_S)].groupby("frame").size()
    false = result.tables["tracks"].query("verdict == 'false'").groupby("frame").size()
    wrong = lost.add(false, fill_value=0)
    kept = result.tables["snapshots"].set_index("kind")
    detection = kept.loc[["detection"]].iloc[0]
    assert detection["badness"] == wrong.max() == wrong[detection["frame"]]
    fit = kept.loc[["fit_heading"]].iloc[0]
    assert fit["badness"] >= fits.loc[fits["best"], "heading_error_deg"].abs().max() - 1e-9
    assert f"{fit['badness']:.1f}" in fit["what"]


def test_a_vehicle_that_has_just_come_is_not_missed_yet(result):
    """Fails when the first frames, in which nothing can have a track, crowd out what is worth a look."""
    kept = result.tables["snapshots"]
    assert (kept.loc[kept["kind"] == "detection", "time_s"] >= PATIENCE_S).all()


def test_an_identity_that_is_lost_is_kept(result):
    kept = result.tables["snapshots"].query("kind == 'identity'")
    assert len(kept) == 1
    assert (kept["badness"].item(), round(kept["time_s"].item(), 2)) == (2.0, 5.04)
    assert kept["what"].item().count(" goes from track ") == 2


def test_points_of_kept_frames_are_all_there(result):
    points, truth = result.tables["snapshot_points"], result.tables["truth"]
    assert set(points["frame"]) == set(result.tables["snapshots"]["frame"])
    own = points[points["actor_id"] >= 0].groupby(["frame", "actor_id"]).size()
    told = truth[truth["frame"].isin(points["frame"]) & (truth["points"] > 0)].set_index(["frame", "actor_id"])
    pd.testing.assert_series_equal(own, told["points"].sort_index(), check_names=False)


def test_newcomers_without_a_track_are_not_the_worst_of_missed(result):
    worst = worst_frames(result, "track.missed", count=1)[0]
    assert worst.time_s >= PATIENCE_S
    assert worst.what.startswith("2 graded vehicles without a track")


def test_the_viewer_goes_to_what_failed(result):
    first = worst_frames(result, "fit.best.heading_abs_mean_deg", count=1)[0]
    found = viewer.moment(result, ["perf.sensor_ms_p50", "fit.best.heading_abs_mean_deg"])
    assert (found.frame, found.time_s) == (first.frame, first.time_s)
    assert found.what.startswith("fit.best.heading_abs_mean_deg: ")
    unfailed = viewer.moment(result, [])
    assert unfailed.frame == result.tables["snapshots"]["frame"][0]
    assert viewer.moment(result, [], frame=12)[:2] == (12, pytest.approx(12 * 0.08))
    spotless = replace(result, tables={**result.tables, "snapshots": result.tables["snapshots"].iloc[:0]})
    assert viewer.moment(spotless, []) is None


def test_the_viewer_wants_a_frame_of_the_run(result):
    with pytest.raises(InputError, match=f"--frame {result.frames}: the run has frames 0 to {result.frames - 1}"):
        viewer.moment(result, [], frame=result.frames)


def test_view_wants_a_run_with_a_recording(capfd, tmp_path):
    assert main(["view", str(tmp_path), "--frame", "3"]) == 2
    assert "no result.json of a run in it" in capfd.readouterr().err


def test_the_real_viewer_opens_at_the_moment(tmp_path):
    """A viewer without a window, which needs a graphics driver nonetheless; Mesa's lavapipe will do."""
    rerun = pytest.importorskip("rerun.experimental")
    recording = tmp_path / "short.rrd"
    short_run.run(record_to=recording)
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
    command = [sys.executable, "-m", "rerun", "--headless", "--bind", "127.0.0.1", "--port", str(port), str(recording)]
    log = (tmp_path / "log").open("w")
    # A session of its own, for the viewer is a child of this child.
    shown = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=log, stderr=log, start_new_session=True)
    try:
        deadline = time.monotonic() + START_S
        while shown.poll() is None and time.monotonic() < deadline and not viewer.point_at(port, 0.4):
            time.sleep(0.2)
        if shown.poll() is not None:
            pytest.skip("the viewer does not start here: no graphics driver (Debian: mesa-vulkan-drivers)")
        state = rerun.ViewerClient.connect(f"rerun+http://127.0.0.1:{port}/proxy").get_state()
        assert [(one.current_timeline, one.current_time) for one in state.recordings] == [("sim_time", 400_000_000)]
    finally:
        log.close()
        if shown.poll() is None:
            os.killpg(shown.pid, signal.SIGTERM)
            shown.wait(timeout=20)
