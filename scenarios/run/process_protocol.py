"""Messages between a run and a tracker in its own process: little-endian columns, as in docs/other-trackers.md.

Both sides begin with `GREETING`. A message is its length in bytes (uint32, not counted) and a body.
"""

import struct

import numpy as np

from luxloop.tracker.records import Tracks
from luxloop.tracker.scan import Scan

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
