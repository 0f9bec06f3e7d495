"""Format `ouster`: captures (PCAP with JSON metadata), read by the package ouster-sdk.

ouster-sdk 1.0.1 pins versions of other packages that exclude those of rerun-sdk, but runs with newer ones.
docs/recordings.md explains its installation.
"""

import json
import struct
from collections.abc import Iterator
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from luxloop.scenarios.errors import InputError
from luxloop.scenarios.files.input_file import require_plain
from luxloop.scenarios.recordings.formats.format_choice import readable
from luxloop.scenarios.recordings.sweep import PoseList, Sweep

if TYPE_CHECKING:
    from luxloop.scenarios.recordings.formats.format_choice import ReadOptions

RECORDING_SUFFIXES = (".pcap",)
EXTRA = "recordings"  # ouster-sdk imports rosbags
"""Extra of luxloop that installs some of the packages of this format."""
WHAT = "an Ouster capture"
INSTALL = "pip install --no-deps ouster-sdk==1.0.1"
VALID_SHARE = 0.5
"""Least share of the columns of a sweep; a capture may begin and end in the middle of one."""
NANOSECONDS = 1e-9
MAGIC = {b"\xd4\xc3\xb2\xa1": "<", b"\x4d\x3c\xb2\xa1": "<", b"\xa1\xb2\xc3\xd4": ">", b"\xa1\xb2\x3c\x4d": ">"}
"""Byte order by the first bytes of a classic PCAP file, with times in microseconds or nanoseconds."""
FILE_HEADER, PACKET_HEADER = 24, 16
FORMAT_TABLES = ("data_format", "lidar_data_format")
"""Tables of the metadata with the layout of packets; old firmware has it at the top."""
FORMAT_KEYS = ("columns_per_packet", "columns_per_frame", "pixels_per_column")
MOST_COLUMNS = 65_536


@dataclass(frozen=True, slots=True)
class OusterCapture:
    """A capture of one sensor, as a `RecordingSource`."""

    path: Path
    metadata: Path

    @property
    def count(self) -> int | None:
        """Not known before the packets are read."""
        return None

    def sweeps(self) -> Iterator[Sweep]:
        """Yield the sweeps; incomplete ones at the ends of the capture are left out."""
        with readable(self.path, WHAT):
            from ouster.sdk import open_source
            from ouster.sdk.core import XYZLut

            source = open_source(str(self.path), meta=[str(self.metadata)])
            info = source.sensor_info[0]
            place = XYZLut(info, use_extrinsics=False)
            for frames in source:
                for frame in frames:
                    if frame is not None and np.mean(_columns(frame)) >= VALID_SHARE:
                        yield _sweep(frame, place)

    def poses(self, name: str) -> PoseList:
        """Raise an InputError: a capture holds no poses."""
        raise InputError(f"{self.path}: {name}: an Ouster capture holds no poses; leave --odometry and --truth out")


def open_recording(paths: list[Path], options: "ReadOptions") -> OusterCapture:
    """Open a capture.

    Raises
    ------
    InputError
        ouster-sdk is missing, the files are damaged, or there is no metadata.
    """
    if len(paths) != 1:
        raise InputError(f"{paths[1]}: give one Ouster capture at a time")
    if find_spec("ouster") is None:
        raise InputError(f"{paths[0]}: reading Ouster captures needs ouster-sdk, which is not installed: {INSTALL}")
    path, described = paths[0], options.metadata or paths[0].with_suffix(".json")
    if not described.is_file():
        raise InputError(f"{described}: no such file; give the metadata of the sensor with --metadata")
    require_columns(described)
    _require_whole(path)
    return OusterCapture(path, described)


def require_columns(metadata: Path) -> None:
    """Raise an InputError for packets without columns, by whose number the library divides: it ends the process."""
    require_plain(metadata)
    with readable(metadata, "metadata of an Ouster sensor"):
        content = json.loads(metadata.read_text(encoding="utf-8"))
        for table in (content, *(content[key] for key in FORMAT_TABLES if key in content)):
            for key in FORMAT_KEYS:
                if key in table and not (isinstance(table[key], int) and 0 < table[key] <= MOST_COLUMNS):
                    raise InputError(f"{metadata}: {key} = {table[key]}: should be 1 to {MOST_COLUMNS}")


def _require_whole(path: Path) -> None:
    """Raise an InputError if a PCAP file ends within a packet: the library would read up to there without a word."""
    size, at = path.stat().st_size, FILE_HEADER
    with path.open("rb") as file:
        magic = file.read(4)
        order = MAGIC.get(magic)
        if order is None:
            raise InputError(
                f"{path}: is no PCAP file (it begins with {magic.hex()}); save captures as PCAP, not PCAPNG"
            )
        while at + PACKET_HEADER <= size:
            file.seek(at)
            at += PACKET_HEADER + struct.unpack(f"{order}8xI4x", file.read(PACKET_HEADER))[0]
    if at != size:
        raise InputError(f"{path}: ends within a packet, at byte {size}; it is truncated, copy it again")
    if at == FILE_HEADER:
        raise InputError(f"{path}: holds no packets; record the capture again")


def _columns(frame: Any) -> Any:
    """(W,) mask of the columns that were received: bit 0 of their status."""
    return (np.asarray(frame.status) & 1) == 1


def _sweep(frame: Any, place: Any) -> Sweep:
    """Return the points of all columns that were received, with the time of each column.

    Row 0 of a frame is the highest beam: rings are numbered from below.
    """
    ranges = np.asarray(frame.field("RANGE"))
    rows, width = ranges.shape
    valid = (ranges > 0) & _columns(frame)
    row, column = np.nonzero(valid)
    time_ns = np.asarray(frame.timestamp, dtype=np.int64)
    start_ns = int(time_ns[_columns(frame)].min())
    points = np.asarray(place(frame), dtype=np.float64).reshape(rows, width, 3)[valid]
    offset = NANOSECONDS * (time_ns[column] - start_ns).astype(np.float64)
    return Sweep(NANOSECONDS * start_ns, 0, points, offset, rows - 1 - row)
