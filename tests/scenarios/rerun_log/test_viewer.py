"""Choice of the frame to show, and the time cursor of the viewer."""

import json
import os
import signal
import socket
import subprocess
import sys
import time
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import replace
from functools import partial
from urllib.parse import urlsplit
from urllib.request import ProxyHandler, build_opener

import pytest
from support import short_run
from support.viewers import page_of

from luxloop.scenarios.cli import main
from luxloop.scenarios.errors import InputError
from luxloop.scenarios.grading.worst_frames import worst_frames
from luxloop.scenarios.rerun_log import viewer

START_S = 90.0


def test_failed_metric_chooses_the_frame():
    result = short_run.result()
    first = worst_frames(result, "fit.heading_abs_mean_deg", count=1)[0]
    found = viewer.frame_to_show(result, ["perf.sensor_ms_p50", "fit.heading_abs_mean_deg"])
    assert (found.frame, found.time_s) == (first.frame, first.time_s)
    assert found.what.startswith("fit.heading_abs_mean_deg: ")
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


def test_without_a_display_view_points_to_the_browser(capfd, monkeypatch, tmp_path):
    for name in viewer.DISPLAYS:
        monkeypatch.delenv(name, raising=False)
    (tmp_path / "result.json").touch()
    (tmp_path / "recording.rrd").touch()
    assert main(["view", str(tmp_path)]) == 2
    err = capfd.readouterr().err
    assert (
        f"no display: DISPLAY and WAYLAND_DISPLAY are not set; open a browser with luxloop view {tmp_path} --web" in err
    )
    monkeypatch.setenv("WAYLAND_DISPLAY", "wayland-0")
    viewer.require_display(tmp_path)


@pytest.mark.slow
@pytest.mark.parametrize("wanted", [False, True])
def test_analytics_of_the_viewer_are_off_unless_wanted(wanted, tmp_path, monkeypatch):
    """Asks the viewer itself, whose own settings allow them."""
    own = tmp_path / "rerun" / "analytics.json"
    own.parent.mkdir()
    own.write_text(json.dumps({"analytics_enabled": True, "analytics_id": "1", "metadata": {},
                               "config_file_path": str(own), "data_dir_path": str(tmp_path)}))  # fmt: skip
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path))
    with viewer.viewer_environment(wanted) as environment:
        command = [sys.executable, "-m", "rerun", "analytics", "config"]
        shown = subprocess.run(command, env=environment, capture_output=True, text=True, check=True).stdout
    assert json.loads(shown)["analytics_enabled"] is wanted
    assert json.loads(own.read_text())["analytics_enabled"] is True


@contextmanager
def rerun_at(*words):
    """Start rerun at a port of its own; yield the port and the process, which is in a session with its child."""
    port = viewer._free_port()
    command = [sys.executable, "-m", "rerun", "--bind", "127.0.0.1", "--port", str(port), *map(str, words)]
    silent = subprocess.DEVNULL
    shown = subprocess.Popen(command, stdin=silent, stdout=silent, stderr=silent, start_new_session=True)
    try:
        yield port, shown
    finally:
        if shown.poll() is None:
            os.killpg(shown.pid, signal.SIGTERM)
            shown.wait(timeout=20)


@pytest.mark.slow
def test_real_viewer_starts_at_the_first_frame_and_opens_at_the_time(tmp_path):
    """A headless viewer of a served recording, as in a browser; it requires a graphics driver, as Mesa's lavapipe."""
    rerun = pytest.importorskip("rerun.experimental")
    short_run.run(record_to=tmp_path / "short.rrd")
    deadline = time.monotonic() + START_S

    def time_of(port):
        with suppress(ConnectionError, RuntimeError):  # not started yet
            state = rerun.ViewerClient.connect(f"rerun+http://127.0.0.1:{port}/proxy").get_state()
            return [one.current_time for one in state.recordings if one.current_timeline == "sim_time"]

    with rerun_at("--serve-grpc", tmp_path / "short.rrd") as (served, server):
        while server.poll() is None and time.monotonic() < deadline and not _is_served(served):
            time.sleep(0.1)
        with rerun_at("--headless", f"rerun+http://127.0.0.1:{served}/proxy") as (port, shown):
            while shown.poll() is None and time.monotonic() < deadline and time_of(port) in (None, [], [None]):
                time.sleep(0.2)
            if shown.poll() is not None:
                pytest.skip("the viewer does not start here: no graphics driver (Debian: mesa-vulkan-drivers)")
            time.sleep(1.0)  # the cursor would follow the frames that arrive
            assert time_of(port) == [0]
            while time.monotonic() < deadline and not viewer.set_time_cursor(port, 0.4):
                time.sleep(0.2)
            assert time_of(port) == [400_000_000]


@pytest.mark.slow
def test_two_viewers_in_browsers_have_ports_of_their_own_and_end_with_their_commands(tmp_path):
    """SIGTERM to `luxloop view` ends the viewer, which is a process of another process."""
    short_run.run(record_to=tmp_path / "short.rrd")
    command = [sys.executable, "-m", "luxloop", "view", str(tmp_path / "short.rrd"), "--web"]
    environment = {**os.environ, "BROWSER": "true", "RUST_LOG": "info"}  # a recording turns messages off
    with ExitStack() as ended:
        start = partial(subprocess.Popen, command, stderr=subprocess.PIPE, text=True, env=environment)
        shown = [ended.enter_context(start()) for _ in range(2)]
        pages = [page_of(each) for each in shown]
        for page in pages:
            with build_opener(ProxyHandler({})).open(page, timeout=60) as answer:
                assert answer.status == 200
                assert b"Rerun" in answer.read()
        ports = [urlsplit(page).port for page in pages]
        for each in shown:
            each.terminate()
        assert [each.wait(timeout=60) for each in shown] == [143, 143]
    assert len(set(ports)) == 2
    deadline = time.monotonic() + START_S
    while any(map(_is_served, ports)) and time.monotonic() < deadline:
        time.sleep(0.1)
    assert not any(map(_is_served, ports))


def _is_served(port):
    with socket.socket() as probe:
        return probe.connect_ex(("127.0.0.1", port)) == 0
