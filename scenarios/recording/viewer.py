"""The rerun viewer, opened at a moment of a recording.

A recording cannot say where the viewer's time cursor starts, so the viewer is told once it has loaded it. The viewer in
a browser cannot be told.
"""

import socket
import subprocess
import sys
import time
from pathlib import Path

from scenarios.errors import InputError
from scenarios.grading.worst_frames import WorstFrame, worst_frames
from scenarios.result import Result

LOADING_S = 120.0
"""[s] after which the viewer is left where it is."""
POLL_S = 0.2


def moment(result: Result, failed: list[str], frame: int | None = None) -> WorstFrame | None:
    """Choose where to look: in `frame`, else where the first of the `failed` metrics is worst that tells of frames.

    Without any it is the first snapshot, for that is the worst of the gravest kind; None where nothing was wrong.

    Raises
    ------
    InputError
        The run has no such frame.
    """
    if frame is not None:
        times = result.tables["truth"].drop_duplicates("frame").set_index("frame")["time_s"]
        if not 0 <= frame < result.frames:
            raise InputError(f"--frame {frame}: the run has frames 0 to {result.frames - 1}; give one of these")
        period_s = float(times.diff().median()) if len(times) > 1 else 0.0
        return WorstFrame(frame, float(times.get(frame, frame * period_s)), "as asked")
    for metric in failed:
        if found := worst_frames(result, metric, count=1):
            return found[0]._replace(what=f"{metric}: {found[0].what}")
    snapshots = result.tables.get("snapshots")
    if snapshots is None or snapshots.empty:
        return None
    first = snapshots.iloc[0]
    return WorstFrame(int(first["frame"]), float(first["time_s"]), str(first["what"]))


def show(recording: Path, at_s: float | None, *, web: bool = False) -> int:
    """Open a viewer, move its time cursor, wait until it is closed, and return its exit code."""
    port = _free_port()
    command = [sys.executable, "-m", "rerun", "--bind", "127.0.0.1", "--port", str(port), str(recording)]
    with subprocess.Popen(command + ["--web-viewer"] * web) as viewer:
        if at_s is not None and not web:
            deadline = time.monotonic() + LOADING_S
            while viewer.poll() is None and time.monotonic() < deadline and not point_at(port, at_s):
                time.sleep(POLL_S)
        return viewer.wait()


def point_at(port: int, at_s: float) -> bool:
    """Move the time cursor of the viewer at a port of this machine, and say whether it had loaded its recording."""
    from rerun.experimental import ViewerClient

    try:
        client = ViewerClient.connect(f"rerun+http://127.0.0.1:{port}/proxy")
        state = client.get_state()
        if not state.recordings or state.loading:
            return False
        client.set_time("sim_time", duration=at_s, play_state="paused")
    except (ConnectionError, RuntimeError):  # it has not come up yet
        return False
    return True


def _free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port: int = probe.getsockname()[1]
        return port
