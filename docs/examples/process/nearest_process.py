"""The tracker of docs/examples/ci/my_tracker.py in its own process.

luxloop run docs/examples/my-first.toml --tracker "process:python docs/examples/process/nearest_process.py"
"""

import struct
import sys
from pathlib import Path

import numpy as np

sys.path.append(str(Path(__file__).parents[1] / "ci"))

from my_tracker import Nearest

from luxloop.tracker.scan import Scan

COLUMNS = {"time_offset": "<f4", "echo_pulse_width": "<f4", "flags": "<u2", "unit": "u1", "layer": "u1", "echo": "u1"}


def messages(stream):
    """Yield the body of each message."""
    while head := stream.read(4):
        yield stream.read(struct.unpack("<I", head)[0])


def scan_of(body):
    """Return the frame and the scan of a message."""
    frame, count, time, *pose = struct.unpack_from("<II4d", body)
    at = struct.calcsize("<II4d")
    points = np.frombuffer(body, "<f4", 3 * count, at).reshape(3, count).T
    at, columns = at + 12 * count, {}
    for name, dtype in COLUMNS.items():
        columns[name] = np.frombuffer(body, dtype, count, at)
        at += columns[name].nbytes
    return frame, Scan.from_points(time, points, pose, **columns)


def answer(frame, tracks):
    """Return the message of the tracks."""
    x, y = tracks.center_odom.T
    vx, vy = tracks.mean[:, 2:4].T
    columns = [tracks.id.astype("<i8"), x, y, tracks.mean[:, 6], *tracks.size.T, vx, vy, tracks.status]
    body = struct.pack("<II", frame, len(tracks)) + b"".join(column.tobytes() for column in columns)
    return struct.pack("<I", len(body)) + body


def main(scans, results):
    """Greet, then answer each scan with its tracks."""
    results.write(scans.read(8))  # the greeting, LUXLOOP1
    results.flush()
    tracker = Nearest(None)
    for body in messages(scans):
        frame, scan = scan_of(body)
        results.write(answer(frame, tracker.step(scan)))
        results.flush()


main(sys.stdin.buffer, sys.stdout.buffer)
