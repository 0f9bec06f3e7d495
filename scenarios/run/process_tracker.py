"""Trackers in a process of their own: a class or function of the user, or any program that reads scans.

They cannot reach the ground truth or the harness; they may crash, exit, print to standard error, or hang.

Messages of programs are little-endian columns, as in docs/own-tracker.md. Both sides begin with `GREETING`. A
message is its length in bytes (uint32, not counted) and a body. Those of Python are in `tracker_server`.
"""

import os
import pickle
import shlex
import shutil
import struct
import time
from pathlib import Path
from typing import Protocol

import numpy as np

from luxloop.scenarios.errors import DeviceError
from luxloop.scenarios.run import child_process
from luxloop.scenarios.run.child_process import ChildError, ChildProcess, ChildTimeoutError
from luxloop.scenarios.run.record_messages import ANSWER, TEXT_MAX, Kind, decode
from luxloop.tracker.records import StepTrace, Tracks
from luxloop.tracker.scan import Scan
from luxloop.tracker.tracker import TrackerConfig

GREETING = b"LUXLOOP1"
LENGTH = struct.Struct("<I")
SCAN_HEAD = struct.Struct("<II4d")
"""Frame, number of points N, time [s], and the ego pose in the odometry frame: x [m], y [m], yaw [rad]."""
SCAN_COLUMNS = {
    "time_offset": "<f4",
    "echo_pulse_width": "<f4",
    "flags": "<u2",
    "unit": "u1",
    "layer": "u1",
    "echo": "u1",
}
"""Columns of N points after x, y and z (float32)."""
TRACKS_HEAD = struct.Struct("<II")
"""Frame, number of tracks T."""
TRACK_FLOATS = ("x", "y", "heading", "length", "width", "vx", "vy")
"""Columns of T tracks (float64) after the ids (int64) and before the status (uint8)."""
TRACK_BYTES = 8 + 8 * len(TRACK_FLOATS) + 1


def scan_message(frame: int, scan: Scan) -> bytes:
    """Return the message of a scan."""
    head = SCAN_HEAD.pack(frame, len(scan), scan.time, *scan.ego_pose_odom)
    points = [scan.points_ego[:, axis].astype("<f4").tobytes() for axis in range(3)]
    columns = [getattr(scan, name).astype(dtype).tobytes() for name, dtype in SCAN_COLUMNS.items()]
    body = b"".join([head, *points, *columns])
    return LENGTH.pack(len(body)) + body


def tracks_of(body: bytes, frame: int) -> Tracks:
    """Return the tracks of a message body.

    Raises
    ------
    ValueError
        The body is not an answer to this frame.
    """
    if len(body) < TRACKS_HEAD.size:
        raise ValueError(f"answered {len(body)} bytes; an answer begins with its frame and its number of tracks")
    answered, count = TRACKS_HEAD.unpack_from(body)
    if answered != frame:
        raise ValueError(f"answered to frame {answered}")
    if len(body) != TRACKS_HEAD.size + count * TRACK_BYTES:
        wanted = f"{TRACKS_HEAD.size} and {TRACK_BYTES} for each"
        raise ValueError(f"answered {len(body)} bytes for {count} tracks; give {wanted}")
    ids = np.frombuffer(body, "<i8", count, TRACKS_HEAD.size)
    start = TRACKS_HEAD.size + 8 * count
    values = np.frombuffer(body, "<f8", len(TRACK_FLOATS) * count, start).reshape(len(TRACK_FLOATS), count)
    x, y, heading, length, width, vx, vy = values
    return Tracks.from_boxes(
        ids,
        np.column_stack([x, y]),
        heading,
        np.column_stack([length, width]),
        velocity=np.column_stack([vx, vy]),
        status=np.frombuffer(body, "u1", count, start + values.nbytes),
    )


PREFIX = "process:"
STEP_TIMEOUT_S = 60.0
"""Default limit of one step of a tracker [s]."""
START_FACTOR = 10
"""The warm-up and the start of a tracker may take this many times the limit of a step: they compile kernels."""
IMPORT_TIMEOUT_S = 120.0
"""Limit of the import of a tracker's class, with all that it imports and compiles [s]."""
ANSWER_MAX = 10_000 * TRACK_BYTES
"""Longest answer of a program [bytes]; a longer one is taken for text on standard output."""
OUTPUT_MAX = 1 << 28
"""Longest output of a tracker in Python [bytes]."""


class TrackerProcess(Protocol):
    """A tracker in another process."""

    limit_s: float
    """Limit of one answer [s]."""

    def step(self, scan: Scan) -> Tracks | tuple[Tracks, StepTrace]:
        """Send a scan and return the answer."""
        ...

    def finish(self) -> None:
        """End the tracker after its last scan."""
        ...

    def close(self) -> None:
        """Kill what is left of it."""
        ...


class ProcessFactory:
    """Starts a program for each tracker.

    Parameters
    ----------
    command
        Program and arguments, as in a shell, without shell syntax. It runs in an empty folder of its own, so arguments
        that are files of the current folder become absolute paths.

    Raises
    ------
    DeviceError
        There is no such program.
    """

    def __init__(self, command: str) -> None:
        try:
            words = shlex.split(command)
        except ValueError as error:
            raise DeviceError(f"--tracker {PREFIX}{command}: {error}; quote the command as for a shell") from error
        program = shutil.which(words[0]) if words else None
        if program is None:
            raise DeviceError(f"--tracker {PREFIX}{command}: no program {words[:1]}; give a path or a name")
        program = str(Path(program).absolute()) if os.sep in program else program
        files = {word: str(Path(word).absolute()) for word in words if Path(word).is_file()}
        self._arguments = [program, *(files.get(word, word) for word in words[1:])]

    def start(self, _config: TrackerConfig, limit_s: float) -> "ProcessTracker":
        """Start the program."""
        return ProcessTracker(self._arguments, limit_s)

    def __str__(self) -> str:
        return f"{PREFIX}{shlex.join(self._arguments)}"


class ProcessTracker:
    """A running program.

    Raises
    ------
    ChildError, ChildTimeoutError
        It does not answer the greeting.
    """

    def __init__(self, arguments: list[str], limit_s: float) -> None:
        self.limit_s = limit_s
        self._frame = 0
        self._process = ChildProcess(arguments)
        deadline = time.monotonic() + limit_s
        self._process.send(GREETING, deadline)
        answer = self._process.receive(len(GREETING), deadline)
        if answer != GREETING:
            raise ChildError(f"answered {answer!r} instead of {GREETING!r}; print to standard error only")

    def step(self, scan: Scan) -> Tracks:
        """Send a scan and return the answer."""
        deadline, frame = time.monotonic() + self.limit_s, self._frame
        self._frame += 1
        self._process.send(scan_message(frame, scan), deadline)
        (length,) = LENGTH.unpack(self._process.receive(LENGTH.size, deadline))
        if length > ANSWER_MAX:
            raise ChildError(f"answered {length} bytes; does it print to standard output?")
        try:
            return tracks_of(self._process.receive(length, deadline), frame)
        except ValueError as error:
            raise ChildError(f"{error}; see docs/own-tracker.md") from error

    def finish(self) -> None:
        """Close the input after the last scan, and wait for the end of the program."""
        self._process.finish()

    def close(self) -> None:
        """Kill the program and its children, if they are still running."""
        self._process.close()


class ClassFactory:
    """Runs a class or function of the user in a process of its own, which later trackers of it use again.

    Parameters
    ----------
    spec
        `MODULE:NAME` or `FILE.py:NAME`.

    Raises
    ------
    DeviceError
        It cannot be imported.
    """

    def __init__(self, spec: str) -> None:
        self.spec, self._folder = spec, str(Path.cwd())
        place, _, name = spec.rpartition(":")
        file = Path(place).resolve()
        shown = file.relative_to(self._folder) if file.is_relative_to(self._folder) else file
        self._name = f"{shown}:{name}" if place.endswith(".py") else spec
        self._idle: list[ChildProcess] = []
        try:
            child, self.documentation = self._loaded()
        except ChildError as error:
            raise DeviceError(f"--tracker {spec}: {error}") from error
        self._idle.append(child)

    def start(self, config: TrackerConfig, limit_s: float) -> "ClassTracker":
        """Make a tracker."""
        child = self._idle.pop() if self._idle else self._loaded()[0]
        return ClassTracker(child, config, limit_s, self._idle)

    def _loaded(self) -> tuple[ChildProcess, str]:
        """Return a process that has imported the code, and the first line of the tracker's documentation."""
        child = child_process.python("luxloop.scenarios.run.tracker_server")
        try:
            _, body = _ask(child, ("load", (self.spec, self._folder)), time.monotonic() + IMPORT_TIMEOUT_S)
        except ChildTimeoutError as error:
            child.close()
            raise ChildError(
                f"its import took more than {IMPORT_TIMEOUT_S:g} s; leave slow work to its start"
            ) from error
        return child, body.decode(errors="replace")

    def __str__(self) -> str:
        return self._name


class ClassTracker:
    """A tracker in a process of Python."""

    def __init__(self, child: ChildProcess, config: TrackerConfig, limit_s: float, idle: list[ChildProcess]) -> None:
        self.limit_s = limit_s
        self._child, self._idle, self._finished = child, idle, False
        _ask(child, ("start", (config,)), time.monotonic() + limit_s)

    def step(self, scan: Scan) -> Tracks | tuple[Tracks, StepTrace]:
        """Send a scan and return the answer."""
        kind, body = _ask(self._child, ("step", (scan,)), time.monotonic() + self.limit_s)
        if kind is not Kind.OUTPUT:
            raise ChildError("answered without tracks")
        try:
            tracks, trace = decode(body)
        except ValueError as error:
            raise ChildError(str(error)) from error
        return (tracks, trace) if trace else tracks

    def finish(self) -> None:
        """Keep the process for the next tracker."""
        self._finished = True

    def close(self) -> None:
        """Kill the process, unless it finished."""
        if self._finished:
            self._idle.append(self._child)
        else:
            self._child.close()


def _ask(child: ChildProcess, request: tuple[str, tuple[object, ...]], deadline: float) -> tuple[Kind, bytes]:
    """Send a request to a process of `tracker_server`, and return the answer."""
    child.send(pickle.dumps(request, protocol=5), deadline)
    length, number = ANSWER.unpack(child.receive(ANSWER.size, deadline))
    if length > OUTPUT_MAX or number not in tuple(Kind):
        raise ChildError(f"answered {length} bytes of kind {number}")
    body, kind = child.receive(length, deadline), Kind(number)
    if kind is Kind.ERROR:
        raise ChildError(body[:TEXT_MAX].decode(errors="replace"))
    return kind, body
