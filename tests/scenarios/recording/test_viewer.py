"""Choice of the frame to show, and the time cursor of the viewer."""

import os
import signal
import socket
import subprocess
import sys
import time
from dataclasses import replace

import pytest
from support import short_run

from scenarios.cli import main
from scenarios.errors import InputError
from scenarios.grading.worst_frames import worst_frames
from scenarios.recording import viewer

START_S = 90.0


def test_failed_metric_chooses_the_frame():
    result = short_run.result()
    first = worst_frames(result, "fit.best.heading_abs_mean_deg", count=1)[0]
    found = viewer.frame_to_show(result, ["perf.sensor_ms_p50", "fit.best.heading_abs_mean_deg"])
    assert (found.frame, found.time_s) == (first.frame, first.time_s)
    assert found.what.startswith("fit.best.heading_abs_mean_deg: ")
    unfailed = viewer.frame_to_show(result, [])
    assert unfailed.frame == result.tables["snapshots"]["frame"][0]
    assert viewer.frame_to_show(result, [], frame=7)[:2] == (7, pytest.approx(7 * 0.08))
    spotless = replace(result, tables={**result.tables, "snapshots": result.tables["snapshots"].iloc[:0]})
    assert viewer.frame_to_show(spotless, []) is None


def test_frame_outside_of_the_run_is_refused():
    result = short_run.result()
    with pytest.raises(InputError, match=f"--frame {result.frames}: the run has frames 0 to {result.frames - 1}"):
        viewer.frame_to_show(result, [], frame=result.frames)


def test_view_requires_a_run_folder(capfd, tmp_path):
    assert main(["view", str(tmp_path), "--frame", "3"]) == 2
    assert "no result.json of a run in it" in capfd.readouterr().err


def test_real_viewer_opens_at_the_time(tmp_path):
    """A headless viewer, which requires a graphics driver; Mesa's lavapipe is sufficient."""
    rerun = pytest.importorskip("rerun.experimental")
    recording = tmp_path / "short.rrd"
    short_run.run(record_to=recording)
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
    command = [sys.executable, "-m", "rerun", "--headless", "--bind", "127.0.0.1", "--port", str(port), str(recording)]
    log = (tmp_path / "log").open("w")
    # A separate session, because the viewer is a child of this child.
    shown = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=log, stderr=log, start_new_session=True)
    try:
        deadline = time.monotonic() + START_S
        while shown.poll() is None and time.monotonic() < deadline and not viewer.set_time_cursor(port, 0.4):
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
