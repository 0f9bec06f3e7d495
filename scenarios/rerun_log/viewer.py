"""Rerun viewer, opened at a given time of a recording.

A recording cannot set the start of the viewer's time cursor. The cursor is therefore set after loading. In a browser
this is not possible: there, a paused recording starts at its first frame.
"""

import json
import os
import signal
import socket
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from luxloop.scenarios.errors import InputError
from luxloop.scenarios.grading.worst_frames import WorstFrame, worst_frames
from luxloop.scenarios.result import Result

LOADING_S = 120.0
"""Timeout of setting the time cursor [s]."""
DISPLAYS = ("DISPLAY", "WAYLAND_DISPLAY")
"""Environment variables of which one names the screen."""
POLL_S = 0.2
"""Interval between attempts [s]."""


def frame_to_show(result: Result, failed: list[str], frame: int | None = None) -> WorstFrame | None:
    """Choose the frame to show.

    `frame` has priority. Next is the worst frame of the first of the `failed` metrics that has worst frames. Otherwise
    it is the first snapshot, the worst of the most serious kind, or None without snapshots.

    Raises
    ------
    InputError
        The run does not have `frame`.
    """
    if frame is not None:
        times = result.tables["truth"].drop_duplicates("frame").set_index("frame")["time_s"]
        if not 0 <= frame < result.frames:
            raise InputError(f"--frame {frame}: the run has frames 0 to {result.frames - 1}; give one of these")
        period_s = float(times.diff().median()) if len(times) > 1 else 0.0
        return WorstFrame(frame, float(times.get(frame, frame * period_s)), "as requested")
    for metric in failed:
        if found := worst_frames(result, metric, count=1):
            return found[0]._replace(what=f"{metric}: {found[0].what}")
    snapshots = result.tables.get("snapshots")
    if snapshots is None or snapshots.empty:
        return None
    first = snapshots.iloc[0]
    return WorstFrame(int(first["frame"]), float(first["time_s"]), str(first["what"]))


def require_display(run: Path) -> None:
    """Check that a window can be opened.

    Raises
    ------
    InputError
        There is neither an X server nor a Wayland compositor.
    """
    if sys.platform == "linux" and not any(os.environ.get(name) for name in DISPLAYS):
        missing = " and ".join(DISPLAYS)
        raise InputError(f"no display: {missing} are not set; open a browser with luxloop view {run} --web")


def show(recording: Path, at_s: float | None, *, web: bool = False, analytics: bool = False) -> int:
    """Open a viewer, set its time cursor, wait until it is closed, and return its exit code.

    Parameters
    ----------
    recording
        The .rrd file.
    at_s
        Simulated time of the cursor [s]; None does not set it.
    web
        Open in a browser (starts at the first frame).
    analytics
        False keeps the viewer from sending statistics of its use; True leaves that to its own settings.
    """
    port = _free_port()
    command = [sys.executable, "-m", "rerun", "--bind", "127.0.0.1", "--port", str(port), str(recording)]
    if web:
        command += ["--web-viewer", "--web-viewer-port", "0"]  # any free one
    with viewer_environment(analytics) as environment, _started(command, environment) as viewer:
        if at_s is not None and not web:
            deadline = time.monotonic() + LOADING_S
            while viewer.poll() is None and time.monotonic() < deadline and not set_time_cursor(port, at_s):
                time.sleep(POLL_S)
        return viewer.wait()


@contextmanager
def _started(command: list[str], environment: dict[str, str]) -> Iterator[subprocess.Popen[bytes]]:
    """Start the viewer, and end it with this process: a signal to this process does not reach the viewer."""
    with subprocess.Popen(command, env=environment, start_new_session=True) as viewer:
        try:
            yield viewer
        finally:
            with suppress(ProcessLookupError):  # it is closed
                os.killpg(viewer.pid, signal.SIGTERM)


@contextmanager
def viewer_environment(analytics: bool) -> Iterator[dict[str, str]]:
    """Yield the environment of a viewer; it has no option for its analytics, only a file of settings."""
    if analytics:
        yield dict(os.environ)
        return
    with tempfile.TemporaryDirectory(prefix="luxloop-viewer-") as folder:
        file = Path(folder) / "rerun" / "analytics.json"
        file.parent.mkdir()
        off = {"analytics_enabled": False, "analytics_id": "", "metadata": {}}
        places = {"config_file_path": str(file), "data_dir_path": str(file.parent / "analytics")}
        file.write_text(json.dumps(off | places), encoding="utf-8")
        yield os.environ | {"XDG_CONFIG_HOME": folder}


def set_time_cursor(port: int, at_s: float) -> bool:
    """Set the time cursor of the viewer at a local port; return False if it has not loaded its recording yet."""
    from rerun.experimental import ViewerClient

    try:
        client = ViewerClient.connect(f"rerun+http://127.0.0.1:{port}/proxy")
        state = client.get_state()
        if not state.recordings or state.loading:
            return False
        client.set_time("sim_time", duration=at_s, play_state="paused")
    except (ConnectionError, RuntimeError):  # not started yet
        return False
    return True


def _free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port: int = probe.getsockname()[1]
        return port
