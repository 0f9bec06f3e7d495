"""A tracker in its own process: any program that reads scans from standard input and writes tracks.

It cannot reach the ground truth or the harness; it may crash, exit, print to standard error, or hang.

Messages are little-endian columns, as in docs/other-trackers.md. Both sides begin with `GREETING`. A message is its
length in bytes (uint32, not counted) and a body.
"""

import os
import select
import shlex
import shutil
import signal
import struct
import subprocess
import time
from contextlib import suppress
from pathlib import Path

import numpy as np

from luxloop.scenarios.errors import DeviceError
from luxloop.scenarios.run.containment import STEP_TIMEOUT_S, StepTimeoutError
from luxloop.tracker.records import Tracks
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
END_S = 5.0
"""Time for the process to end after its input is closed [s]."""
ANSWER_MAX = 10_000 * TRACK_BYTES
"""Longest answer [bytes]; a longer one is taken for text on standard output."""


class TrackerProcessError(Exception):
    """The process ended, or does not keep the protocol."""


class ProcessFactory:
    """Starts a command for each tracker; a `luxloop.scenarios.run.device.DeviceFactory`.

    Parameters
    ----------
    command
        Program and arguments, as in a shell, without shell syntax.

    Raises
    ------
    DeviceError
        There is no such program.
    """

    def __init__(self, command: str) -> None:
        try:
            self._arguments = shlex.split(command)
        except ValueError as error:
            raise DeviceError(f"--tracker {PREFIX}{command}: {error}; quote the command as for a shell") from error
        if not self._arguments or shutil.which(self._arguments[0]) is None:
            raise DeviceError(f"--tracker {PREFIX}{command}: no program {self._arguments[:1]}; give a path or a name")
        self._arguments[0] = str(shutil.which(self._arguments[0]))
        if os.sep in self._arguments[0]:
            self._arguments[0] = str(Path(self._arguments[0]).absolute())

    def __call__(self, _config: TrackerConfig) -> "ProcessTracker":
        """Start the command."""
        return ProcessTracker(self._arguments)

    def __str__(self) -> str:
        return f"{PREFIX}{shlex.join(self._arguments)}"


class ProcessTracker:
    """A running tracker.

    Parameters
    ----------
    arguments
        Program and arguments.

    Raises
    ------
    TrackerProcessError
        It does not answer the greeting.
    """

    def __init__(self, arguments: list[str]) -> None:
        self.limit_s = STEP_TIMEOUT_S
        """Limit of one answer [s]."""
        self._frame = 0
        self._process = subprocess.Popen(
            arguments, stdin=subprocess.PIPE, stdout=subprocess.PIPE, bufsize=0, start_new_session=True
        )
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        self._input, self._output = self._process.stdin.fileno(), self._process.stdout.fileno()
        for descriptor in (self._input, self._output):
            os.set_blocking(descriptor, False)
        try:
            self._exchange_greetings()
        except BaseException:
            self.close()
            raise

    def step(self, scan: Scan) -> Tracks:
        """Send a scan and return the answer."""
        deadline, frame = time.monotonic() + self.limit_s, self._frame
        self._frame += 1
        self._send(scan_message(frame, scan), deadline)
        (length,) = LENGTH.unpack(self._receive(LENGTH.size, deadline))
        if length > ANSWER_MAX:
            raise TrackerProcessError(f"answered {length} bytes; does it print to standard output?")
        try:
            return tracks_of(self._receive(length, deadline), frame)
        except ValueError as error:
            raise TrackerProcessError(f"{error}; see docs/other-trackers.md") from error

    def finish(self) -> None:
        """Close the input after the last scan, and wait for the end of the process.

        Raises
        ------
        TrackerProcessError
            It does not end, or with a code other than 0.
        """
        assert self._process.stdin is not None
        self._process.stdin.close()
        try:
            code = self._process.wait(END_S)
        except subprocess.TimeoutExpired as error:
            raise TrackerProcessError(f"was still running {END_S:g} s after its input was closed") from error
        if code:
            raise TrackerProcessError(self._ending())

    def close(self) -> None:
        """Kill the process and its children, if they are still running."""
        with suppress(ProcessLookupError):  # ended, with all its children
            os.killpg(self._process.pid, signal.SIGKILL)
        self._process.wait()
        for stream in (self._process.stdin, self._process.stdout):
            if stream:
                stream.close()

    def _exchange_greetings(self) -> None:
        deadline = time.monotonic() + self.limit_s
        self._send(GREETING, deadline)
        answer = self._receive(len(GREETING), deadline)
        if answer != GREETING:
            raise TrackerProcessError(f"answered {answer!r} instead of {GREETING!r}; print to standard error only")

    def _send(self, data: bytes, deadline: float) -> None:
        view = memoryview(data)
        while view:
            if self._wait([], [self._input], deadline):
                try:
                    view = view[os.write(self._input, view) :]
                except BrokenPipeError as error:
                    raise TrackerProcessError(self._ending()) from error

    def _receive(self, count: int, deadline: float) -> bytes:
        data = bytearray()
        while len(data) < count:
            if self._wait([self._output], [], deadline):
                part = os.read(self._output, count - len(data))
                if not part:
                    raise TrackerProcessError(self._ending())
                data += part
        return bytes(data)

    def _wait(self, readable: list[int], writable: list[int], deadline: float) -> bool:
        left = deadline - time.monotonic()
        if left <= 0:
            raise StepTimeoutError
        return any(select.select(readable, writable, [], left))

    def _ending(self) -> str:
        """Return how the process ended: it closed a pipe, so it has ended or is about to."""
        try:
            code = self._process.wait(1.0)
        except subprocess.TimeoutExpired:
            return "closed its standard input or output"
        return f"ended by signal {signal.Signals(-code).name}" if code < 0 else f"ended with exit code {code}"
